#include "clothsim/scene/sdf.h"

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/scene/kinematics.h"
#include "clothsim/scene/scene_yaml.h"
#include "temporary_folder.h"

namespace clothsim::sdf_test {
namespace {

std::string sdf(const std::string& content) {
  return "<sdf version='1.7'><model name='thing'>" + content + "</model></sdf>";
}

std::string box(const std::string& size, const std::string& pose = "0 0 0 0 0 0") {
  return "<collision name='shape'><pose>" + pose + "</pose><geometry><box><size>" + size +
         "</size></box></geometry></collision>";
}

std::string inertial(const std::string& mass, const std::string& pose = "0 0 0 0 0 0") {
  return "<inertial><pose>" + pose + "</pose><mass>" + mass +
         "</mass><inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.025</izz></inertia></inertial>";
}

std::string link(const std::string& name, const std::string& content,
                 const std::string& pose = "0 0 0 0 0 0") {
  return "<link name='" + name + "'><pose>" + pose + "</pose>" + content + "</link>";
}

/// A cabinet that stands at (0, 1, 0.5), with a drawer and a door whose frame is in its middle.
std::string cabinet() {
  return sdf(
      "<pose>0 1 0.5 0 0 0</pose>" + link("cabinet", box("0.5 0.5 1")) +
      link("drawer", inertial("1.5") + box("0.4 0.4 0.2"), "0 0 0.3 0 0 1.5707963267948966") +
      link("door", inertial("2", "0 0 0.1 0 0 0") + box("0.4 0.02 0.5"), "0 0.25 -0.2 0 0 0") +
      "<joint name='stand' type='fixed'><parent>world</parent><child>cabinet</child></joint>"
      "<joint name='rail' type='prismatic'><parent>cabinet</parent><child>drawer</child><axis>"
      "<xyz>0 1 0</xyz><limit><lower>0</lower><upper>0.35</upper></limit></axis></joint>"
      "<joint name='hinge' type='revolute'><pose>-0.2 0 0 0 0 0</pose><parent>cabinet</parent>"
      "<child>door</child><axis><xyz>0 0 1</xyz><limit><lower>-1.6</lower><upper>0</upper>"
      "</limit></axis></joint>");
}

/// The colliders of a scene with the model of a text.
std::vector<ColliderSpec> colliders_of(const std::string& text, bool bodies = true) {
  const test::TemporaryFolder folder("sdf");
  std::ofstream(folder.path() / "model.sdf") << text;
  const std::string with = bodies ? "true" : "false";
  return read_scene(YAML::Load("{cloth: {}, robots: [{file: model.sdf, bodies: " + with + "}]}"),
                    {folder.path()})
      .colliders;
}

std::string refusal(const std::string& text) {
  try {
    colliders_of(text);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "none";
}

TEST(Sdf, ALinkIsAFreeBodyWithItsMass) {
  const std::vector<ColliderSpec> mug = colliders_of(
      sdf(link("mug", inertial("0.3", "0 0 0.05 0 0 0") + box("0.08 0.08 0.1", "0 0 0.05 0 0 0"),
               "1 2 3 0 0 0")));
  ASSERT_EQ(mug.size(), 1u);
  ASSERT_TRUE(mug[0].body);
  EXPECT_EQ(mug[0].name, "thing/mug");
  EXPECT_EQ(mug[0].body->mass, 0.3);
  EXPECT_LT(mug[0].body->center_of_mass->norm(), 1e-15);  // that of the shape
  EXPECT_LT((mug[0].body->inertia->diagonal() - Vector3(0.01, 0.02, 0.025)).norm(), 1e-15);
  EXPECT_LT(((mug[0].pose * mug[0].offset).position - Vector3(1, 2, 3.05)).norm(), 1e-15);
  EXPECT_FALSE(mug[0].body->joint);
}

TEST(Sdf, MovableJointsLeadToBodies) {
  const std::vector<ColliderSpec> colliders = colliders_of(cabinet());
  ASSERT_EQ(colliders.size(), 3u);
  EXPECT_FALSE(colliders[0].body);  // it stands
  ASSERT_TRUE(colliders[1].body && colliders[1].body->joint);
  EXPECT_EQ(colliders[1].body->mass, 1.5);
  const Joint& slider = *colliders[1].body->joint;
  EXPECT_EQ(slider.kind, Joint::Kind::slider);
  EXPECT_LT((slider.axis - Vector3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(slider.upper, 0.35);
  ASSERT_TRUE(colliders[2].body && colliders[2].body->joint);
  EXPECT_LT((*colliders[2].body->center_of_mass - Vector3(0, 0, 0.1)).norm(), 1e-12);
  EXPECT_LT((colliders[2].pose.position - Vector3(0, 1.25, 0.3)).norm(), 1e-12);
  const Joint& hinge = *colliders[2].body->joint;
  EXPECT_EQ(hinge.kind, Joint::Kind::hinge);
  EXPECT_LT((hinge.point - Vector3(-0.2, 1.25, 0.3)).norm(), 1e-12);
  EXPECT_EQ(hinge.lower, -1.6);
}

TEST(Sdf, AStaticModelStays) {
  const std::string shelf = link("shelf", inertial("1") + box("1 1 1"), "0 0 2 0 0 0");
  EXPECT_TRUE(colliders_of(sdf(shelf))[0].body);
  const ColliderSpec stays = colliders_of(sdf("<static>true</static>" + shelf))[0];
  EXPECT_FALSE(stays.body);
  EXPECT_EQ(stays.pose.position, Vector3(0, 0, 2));
}

TEST(Sdf, WithoutBodiesLinksFollowFrames) {
  const std::vector<ColliderSpec> colliders = colliders_of(cabinet(), false);
  ASSERT_EQ(colliders.size(), 3u);
  EXPECT_EQ(colliders[2].frame, "door");
  EXPECT_FALSE(colliders[2].body);
}

TEST(Sdf, JointsTurnAboutTheirOwnFrames) {
  const Kinematics kinematics(read_urdf(cabinet()));
  const auto poses = kinematics.poses({{"hinge", -M_PI / 2}, {"rail", 0.1}});
  EXPECT_LT((poses.at("door").position - Vector3(-0.2, 1.05, 0.3)).norm(), 1e-12);
  EXPECT_LT((poses.at("drawer").position - Vector3(-0.1, 1, 0.8)).norm(), 1e-12);
}

TEST(Sdf, AllShapesAreRead) {
  const auto shape = [](const std::string& name, const std::string& geometry) {
    return "<collision name='" + name + "'><geometry>" + geometry + "</geometry></collision>";
  };
  const std::string size = "<radius>0.1</radius>", length = "<length>0.3</length>";
  const Urdf urdf =
      read_sdf(sdf(link("all", shape("a", "<sphere>" + size + "</sphere>") +
                                   shape("b", "<cylinder>" + size + length + "</cylinder>") +
                                   shape("c", "<capsule>" + size + length + "</capsule>") +
                                   shape("d", "<mesh><uri>model://mug/mug.stl</uri></mesh>") +
                                   shape("e", "<plane><normal>0 0 1</normal></plane>") +
                                   shape("f", "<sphere><radius>-1</radius></sphere>"))));
  const std::vector<Urdf::Collision>& found = urdf.links[1].collisions;
  ASSERT_EQ(found.size(), 6u);
  EXPECT_EQ(std::get<Sphere>(found[0].geometry).radius, 0.1);
  EXPECT_EQ(std::get<Cylinder>(found[1].geometry).length, 0.3);
  EXPECT_EQ(std::get<Capsule>(found[2].geometry).radius, 0.1);
  EXPECT_EQ(std::get<Urdf::Mesh>(found[3].geometry).file, "../mug/mug.stl");
  EXPECT_EQ(found[4].fault, "it is no box, sphere, cylinder, capsule or mesh");
  EXPECT_EQ(found[5].fault, "radius of <sphere> is -1, not above 0");
}

TEST(Sdf, IsRefusedWithTheReason) {
  EXPECT_EQ(refusal("<sdf version='1.7'><world name='w'/></sdf>"),
            "robots.0.file: got an SDF without <model>, expected a model");
  const std::string part = inertial("1") + box("1 1 1");
  EXPECT_EQ(refusal(sdf(link("a", box("1 1 1")))),
            "robots.0.bodies: got link a without <inertial>, expected a mass for each link that "
            "moves");
  EXPECT_EQ(refusal(sdf(link("a", "<inertial><mass>0.3</mass></inertial>" + box("1 1 1")))),
            "robots.0.bodies: got link a without <inertial>, expected a mass for each link that "
            "moves");
  EXPECT_EQ(refusal("<sdf version='1.7'><model name='m' placement_frame='a'>" + link("a", part) +
                    "</model></sdf>"),
            "robots.0.file: got a model placed by another frame, expected a <pose> of the model "
            "itself");
  const auto joint = [](const std::string& type, const std::string& parent) {
    return "<joint name='j' type='" + type + "'><parent>" + parent +
           "</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>";
  };
  EXPECT_EQ(refusal(sdf(link("b", part) + joint("ball", "world"))),
            "robots.0.bodies: got joint j of type ball, expected a fixed, floating, prismatic, "
            "revolute or continuous joint");
  EXPECT_EQ(refusal(sdf(link("a", part) + link("b", part) + joint("revolute", "a"))),
            "robots.0.bodies: got joint j, whose parent a moves, expected movable joints on links "
            "that stay");
  EXPECT_NE(refusal(sdf(link("b", part) + joint("revolute", "nobody"))).find("nobody"),
            std::string::npos);
  EXPECT_NE(refusal(sdf(link("a", part) + link("b", part) + joint("revolute", "a") +
                        "<joint name='k' type='fixed'><parent>b</parent><child>a</child></joint>"))
                .find("in a circle"),
            std::string::npos);
  EXPECT_NE(refusal("<sdf version='1.7'><model name='m'>").find("got"), std::string::npos);
}

}  // namespace
}  // namespace clothsim::sdf_test
