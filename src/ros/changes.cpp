#include "clothsim/ros/changes.h"

namespace clothsim_ros {
namespace {

/// None may be lost, for any number of calls at once.
constexpr std::uint32_t change_queue = 1000;

}  // namespace

Changes::Changes(ros::NodeHandle& node, const Pacer& pacer, const std::uint64_t& frame_number)
    : pacer_(pacer),
      frame_number_(frame_number),
      publisher_(node.advertise<clothsim::Change>("changes", change_queue)) {}

void Changes::publish(const std::string& what, clothsim::Change change) {
  change.what = what;
  change.stamp = pacer_.now();
  change.step = frame_number_;
  if (what == "reset") change.scene = scene_;
  publisher_.publish(change);
  if (what == "reset") told_.clear();
}

void Changes::follow(const TfFrame& frame, const std::string& what) {
  if (!frame.pose()) return;
  const std::string& name = frame.status().frame;
  const auto told = told_.find(name);
  if (told != told_.end() && told->second == frame.transform()) return;
  told_[name] = frame.transform();

  clothsim::Change change;
  change.frame = name;
  change.transform = frame.transform();
  publish(what, change);
}

}  // namespace clothsim_ros
