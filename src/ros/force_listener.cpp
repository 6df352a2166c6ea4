#include "clothsim/ros/force_listener.h"

#include <ros/console.h>

#include "clothsim/model/checks.h"

namespace clothsim_ros {
namespace {

/// With several messages at once, the last one counts.
constexpr std::uint32_t force_queue = 1;

/// The forces on all points, `turn` from the message's axes to the world's. Throws InvalidValue.
clothsim::Points to_forces(const clothsim::PointForces& message, const Eigen::Quaterniond& turn,
                           int num_points) {
  using clothsim::InvalidValue;
  const std::size_t count = message.points.size();
  if (message.forces.size() != count) {
    throw InvalidValue({"forces"}, std::to_string(message.forces.size()) + " of them",
                       std::to_string(count) + ", one for each of points");
  }
  if (!(message.duration >= 0)) {
    throw InvalidValue({"duration"}, clothsim::to_text(message.duration), "at least 0 [s]");
  }
  if (count == 0) return clothsim::Points(0, 3);
  clothsim::Points forces = clothsim::Points::Zero(num_points, 3);
  std::vector<bool> is_given(static_cast<std::size_t>(num_points));
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t point = message.points[i];
    if (point >= is_given.size() || is_given[point]) {
      throw InvalidValue({"points", std::to_string(i)}, std::to_string(point),
                         "numbers from 0 to " + std::to_string(num_points - 1) + ", each once");
    }
    is_given[point] = true;
    const geometry_msgs::Vector3& force = message.forces[i];
    forces.row(point) = (turn * clothsim::Vector3(force.x, force.y, force.z)).transpose();
  }
  return forces;
}

}  // namespace

ForceListener::ForceListener(ros::NodeHandle& node, clothsim::Simulator& simulator, TfListener& tf,
                             Changes& changes)
    : simulator_(simulator),
      tf_(tf),
      changes_(changes),
      subscriber_(node.subscribe("forces", force_queue, &ForceListener::hear, this)) {}

void ForceListener::hear(const clothsim::PointForces& message) {
  clothsim::Pose axes;
  const std::string& frame = message.header.frame_id;
  if (!frame.empty() && frame != tf_.world_frame()) {
    TfFrame source(frame, tf_);
    source.look_up();
    if (!source.pose()) {
      return refuse("tf frame " + frame + " has no transform to " + tf_.world_frame());
    }
    axes = *source.pose();
  }
  try {
    clothsim::inside("~forces", [&] {
      simulator_.set_forces(to_forces(message, axes.orientation, simulator_.cloth().num_points()));
    });
  } catch (const clothsim::InvalidValue& error) {
    return refuse(error.what());
  }
  end_ = message.duration > 0 ? simulator_.state().time + message.duration
                              : std::numeric_limits<double>::infinity();
  clothsim::Change change;
  change.points.assign(message.points.begin(), message.points.end());
  changes_.publish("forces", change);
}

void ForceListener::end_when_due() {
  if (simulator_.forces().rows() == 0) return;
  // A frame counts where most of it is within the time.
  if (simulator_.state().time + simulator_.frame_duration() / 2 < end_) return;
  simulator_.set_forces(clothsim::Points(0, 3));
}

void ForceListener::refuse(const std::string& why) {
  if (warnings_.passes()) ROS_WARN("Ignored forces: %s", why.c_str());
}

}  // namespace clothsim_ros
