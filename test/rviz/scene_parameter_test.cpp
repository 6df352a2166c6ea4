#include "rviz/scene_parameter.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "clothsim/ros/parameters.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim_rviz {
namespace {

using XmlRpc::XmlRpcValue;

XmlRpcValue parameter(const std::string& yaml) { return to_xml_rpc(YAML::Load(yaml)); }

TEST(SceneParameter, ScalarsAreWhatTheyLookLike) {
  EXPECT_EQ(parameter("-7"), XmlRpcValue(-7));
  EXPECT_EQ(parameter("50.0"), XmlRpcValue(50.0));
  EXPECT_EQ(parameter("3000000000"), XmlRpcValue(3e9));  // no int of XML-RPC
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

TEST(SceneParameter, AFileThatIsNotThereIsTold) {
  EXPECT_NE(load_scene("/clothsim", "/no/such.yaml").find("/no/such.yaml"), std::string::npos);
}

}  // namespace
}  // namespace clothsim_rviz
