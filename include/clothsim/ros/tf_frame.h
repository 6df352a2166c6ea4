#pragma once

#include <ros/callback_queue.h>
#include <ros/time.h>
#include <tf2/buffer_core.h>

#include <map>
#include <optional>
#include <set>
#include <string>

#include "clothsim/ros/newest_stamps.h"
#include "clothsim/ros/tf2_log.h"
#include "clothsim/ros/tf_subscribers.h"
#include "clothsim/ros/throttle.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_ros {

/// Coordinates beyond these are no place for a cloth [m]; the scene has the same limit.
inline constexpr double largest_coordinate = 1e6;

/// Whether a pose is finite and no farther out than that.
bool is_usable(const clothsim::Pose&);

/// Whether two poses are equal to the last bit.
bool same(const clothsim::Pose&, const clothsim::Pose&);

/// The transforms to the world that tf knows of. Reads what has come in the thread that asks: in
/// lockstep, what came before a call counts in the call. Transforms that are stamped ahead of now
/// are refused, since tf2 would take them for the latest until then.
class TfListener {
 public:
  /// A frame is lost when its latest transform is older than `lost_after` [s]; empty: never.
  TfListener(std::string world_frame, std::optional<double> lost_after);

  /// Reads the transforms that have come. To be called often.
  void receive();

  /// Takes a transform of this node's own, to the world, as the newest of its frame.
  void put(const geometry_msgs::TransformStamped&);

  /// Whether it is one of put() that nobody else has moved since.
  bool holds(const std::string& frame) const { return held_.count(frame) > 0; }

  /// Those are now where they were put: tf takes what hangs from a frame as of the older stamp of
  /// the two. To be called before frames are looked up. Where nothing of others came since the last
  /// call, that takes no time and adds no transforms; `always`: then, too, so that they are of no
  /// age.
  void hold(bool always = false);

  /// The latest of the frame in the world; empty: there is none that is usable.
  std::optional<clothsim::Pose> pose(const std::string& frame) const;

  /// Whether `child` is that frame, or carried by it.
  bool carries(const std::string& frame, std::string child) const;

  const std::string& world_frame() const { return world_frame_; }
  std::optional<double> lost_after() const { return lost_after_; }
  const tf2::BufferCore& buffer() const { return buffer_; }

 private:
  void hear(const TfSubscribers::Event&, bool is_static);
  void forget_the_future();
  /// As of now, with the stamp that it then has.
  geometry_msgs::TransformStamped take_now(geometry_msgs::TransformStamped);

  std::string world_frame_;
  std::optional<double> lost_after_;
  tf2::BufferCore buffer_;
  Tf2Log log_;
  ros::CallbackQueue queue_;
  TfSubscribers subscribers_;
  ros::Time now_;     // when transforms were last received
  ros::Time newest_;  // stamp in the buffer
  NewestStamps newest_stamps_;
  std::set<std::string> own_frames_;  // that put() moves: what comes of them is this node's own
  std::map<std::string, geometry_msgs::TransformStamped> held_;  // as put() took them
  bool has_heard_ = false;  // transforms of others, since they were held
  Throttle warnings_{warning_period};
};

/// What is known of a tf frame that carries a collider, a pin or the camera.
struct FrameStatus {
  std::string frame;
  bool seen = false;       // a transform to the world came
  bool lost = false;       // seen, but nothing newer came for a while
  double age = 0;          // [s] of the latest transform; 0 for a static one
  std::string apart_from;  // the world frame, where tf knows this frame but no way to that
};

/// The latest pose of a tf frame. A frame that is lost keeps its last one.
class TfFrame {
 public:
  /// `tf` must outlive this.
  TfFrame(std::string frame, TfListener& tf);

  /// Reads the latest transform. Logs one that is no use.
  void look_up();

  /// The same, and waits for a moment where there is none yet.
  void wait_for_first();

  /// Of the frame in the world; empty until it is seen.
  const std::optional<clothsim::Pose>& pose() const { return pose_; }

  /// What that was made of.
  const geometry_msgs::Transform& transform() const { return transform_; }

  const FrameStatus& status() const { return status_; }

 private:
  bool read();

  TfListener* tf_;
  FrameStatus status_;
  std::optional<clothsim::Pose> pose_;
  geometry_msgs::Transform transform_;
  ros::Time stamp_;  // of that; zero: a static transform
  Throttle warnings_{warning_period};
};

}  // namespace clothsim_ros
