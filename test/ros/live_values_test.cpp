// Reasons for which a change of live values is refused, and their form in the log.

#include "clothsim/ros/live_values.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace clothsim_ros::live_values_test {
namespace {

TEST(LiveValues, AreRefusedByWhateverIsThrown) {
  EXPECT_FALSE(refusal([] {}, "/clothsim"));
  EXPECT_EQ(refusal(
                [] {
                  throw clothsim::InvalidValue({"cloth", "ks"}, "-5", "more");
                },
                "/clothsim"),
            "/clothsim/ks: got -5, expected more");
  EXPECT_EQ(refusal([] { throw std::runtime_error("no more memory"); }, "/clothsim/light"),
            "/clothsim/light: no more memory");
}

}  // namespace
}  // namespace clothsim_ros::live_values_test
