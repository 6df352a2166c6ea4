#include "clothsim/ros/scene_parameter.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "clothsim/ros/parameters.h"
#include "clothsim/scene/scene_yaml.h"
#include "says.h"

namespace clothsim_ros::scene_parameter_test {
namespace {

using XmlRpc::XmlRpcValue;

XmlRpcValue parameter(const std::string& yaml) { return to_xml_rpc(YAML::Load(yaml)); }

TEST(SceneParameter, ScalarsAreWhatTheyLookLike) {
  EXPECT_EQ(parameter("-7"), XmlRpcValue(-7));
  EXPECT_EQ(parameter("50.0"), XmlRpcValue(50.0));
  EXPECT_EQ(parameter("3000000000"), XmlRpcValue(3e9));  // an int beyond XML-RPC's
  EXPECT_EQ(parameter("true"), XmlRpcValue(true));
  EXPECT_EQ(parameter("off"), XmlRpcValue(false));
  EXPECT_EQ(parameter("y"), XmlRpcValue(std::string("y")));
  EXPECT_EQ(parameter("rod"), XmlRpcValue(std::string("rod")));
  EXPECT_EQ(parameter("'7'"), XmlRpcValue(std::string("7")));
}

TEST(SceneParameter, ListsAndMaps) {
  XmlRpcValue value = parameter("{a: [1, 2.5, [x]], b: {}, c: []}");
  ASSERT_EQ(value.getType(), XmlRpcValue::TypeStruct);
  EXPECT_EQ(value["a"][1], XmlRpcValue(2.5));
  EXPECT_EQ(value["a"][2][0], XmlRpcValue(std::string("x")));
  EXPECT_EQ(value["b"].getType(), XmlRpcValue::TypeStruct);
  EXPECT_EQ(value["c"].getType(), XmlRpcValue::TypeArray);
  EXPECT_EQ(value["c"].size(), 0);
}

TEST(SceneParameter, RefusesNothing) {
  EXPECT_THROW(parameter("{a: }"), YAML::Exception);
  EXPECT_THROW(parameter(""), YAML::Exception);
}

TEST(SceneParameter, TheNodeReadsAllScenesThatTheListHas) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(CLOTHSIM_SCENES_DIR)) {
    if (file.path().extension() != ".yaml") continue;
    const YAML::Node scene = YAML::LoadFile(file.path());
    EXPECT_NO_THROW(clothsim::read_scene(clothsim_ros::to_yaml(to_xml_rpc(scene)))) << file.path();
    ++count;
  }
  EXPECT_GT(count, 10);
}

/// The message that refuses a file.
std::string refusal(const std::string& file) {
  try {
    read_scene_file(file);
  } catch (const clothsim::InvalidValue& error) {
    return error.message("/clothsim/", "/");
  }
  return "accepted";
}

TEST(SceneParameter, FilesThatAreNoScenesAreTold) {
  using clothsim::says;
  EXPECT_TRUE(
      says(refusal("/no/such.yaml"), "/clothsim/scene_file: got \"/no/such.yaml\" ... not there"));
  EXPECT_TRUE(
      says(refusal("package://no_such/a.yaml"), "/clothsim/scene_file: got the package no_such"));
  for (const char* name : {"my.yaml", "/etc/passwd", "/tmp", "http://a/b.yaml"}) {
    EXPECT_TRUE(says(refusal(name), "/clothsim/scene_file: got \"" + std::string(name) + '"'));
  }
}

TEST(SceneParameter, PackagesAreFound) {
  const GivenScene given = read_scene_file("package://clothsim/config/scenes/towel.yaml");
  EXPECT_EQ(given.scene.cloth.width, 0.4);
  EXPECT_TRUE(given.file.is_absolute());
}

}  // namespace
}  // namespace clothsim_ros::scene_parameter_test
