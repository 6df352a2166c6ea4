// Which displacements of a tf frame count as jumps, and which as motion.

#include <gtest/gtest.h>

#include "clothsim/ros/jumps.h"

namespace clothsim_ros::jump_watch_test {
namespace {

constexpr double jump_speed = 15;  // [m/s]
constexpr double frame = 1.0 / 90;

/// Jumps among transforms that come every `every` frames, each farther by `way`.
int jumps_in(JumpWatch& watch, double way, int every, int times = 20) {
  int jumps = 0;
  for (int i = 0; i < times; ++i) {
    for (int k = 1; k < every; ++k) EXPECT_FALSE(watch.jumps(0, frame));
    if (watch.jumps(way, frame)) ++jumps;
  }
  return jumps;
}

void stand(JumpWatch& watch, int frames = 90) {
  for (int i = 0; i < frames; ++i) EXPECT_FALSE(watch.jumps(0, frame));
}

TEST(JumpWatch, TakesMotionForMotion) {
  for (const double speed : {0.1, 1.0, 10.0}) {
    JumpWatch watch(jump_speed);
    EXPECT_EQ(jumps_in(watch, speed * frame, 1), 0) << speed;
  }
}

TEST(JumpWatch, TellsJumpsFromRest) {
  JumpWatch watch(jump_speed);
  for (const double way : {0.2, 0.5, 1.0, 1000.0}) {
    stand(watch);
    EXPECT_TRUE(watch.jumps(way, frame)) << way;
  }
  stand(watch);
  EXPECT_FALSE(watch.jumps(0.12, frame));
}

TEST(JumpWatch, TellsJumpsFromSlowMotion) {
  JumpWatch watch(jump_speed);
  EXPECT_EQ(jumps_in(watch, 1 * frame, 1), 0);
  EXPECT_TRUE(watch.jumps(0.2, frame));
  EXPECT_EQ(jumps_in(watch, 1 * frame, 1), 0);
  EXPECT_TRUE(watch.jumps(0.2, frame));
}

TEST(JumpWatch, FollowsTransformsThatComeSeldom) {
  for (const int every : {3, 9, 10}) {  // of 30, 10 and 9 Hz
    JumpWatch watch(jump_speed);
    EXPECT_EQ(jumps_in(watch, 1 * every * frame, every), 0) << every;
    // The start of the motion looks like a jump.
    EXPECT_EQ(jumps_in(watch, 10 * every * frame, every), 1) << every;
    EXPECT_EQ(jumps_in(watch, 10 * every * frame, every), 0) << every;
    stand(watch);
    EXPECT_EQ(jumps_in(watch, 10 * every * frame, every), 1) << every;
  }
}

TEST(JumpWatch, FollowsTransformsThatComeInBunches) {
  JumpWatch watch(jump_speed);
  const double way = 10 * frame;
  EXPECT_EQ(jumps_in(watch, way, 1), 0);
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(watch.jumps(2 * way, frame));
    EXPECT_FALSE(watch.jumps(0, frame));
    EXPECT_FALSE(watch.jumps(way, frame));
    stand(watch, 3);
    EXPECT_FALSE(watch.jumps(4 * way, frame));
    EXPECT_FALSE(watch.jumps(way, frame));
  }
}

TEST(JumpWatch, FollowsMotionThatSpeedsUp) {
  JumpWatch watch(jump_speed);
  for (double speed = 1; speed < 500; speed *= 1.5) EXPECT_FALSE(watch.jumps(speed * frame, frame));
}

TEST(JumpWatch, KnowsFramesOfAllLengths) {
  JumpWatch fine(jump_speed);
  for (int i = 0; i < 100; ++i) {  // 1 m/s in transforms of 30 Hz, frames of 1 kHz
    for (int k = 1; k < 33; ++k) EXPECT_FALSE(fine.jumps(0, 0.001));
    EXPECT_FALSE(fine.jumps(0.033, 0.001));
  }
  JumpWatch coarse(jump_speed);
  EXPECT_FALSE(coarse.jumps(10, 1));
  EXPECT_FALSE(coarse.jumps(25, 1));
  EXPECT_TRUE(coarse.jumps(200, 1));
}

}  // namespace
}  // namespace clothsim_ros::jump_watch_test
