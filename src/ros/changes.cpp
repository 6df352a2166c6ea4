#include "clothsim/ros/changes.h"

namespace clothsim_ros {
namespace {

/// None is to be lost, however many calls come at once.
constexpr std::uint32_t change_queue = 1000;

}  // namespace

Changes::Changes(ros::NodeHandle& node, const Pacer& pacer, const std::uint64_t& frame_number)
    : pacer_(pacer),
      frame_number_(frame_number),
      publisher_(node.advertise<clothsim::Change>("changes", change_queue)) {}

void Changes::publish(const std::string& service, clothsim::Change change) {
  change.service = service;
  change.stamp = pacer_.now();
  change.step = frame_number_;
  publisher_.publish(change);
}

}  // namespace clothsim_ros
