#include "clothsim/ros/pacer.h"

#include <gtest/gtest.h>

namespace clothsim_ros::pacer_test {
namespace {

constexpr double frame = 0.01;  // [s]

/// The test sets ROS time.
class PacerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { ros::Time::init(); }

  static void set_time(double seconds) { ros::Time::setNow(ros::Time(seconds)); }

  /// Frames that are due now, each computed.
  static int run_due(Pacer& pacer) {
    int frames = 0;
    while (pacer.until_due(frame).isZero()) {
      last_stamp = pacer.advance(frame);
      ++frames;
    }
    return frames;
  }

  static inline ros::Time last_stamp;
};

TEST_F(PacerTest, WaitsUntilTimeBegins) {
  Pacer pacer(1, false);
  set_time(0);
  EXPECT_GT(pacer.until_due(frame).toSec(), 0);
  set_time(50);
  EXPECT_EQ(run_due(pacer), 0);
  set_time(50.0101);
  EXPECT_EQ(run_due(pacer), 1);
  EXPECT_NEAR(last_stamp.toSec(), 50.01, 1e-6);
}

TEST_F(PacerTest, OneFramePerPeriodWhateverTheTicks) {
  for (const double factor : {0.25, 1.0, 4.0}) {
    Pacer pacer(factor, false);
    set_time(10);
    int frames = run_due(pacer);
    for (int tick = 1; tick <= 20; ++tick) {
      set_time(10 + 0.1 * tick + 1e-6);
      frames += run_due(pacer);
    }
    EXPECT_EQ(frames, static_cast<int>(2 * factor / frame)) << factor;
    EXPECT_NEAR(last_stamp.toSec(), 12, 1e-6);
  }
}

TEST_F(PacerTest, TellsAClockThatJumpsAhead) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(10.4);  // a tick
  run_due(pacer);
  EXPECT_FALSE(pacer.has_jumped());
  set_time(3610);
  EXPECT_LE(run_due(pacer), 1);
  EXPECT_TRUE(pacer.has_jumped());
  EXPECT_FALSE(pacer.has_jumped());  // reported once
  ros::WallDuration(0.05).sleep();
  set_time(3612);  // a fast clock, or a slow computer
  run_due(pacer);
  EXPECT_FALSE(pacer.has_jumped());
}

TEST_F(PacerTest, StandsStillWithTime) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(10.05001);
  EXPECT_EQ(run_due(pacer), 5);
  EXPECT_EQ(run_due(pacer), 0);
}

TEST_F(PacerTest, StartsAgainWhenFarBehind) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(100);
  EXPECT_EQ(run_due(pacer), 1);
  EXPECT_NEAR(last_stamp.toSec(), 100, 1e-6);
  set_time(100.02001);
  EXPECT_EQ(run_due(pacer), 2);
}

TEST_F(PacerTest, StartsAgainWhenTimeRunsBack) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(10.1);
  run_due(pacer);
  set_time(5);
  EXPECT_EQ(run_due(pacer), 0);
  set_time(5.01001);
  EXPECT_EQ(run_due(pacer), 1);
  EXPECT_NEAR(last_stamp.toSec(), 5.01, 1e-6);
}

TEST_F(PacerTest, StartsAgainAfterAJumpBeyondADuration) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(3e9);
  EXPECT_EQ(run_due(pacer), 1);
  EXPECT_NEAR(last_stamp.toSec(), 3e9, 1e-6);
  set_time(5);
  EXPECT_EQ(run_due(pacer), 0);
  set_time(5.01001);
  EXPECT_EQ(run_due(pacer), 1);
}

TEST_F(PacerTest, StampsEndWithTime) {
  ros::Time::setNow(ros::Time(ros::TIME_MAX.sec, 0));
  for (const double factor : {0.0, 0.001, 1.0}) {
    Pacer pacer(factor, false);
    pacer.until_due(frame);
    ros::Time stamp;
    for (int i = 0; i < 200; ++i) stamp = pacer.advance(frame);
    EXPECT_EQ(stamp, factor == 0 ? ros::Time::now() : ros::TIME_MAX) << factor;
  }
}

TEST_F(PacerTest, AfterAPauseTheNextFrameIsAPeriodAway) {
  Pacer pacer(1, false);
  set_time(10);
  run_due(pacer);
  set_time(10.1);
  pacer.restart();
  EXPECT_EQ(run_due(pacer), 0);
  set_time(10.11001);
  EXPECT_EQ(run_due(pacer), 1);
}

TEST_F(PacerTest, FactorZeroIsAlwaysDue) {
  Pacer pacer(0, false);
  set_time(10);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(pacer.until_due(frame).isZero());
    EXPECT_EQ(pacer.advance(frame), ros::Time(10));
  }
}

TEST_F(PacerTest, OwnClockGoesOnByTheFrames) {
  Pacer pacer(1, true);
  set_time(0);  // only the node's own time counts
  const ros::Time begin = pacer.now();
  EXPECT_GT(begin, ros::Time(0));
  EXPECT_EQ(pacer.advance_now(frame), begin + ros::Duration(frame));
  EXPECT_EQ(pacer.advance_now(2 * frame), begin + ros::Duration(3 * frame));
  EXPECT_EQ(pacer.now(), begin + ros::Duration(3 * frame));
}

}  // namespace
}  // namespace clothsim_ros::pacer_test
