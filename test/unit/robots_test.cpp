// Robots in scenes: colliders of URDF links, and faults of URDFs.

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/shapes/mesh_file.h"
#include "clothsim/simulation/simulator.h"
#include "meshes.h"
#include "says.h"
#include "scene_text.h"
#include "temporary_folder.h"

namespace clothsim::robots_test {
namespace {

using namespace test;

/// Two links, the second turned and 1 m above the first, with a finger of a mesh.
const char* const arm = R"(<?xml version="1.0"?>
<robot name="arm">
  <link name="base">
    <visual><geometry><sphere radius="9"/></geometry></visual>
    <collision><geometry><cylinder radius="0.1" length="0.2"/></geometry></collision>
    <collision name="top"><origin xyz="0 0 0.3" rpy="0 1.5707963267948966 0"/>
      <geometry><box size="0.1 0.2 0.3"/></geometry></collision>
  </link>
  <link name="no_shape"/>
  <link name="tip">
    <collision><origin xyz="0.5 0 0"/>
      <geometry><mesh filename="finger.obj" scale="2 2 2"/></geometry></collision>
  </link>
  <joint name="up" type="revolute"><parent link="base"/><child link="no_shape"/>
    <origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/></joint>
  <joint name="on" type="fixed"><parent link="no_shape"/><child link="tip"/></joint>
</robot>)";

class Robots : public ::testing::Test {
 protected:
  Robots() { write_obj((folder_.path() / "finger.obj").string(), finger_soup()); }

