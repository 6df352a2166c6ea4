#include "clothsim/ros/wind_listener.h"

#include <ros/console.h>

#include "clothsim/model/errors.h"
#include "clothsim/ros/conversions.h"
#include "clothsim/ros/live_values.h"

namespace clothsim_ros {
namespace {

/// With several messages at once, the last one counts.
constexpr std::uint32_t wind_queue = 1;

}  // namespace

WindListener::WindListener(ros::NodeHandle& node, clothsim::Simulator& simulator, TfListener& tf,
                           Changes& changes)
    : simulator_(simulator),
      tf_(tf),
      changes_(changes),
      subscriber_(node.subscribe("wind", wind_queue, &WindListener::hear, this)) {}

void WindListener::hear(const geometry_msgs::Vector3Stamped& message) {
  clothsim::Vector3 wind(message.vector.x, message.vector.y, message.vector.z);
  const std::string& frame = message.header.frame_id;
  if (!frame.empty() && frame != tf_.world_frame()) {
    TfFrame source(frame, tf_);
    source.look_up();
    if (!source.pose()) {
      if (warnings_.passes()) {
        ROS_WARN("Ignored a wind in tf frame %s, which has no transform to %s", frame.c_str(),
                 tf_.world_frame().c_str());
      }
      return;
    }
    wind = source.pose()->orientation * wind;
  }
  if (const auto why = refusal([&] { simulator_.set_wind(wind); }, "~wind")) {
    if (warnings_.passes()) ROS_WARN("Ignored a wind: %s", why->c_str());
    return;
  }
  heard_ = wind;
  tell();
}

void WindListener::tell() const {
  if (!heard_ || simulator_.scene().simulation.wind != heard_) return;
  clothsim::Change change;
  change.wind = to_vector_msg(*heard_);
  changes_.publish("wind", change);
}

}  // namespace clothsim_ros
