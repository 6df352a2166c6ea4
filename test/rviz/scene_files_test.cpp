#include "rviz/scene_files.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "clothsim/ros/scene_parameter.h"

namespace clothsim_rviz::scene_files_test {
namespace {

TEST(SceneFiles, TheFileOfAScene) {
  const std::string folder = CLOTHSIM_SCENES_DIR;
  const std::vector<std::string> files = {folder + "/arm.yaml", "/no/such.yaml",
                                          folder + "/sphere.yaml", folder + "/flag.yaml"};
  XmlRpc::XmlRpcValue scene = clothsim_ros::to_xml_rpc(YAML::LoadFile(files[2]));
  EXPECT_EQ(file_of(scene, files), files[2]);
  scene["cloth"]["ks"] = 499;
  EXPECT_EQ(file_of(scene, files), "");
  EXPECT_EQ(file_of(XmlRpc::XmlRpcValue(), files), "");
}

}  // namespace
}  // namespace clothsim_rviz::scene_files_test