  Scene read(const std::string& urdf, const std::string& more = "") {
    std::ofstream(folder_.path() / "arm.urdf") << urdf;
    return read_scene(YAML::Load("{cloth: {}, robots: [{file: arm.urdf" + more + "}]}"),
                      {folder_.path()});
  }
  std::string refusal(const std::string& urdf, const std::string& more = "") {
    try {
      read(urdf, more);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  }

  TemporaryFolder folder_{"robots"};
};

TEST_F(Robots, TheirCollisionsFollowTheLinks) {
  const Scene scene = read(arm, ", prefix: left_, friction: 0.7, pose: {xyz: [5, 0, 0]}");
  EXPECT_TRUE(scene.left_out.empty());
  ASSERT_EQ(scene.colliders.size(), 3u);
  const ColliderSpec &drum = scene.colliders[0], &box = scene.colliders[1],
                     &finger = scene.colliders[2];
  EXPECT_EQ(drum.name, "arm/left_base");
  EXPECT_EQ(box.name, "arm/left_base:2");
  EXPECT_EQ(finger.name, "arm/left_tip");
  EXPECT_EQ(drum.frame, "left_base");
  EXPECT_EQ(finger.frame, "left_tip");
  EXPECT_EQ(drum.shape, Shape(Cylinder{0.2, 0.1}));
  EXPECT_EQ(box.shape, Shape(Cuboid{{0.1, 0.2, 0.3}}));
  EXPECT_EQ(std::get<MeshShape>(finger.shape).file->scale, Vector3(2, 2, 2));
  EXPECT_EQ(drum.friction, 0.7);

  const Simulator simulator(scene);
  EXPECT_LT((simulator.collider_pose(1).position - Vector3(5, 0, 0.3)).norm(), 1e-12);
  EXPECT_LT((simulator.collider_pose(1).orientation * Vector3::UnitZ() - Vector3::UnitX()).norm(),
            1e-12);
  EXPECT_LT((simulator.collider_pose(2).position - Vector3(5, 0.5, 1)).norm(), 1e-12);
}

TEST_F(Robots, PaddingIsAllAround) {
  const Scene scene = read(arm, ", padding: 0.01");
  EXPECT_EQ(scene.colliders[0].shape, Shape(Cylinder{0.2 + 2 * 0.01, 0.1 + 0.01}));
  EXPECT_LT((std::get<Cuboid>(scene.colliders[1].shape).size - Vector3(0.12, 0.22, 0.32)).norm(),
            1e-12);
  EXPECT_EQ(std::get<MeshShape>(scene.colliders[2].shape).padding, 0.01);
}

TEST_F(Robots, OfSomeLinks) {
  EXPECT_EQ(read(arm, ", links: [tip]").colliders.size(), 1u);
  EXPECT_EQ(read(arm, ", links: []").colliders.size(), 0u);
  EXPECT_EQ(read(arm, ", links: all, name: other").colliders[0].name, "other/base");
  EXPECT_TRUE(says(refusal(arm, ", links: [tip, thumb]"),
                   "robots.0.links.1: got \"thumb\" ... base, no_shape, tip"));
}

TEST_F(Robots, DescriptionsAreAskedFor) {
  const auto read_by = [&](const std::string& robot, bool in_ros) {
    SceneSources sources{folder_.path()};
    if (in_ros) {
      sources.description = [](const std::string& name) {
        if (name != "/robot_description") throw InvalidValue({}, "nothing", "a parameter");
        return std::string(arm);
      };
    }
    try {
      read_scene(YAML::Load("{cloth: {}, robots: [" + robot + "]}"), sources);
    } catch (const InvalidValue& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(read_by("{description: /robot_description}", true), "accepted");
  EXPECT_TRUE(says(read_by("{description: /other}", true),
                   "robots.0.description: got nothing ... parameter"));
  EXPECT_NE(read_by("{description: /robot_description}", false).find("outside of ROS"),
            std::string::npos);
  EXPECT_NE(read_by("{}", true).find("robots.0.description: got nothing"), std::string::npos);
  EXPECT_NE(read_by("{description: /robot_description, file: arm.urdf}", true).find("a file, too"),
            std::string::npos);
  // Two links with one name would be the same in messages.
  EXPECT_TRUE(
      says(read_by("{description: /robot_description}, {description: /robot_description}", true),
           "robots.1.name: got \"arm/base\" ... again ... prefix"));
  EXPECT_EQ(read_by("{description: /robot_description}, {description: /robot_description, "
                    "prefix: right_}",
                    true),
            "accepted");
}

/// The arm with one more link, of this collision.
std::string with_collision(const std::string& inside) {
  std::string urdf = arm;
  urdf.insert(urdf.find("<link name=\"tip\">"),
              "<link name=\"bad\"><collision>" + inside + "</collision></link>");
  return urdf;
}

TEST_F(Robots, WhatCannotBeUsedIsLeftOutWithLinkAndReason) {
  TriangleSoup open = box_soup({1, 1, 1});
  open.triangles.pop_back();
  write_obj((folder_.path() / "open.obj").string(), open);
  const std::pair<const char*, const char*> faults[] = {
      {"<geometry><box size='0 1 1'/></geometry>", "not above 0"},
      {"<geometry><box size='1 1'/></geometry>", "3 finite numbers"},
      {"<geometry><box/></geometry>", "is nothing, not 3"},
      {"<geometry><sphere radius='nan'/></geometry>", "finite number"},
      {"<geometry><sphere radius='-1'/></geometry>", "not above 0"},
      {"<geometry><sphere radius='1e300'/></geometry>", "radius"},
      {"<geometry><cylinder radius='1'/></geometry>", "length of <cylinder> is nothing"},
      {"<geometry><cone/></geometry>", "<cone>"},
      {"<geometry/>", "no geometry"},
      {"", "no geometry"},
      {"<origin xyz='nan 0 0'/><geometry><sphere radius='1'/></geometry>", "xyz of <origin>"},
      {"<origin rpy='0 inf 0'/><geometry><sphere radius='1'/></geometry>", "rpy of <origin>"},
      {"<origin xyz='1e9 0 0'/><geometry><sphere radius='1'/></geometry>", "xyz"},
      {"<geometry><mesh/></geometry>", "no filename"},
      {"<geometry><mesh filename='none.stl'/></geometry>", "No such file"},
      {"<geometry><mesh filename='package://no_such_package/a.stl'/></geometry>",
       "the package no_such_package"},
      {"<geometry><mesh filename='http://a/b.stl'/></geometry>", "package://, file://"},
      {"<geometry><mesh filename='finger.obj' scale='0 1 1'/></geometry>", "scale.0: got 0"},
      {"<geometry><mesh filename='open.obj'/></geometry>", "a hole at the edge"},
  };
  for (const auto& [collision, reason] : faults) {
    const Scene scene = read(with_collision(collision));
    EXPECT_EQ(scene.colliders.size(), 3u) << collision;
    ASSERT_EQ(scene.left_out.size(), 1u) << collision;
    EXPECT_EQ(scene.left_out[0].rfind("arm/bad", 0), 0u) << scene.left_out[0];
    EXPECT_NE(scene.left_out[0].find(reason), std::string::npos) << scene.left_out[0];
  }
}

TEST_F(Robots, OneWithoutCollisionsIsTold) {
  const Scene scene = read(
      "<robot name='ghost'><link name='base'><visual><geometry><sphere radius='1'/></geometry>"
      "</visual></link></robot>");
  EXPECT_TRUE(scene.colliders.empty());
  ASSERT_EQ(scene.left_out.size(), 1u);
  EXPECT_EQ(scene.left_out[0].rfind("ghost: got links without <collision>", 0), 0u)
      << scene.left_out[0];
}

TEST_F(Robots, WhatIsNoUrdfIsRefused) {
  const auto joint = [](const std::string& parent, const std::string& child) {
    return "<joint name='j'><parent link='" + parent + "'/><child link='" + child + "'/></joint>";
  };
  const std::pair<std::string, const char*> faults[] = {
      {"", "the XML of a URDF"},
      {"rubbish", "the XML of a URDF"},
      {"<robot><link name='a'>", "the XML of a URDF"},
      {"<rdf/>", "without <robot>"},
      {"<sdf/>", "an SDF without errors"},
      {"<robot><link/></robot>", "without a name"},
      {"<robot><link name='a'/><link name='a'/></robot>", "two links called"},
      {"<robot><link name='a'/>" + joint("a", "b") + "</robot>", "child \"b\""},
      {"<robot><link name='a'/><joint/></robot>", "parent nothing"},
      {"<robot><link name='a'/><link name='b'/>" + joint("a", "b") + joint("b", "a") + "</robot>",
       "in a circle"},
      {"<robot><link name='a'/><link name='b'/>" + joint("a", "b") + joint("a", "b") + "</robot>",
       "a second one"},
      {"<robot><!--" + std::string(17'000'000, 'x') + "--></robot>", "bytes"},
  };
  for (const auto& [urdf, reason] : faults) {
    const std::string message = refusal(urdf);
    EXPECT_EQ(message.rfind("robots.0.file: ", 0), 0u) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
    EXPECT_LT(message.size(), 500u);
  }
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  EXPECT_NE(refusal("<robot>" + deep), "accepted");
  EXPECT_EQ(refusal("<robot/>"), "accepted") << "it has no links";
}

TEST_F(Robots, ClothRestsOnShellsOfAFileThatOverlap) {
  const TriangleSoup ball = ball_soup(0.15, 24, 12);
  write_obj((folder_.path() / "finger.obj").string(),
            together({moved(ball, {-0.06, 0, 0}), moved(ball, {0.06, 0.01, 0})}));
  const std::string balls =
      "<robot name='arm'><link name='tip'><collision><geometry><mesh filename='finger.obj'/>"
      "</geometry></collision><collision><geometry><sphere radius='0.1'/></geometry></collision>"
      "</link></robot>";
  Scene scene = read(balls);
  ASSERT_EQ(scene.colliders.size(), 3u);
  EXPECT_EQ(scene.colliders[0].name, "arm/tip");
  EXPECT_EQ(scene.colliders[1].name, "arm/tip:2");
  EXPECT_EQ(scene.colliders[2].name, "arm/tip:3");

  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.width = scene.cloth.height = 0.5;
  scene.cloth.orientation = Orientation::horizontal;
  scene.cloth.origin = Vector3(-0.25, -0.25, 0.2);
  Simulator simulator(scene);
  for (int frame = 0; frame < 2 * 90; ++frame) simulator.step();
  const Points& velocities = simulator.state().velocities;
  EXPECT_LT(velocities.rowwise().norm().maxCoeff(), 0.2) << "of one solid, tens of m/s for ever";
}

}  // namespace
}  // namespace clothsim::robots_test
