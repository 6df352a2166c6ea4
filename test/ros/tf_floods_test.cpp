#include <gtest/gtest.h>
#include <ros/console.h>
#include <tf2/buffer_core.h>

#include "clothsim/ros/stamps.h"
#include "clothsim/ros/tf_subscribers.h"

// Messages of a hundred thousand transforms: tf2 gets only as many as it takes in constant time,
// and the log only one line.

namespace clothsim_ros::tf_floods_test {
namespace {

constexpr int many = 100000;

geometry_msgs::TransformStamped make_transform(const std::string& frame, const ros::Time& stamp) {
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "map";
  transform.header.stamp = stamp;
  transform.child_frame_id = frame;
  transform.transform.rotation.w = 1;
  return transform;
}

/// Number of `many` transforms, `step` [s] after each other, that are not late.
int count_taken(double step) {
  NewestStamps newest;
  int taken = 0;
  for (int i = 0; i < many; ++i) {
    const auto transform = make_transform("hand", ros::Time(1000 + i * step));
    if (newest.is_late(transform)) continue;
    newest.add(transform);
    ++taken;
  }
  return taken;
}

TEST(TfFloods, OnlyTheNewestOfAFrame) {
  EXPECT_EQ(count_taken(1e-5), many);
  EXPECT_EQ(count_taken(0), many);  // tf2 reports these
  EXPECT_EQ(count_taken(-1e-5), 1);
}

TEST(TfFloods, WhatIsTooOldForTf2IsForItToRefuse) {
  NewestStamps newest;
  newest.add(make_transform("hand", ros::Time(1000)));
  EXPECT_TRUE(newest.is_late(make_transform("hand", ros::Time(991))));
  EXPECT_FALSE(newest.is_late(make_transform("hand", ros::Time(990))));
  EXPECT_FALSE(newest.is_late(make_transform("foot", ros::Time(991))));
  newest.clear();
  EXPECT_FALSE(newest.is_late(make_transform("hand", ros::Time(991))));
}

TEST(TfFloods, OneLineOfWhatTf2Refuses) {
  struct Counter : ros::console::LogAppender {
    void log(ros::console::Level, const char* text, const char*, const char*, int) override {
      lines.emplace_back(text);
    }
    std::vector<std::string> lines;
  } counter;
  ros::console::register_appender(&counter);
  {
    const Tf2Log log;
    tf2::BufferCore buffer;
    for (int i = 0; i < many; ++i) {
      EXPECT_FALSE(buffer.setTransform(make_transform("map", ros::Time(1000)), "somebody"));
    }
  }
  ros::console::deregister_appender(&counter);
  ASSERT_EQ(counter.lines.size(), 1u);
  EXPECT_NE(counter.lines[0].find("TF_SELF_TRANSFORM"), std::string::npos) << counter.lines[0];
}

}  // namespace
}  // namespace clothsim_ros::tf_floods_test
