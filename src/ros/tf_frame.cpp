#include "clothsim/ros/tf_frame.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <tf2/exceptions.h>

#include <utility>

#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

/// Time that publishers take to connect, and frames of 10 Hz to come.
const ros::WallDuration settling(0.5);

}  // namespace

bool is_usable(const clothsim::Pose& pose) {
  return pose.orientation.coeffs().allFinite() &&
         (pose.position.array().abs() <= farthest).all();  // false for NaN
}

void TfListener::listen() {
  if (listener_) return;
  ros::NodeHandle node;
  node.setCallbackQueue(&queue_);
  listener_.emplace(buffer_, node, false);
  settled_ = ros::SteadyTime::now() + settling;
}

void TfListener::receive() { queue_.callAvailable(); }

void TfListener::wait_for_first() {
  listen();
  const ros::WallDuration left = settled_ - ros::SteadyTime::now();
  if (left > ros::WallDuration(0)) left.sleep();
}

TfFrame::TfFrame(std::string frame, TfListener& tf) : tf_(&tf) {
  status_.frame = std::move(frame);
  tf.listen();
}

void TfFrame::look_up() {
  const bool known = read();
  if (!status_.seen) return;  // nothing to lose yet
  const bool was_lost = status_.lost;
  status_.age = stamp_.isZero() ? 0 : (ros::Time::now() - stamp_).toSec();
  const std::optional<double> lost_after = tf_->lost_after();
  status_.lost = !known || (lost_after && status_.age > *lost_after);
  if (status_.lost && !was_lost)
    ROS_WARN("Lost tf frame %s: what it carries stays where it was", status_.frame.c_str());
}

bool TfFrame::read() {
  tf_->receive();
  try {
    const geometry_msgs::TransformStamped transform =
        tf_->buffer().lookupTransform(tf_->world_frame(), status_.frame, ros::Time(0));
    const clothsim::Pose pose = to_pose(transform.transform);
    if (is_usable(pose)) {
      pose_ = pose;
      transform_ = transform.transform;
      stamp_ = transform.header.stamp;
      status_.seen = true;
    } else {
      ROS_WARN_THROTTLE(5, "Ignored a transform of tf frame %s: not finite or beyond %g m",
                        status_.frame.c_str(), farthest);
    }
    status_.apart_from.clear();
    return true;
  } catch (const tf2::TransformException&) {
    const bool is_sent = tf_->buffer()._frameExists(status_.frame);
    status_.apart_from = is_sent ? tf_->world_frame() : "";
    return false;
  }
}

}  // namespace clothsim_ros
