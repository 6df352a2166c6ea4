#include "clothsim/ros/names.h"

#include <gtest/gtest.h>

namespace clothsim_ros::names_test {
namespace {

std::vector<clothsim::ColliderSpec> named(const std::vector<std::string>& names) {
  std::vector<clothsim::ColliderSpec> colliders(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) colliders[i].name = names[i];
  return colliders;
}

TEST(RosNames, OfCollidersStandAsTheyAreWhereTheyMay) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(ros_names(named({"left pad", "left_pad", "left-pad"})),
            (Names{"left_pad_", "left_pad", "left_pad__"}));
  EXPECT_EQ(ros_names(named({"arm/link:2", "3", "cloth"}), {"cloth"}),
            (Names{"arm_link_2", "collider_3", "cloth_"}));
}

TEST(RosNames, OfClothsStandAsTheyAreWhereTheyMay) {
  std::vector<clothsim::ClothPart> cloths(3);
  cloths[0].name = "3";
  cloths[1].name = "cloth";
  cloths[2].name = "t-shirt";
  EXPECT_EQ(ros_names(cloths), (std::vector<std::string>{"cloth_3", "cloth", "t_shirt"}));
  EXPECT_EQ(ros_names(cloths, {"cloth"}),
            (std::vector<std::string>{"cloth_3", "cloth_", "t_shirt"}));
}

}  // namespace
}  // namespace clothsim_ros::names_test
