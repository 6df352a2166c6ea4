#include "clothsim/ros/tf_frame.h"

#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>
#include <tf2/exceptions.h>

#include <algorithm>
#include <utility>

#include "clothsim/ros/conversions.h"
#include "clothsim/ros/stamps.h"

namespace clothsim_ros {
namespace {

/// Time for a publisher to connect, and for transforms of 10 Hz to come; and how often to check.
const ros::WallDuration patience(0.5);
const ros::WallDuration lookup_period(0.005);

}  // namespace

bool is_usable(const clothsim::Pose& pose) {
  return pose.orientation.coeffs().allFinite() &&
         (pose.position.array().abs() <= largest_coordinate).all();  // false for NaN
}

TfListener::TfListener(std::string world_frame, std::optional<double> lost_after)
    : world_frame_(std::move(world_frame)), lost_after_(lost_after) {
  ros::NodeHandle node;
  node.setCallbackQueue(&queue_);
  subscribers_.listen(node, [this](const auto& event, bool is_static) { hear(event, is_static); });
}

void TfListener::receive() {
  forget_the_future();
  queue_.callAvailable();
}

void TfListener::forget_the_future() {
  // Time ran backwards, or has begun: the buffer's transforms would stay the latest for long.
  const ros::Time now = ros::Time::now();
  if (now < now_ || is_ahead(newest_, now)) {
    buffer_.clear();  // keeps static transforms
    newest_ = {};
    newest_stamps_.clear();
  }
  now_ = now;
}

void TfListener::hear(const TfSubscribers::Event& event, bool is_static) {
  // Nodelets of the same process have the same name.
  const bool may_be_own = !is_static && event.getPublisherName() == ros::this_node::getName();
  const ros::Time now = ros::Time::now();
  for (geometry_msgs::TransformStamped transform : event.getMessage()->transforms) {
    const ros::Time& stamp = transform.header.stamp;
    if (may_be_own && own_frames_.count(transform.child_frame_id) > 0) continue;
    if (!is_static && is_ahead(stamp, now)) {
      if (warnings_.passes()) {
        ROS_WARN(
            "Ignored a transform of tf frame %s from %s: stamped %.3f, expected at most %.3f, %s",
            transform.child_frame_id.c_str(), event.getPublisherName().c_str(), stamp.toSec(),
            latest_stamp(now).toSec(),
            now.isZero() ? "the last that tf2 can hold" : "a little after now");
      }
      continue;
    }
    const auto held = held_.find(transform.child_frame_id);
    if (held != held_.end() && stamp > held->second.header.stamp) {
      // Another node moves the frame from now on. While held, the frame got newer stamps than this
      // one.
      transform.header.stamp = newest_stamps_.next(transform.child_frame_id, stamp);
      held_.erase(held);
    }
    if (!is_static && newest_stamps_.is_late(transform)) continue;
    // tf2 logs transforms that it refuses.
    const bool is_taken = buffer_.setTransform(transform, event.getPublisherName(), is_static);
    if (!is_taken || is_static) continue;
    newest_ = std::max(newest_, stamp);
    newest_stamps_.add(transform);
    has_heard_ = true;
  }
}

void TfListener::put(const geometry_msgs::TransformStamped& transform) {
  own_frames_.insert(transform.child_frame_id);
  held_.insert_or_assign(transform.child_frame_id, take_now(transform));
}

void TfListener::hold(bool always) {
  receive();
  if (!std::exchange(has_heard_, false) && !always) return;
  for (const auto& [frame, transform] : held_) take_now(transform);
}

geometry_msgs::TransformStamped TfListener::take_now(geometry_msgs::TransformStamped transform) {
  transform.header.stamp = newest_stamps_.next(transform.child_frame_id, ros::Time::now());
  buffer_.setTransform(transform, ros::this_node::getName());
  newest_ = std::max(newest_, transform.header.stamp);
  newest_stamps_.add(transform);
  return transform;
}

std::optional<clothsim::Pose> TfListener::pose(const std::string& frame) const {
  try {
    const clothsim::Pose pose =
        to_pose(buffer_.lookupTransform(world_frame_, frame, ros::Time(0)).transform);
    if (is_usable(pose)) return pose;
  } catch (const tf2::TransformException&) {
  }
  return std::nullopt;
}

bool TfListener::carries(const std::string& frame, std::string child) const {
  while (child != frame) {
    if (!buffer_._getParent(child, ros::Time(0), child)) return false;
  }
  return true;
}

TfFrame::TfFrame(std::string frame, TfListener& tf) : tf_(&tf) { status_.frame = std::move(frame); }

void TfFrame::look_up() {
  const bool known = read();
  if (!status_.seen) return;  // never seen, so not lost
  status_.age = stamp_.isZero() ? 0 : seconds_between(stamp_, ros::Time::now());
  const std::optional<double> lost_after = tf_->lost_after();
  status_.lost = !known || (lost_after && status_.age > *lost_after);
}

void TfFrame::wait_for_first() {
  const ros::SteadyTime end = ros::SteadyTime::now() + patience;
  for (look_up(); !pose_ && ros::SteadyTime::now() < end; look_up()) lookup_period.sleep();
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
    } else if (warnings_.passes()) {
      ROS_WARN("Ignored a transform of tf frame %s: not finite or beyond %g m",
               status_.frame.c_str(), largest_coordinate);
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
