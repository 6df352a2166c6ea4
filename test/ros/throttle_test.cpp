#include <gtest/gtest.h>

#include "clothsim/ros/rates.h"

namespace clothsim_ros::throttle_test {
namespace {

TEST(Throttle, LetsTheFirstThroughAndThenOneAPeriod) {
  ros::Time::init();
  ros::Time::setNow(ros::Time(0));  // simulated time has not begun
  Throttle hour(ros::WallDuration(3600));
  EXPECT_TRUE(hour.passes());
  EXPECT_FALSE(hour.passes());
  ros::Time::setNow(ros::Time(1e6));
  EXPECT_FALSE(hour.passes());

  const ros::WallDuration period(0.05);
  Throttle brief(period);
  EXPECT_TRUE(brief.passes());
  period.sleep();
  EXPECT_TRUE(brief.passes());
}

}  // namespace
}  // namespace clothsim_ros::throttle_test
