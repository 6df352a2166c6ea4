#pragma once

#include <ros/callback_queue.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <map>
#include <optional>
#include <set>
#include <string>

#include "clothsim/ros/rates.h"
#include "clothsim/ros/stamps.h"
#include "clothsim/ros/tf_subscribers.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// Largest coordinate of a tf frame [m]; the scene has the same limit.
inline constexpr double largest_coordinate = 1e6;

/// Whether a pose is finite and within this limit.
bool is_usable(const clothsim::Pose&);

/// The transforms to the world that tf knows of. Received in the thread that asks: in lockstep,
/// transforms that came before a call count in the call. Transforms that are stamped ahead of now
/// are refused, since tf2 would take them for the latest until then.
class TfListener {
 public:
  /// A frame is lost when its latest transform is older than `lost_after` [s]; empty: never.
  TfListener(std::string world_frame, std::optional<double> lost_after);

  /// Receives transforms. To be called often.
  void receive();

  /// Takes a transform to the world of this node's own as the newest of its frame.
  void put(const geometry_msgs::TransformStamped&);

  /// Whether the frame's transform is from put(), and no other node has moved it since.
  bool holds(const std::string& frame) const { return held_.count(frame) > 0; }

  /// Gives the frames of put() the present stamp: tf takes frames that depend on them at the older
  /// stamp of the two. To be called before frames are looked up. Without transforms of others since
  /// the last call, it takes no time and adds no transforms, unless `always` is set: then these
  /// frames have no age.
  void hold(bool always = false);

  /// The latest pose of the frame in the world; empty: there is no usable one.
  std::optional<clothsim::Pose> pose(const std::string& frame) const;

  /// Whether `child` is that frame, or one below it.
  bool carries(const std::string& frame, std::string child) const;

  const std::string& world_frame() const { return world_frame_; }
  std::optional<double> lost_after() const { return lost_after_; }
  const tf2::BufferCore& buffer() const { return buffer_; }

 private:
  void hear(const TfSubscribers::Event&, bool is_static);
  void forget_the_future();
  /// Inserts the transform with the present stamp and returns it so.
  geometry_msgs::TransformStamped take_now(geometry_msgs::TransformStamped);

  std::string world_frame_;
  std::optional<double> lost_after_;
  tf2::BufferCore buffer_;
  Tf2Log log_;
  ros::CallbackQueue queue_;
  TfSubscribers subscribers_;
  ros::Time now_;     // time of the last receive()
  ros::Time newest_;  // newest stamp in the buffer
  NewestStamps newest_stamps_;
  std::set<std::string> own_frames_;  // of put(): transforms of these from this node are ignored
  std::map<std::string, geometry_msgs::TransformStamped> held_;  // as put() got them
  bool has_heard_ = false;  // transforms of others since hold()
  Throttle warnings_{warning_period};
};

/// The status of a tf frame that carries a collider, a pin or the camera.
struct FrameStatus {
  std::string frame;
  bool seen = false;       // a transform to the world has come
  bool lost = false;       // seen, but too old now
  double age = 0;          // [s] age of the latest transform; 0 for a static one
  std::string apart_from;  // the world frame, where tf does not connect this frame to it
};

/// The latest pose of a tf frame. A frame that is lost keeps its last pose.
class TfFrame {
 public:
  /// `tf` must outlive this.
  TfFrame(std::string frame, TfListener& tf);

  /// Reads the latest transform. Logs an unusable one.
  void look_up();

  /// The same, and waits for a moment where there is none yet.
  void wait_for_first();

  /// Pose of the frame in the world; empty until it is seen.
  const std::optional<clothsim::Pose>& pose() const { return pose_; }

  /// The transform of pose().
  const geometry_msgs::Transform& transform() const { return transform_; }

  const FrameStatus& status() const { return status_; }

 private:
  bool read();

  TfListener* tf_;
  FrameStatus status_;
  std::optional<clothsim::Pose> pose_;
  geometry_msgs::Transform transform_;
  ros::Time stamp_;  // of transform_; zero: static
  Throttle warnings_{warning_period};
};

}  // namespace clothsim_ros
