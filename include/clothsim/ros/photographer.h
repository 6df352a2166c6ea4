#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <optional>
#include <string>

#include "clothsim/render/render_thread.h"
#include "clothsim/ros/camera_topics.h"
#include "clothsim/ros/rate_meter.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/view/snapshot_maker.h"

namespace clothsim_ros {

/// What the camera does, for the diagnostics.
struct CameraStatus {
  clothsim::RenderStatus render;
  clothsim::WantedImages subscribed;
  std::optional<double> rate;  // [Hz] of pictures since the last status; empty: too little time
  std::optional<double> drawn_share;  // of the pictures due, likewise; empty: none was due
  std::optional<FrameStatus> frame;   // that carries the camera
};

/// Takes pictures of a simulation and publishes them. Until somebody subscribes there is neither
/// render thread nor OpenGL. To be used in the thread that serves the node's callbacks.
class Photographer {
 public:
  /// Simulator and `tf` must outlive this. `now` is the stamp of the simulator's state. Throws
  /// InvalidValue for a view that cannot be drawn.
  Photographer(const ros::NodeHandle&, const clothsim::Simulator&, TfListener& tf,
               const clothsim::View&, const ros::Time& now);

  const clothsim::View& view() const { return view_; }

  /// Another view for the next picture. Throws InvalidValue and keeps the old one when refused.
  /// Samples and EGL device are those of the start.
  void set_view(const clothsim::View&);

  /// The simulator has a new state. Takes a picture if one is due in simulated time.
  void update(const ros::Time& stamp);

  /// Waits until the pictures that were taken are published.
  void wait();

  /// Takes a picture of the present state unless there is one, and waits for it.
  void finish();

  /// To be called often. Where no picture is due because no frame comes, as while the simulation is
  /// paused or the clock stands: new subscribers, another look and a camera that moves get a
  /// picture.
  void refresh(bool paused);

  /// What is seen beside the state has changed: refresh() takes another picture.
  void redraw();

  /// Logs why there are no pictures where that is new.
  CameraStatus status();

 private:
  void take();
  ros::SteadyTime after_a_period() const;
  bool move_camera();
  std_msgs::Header header() const;
  void broadcast_own_frame();

  const clothsim::Simulator& simulator_;
  TfListener& tf_;
  clothsim::View view_;
  clothsim::ImageStore images_;
  clothsim::PreparedView prepared_;
  clothsim::SnapshotMaker snapshots_;
  std::string shaders_;
  std::optional<TfFrame> frame_;  // that carries the camera
  std::string own_frame_;         // of the camera while no other one carries it
  std::optional<tf2_ros::StaticTransformBroadcaster> broadcaster_;
  std::optional<clothsim::Pose> broadcast_;  // pose of own_frame_ that tf knows

  ros::Time stamp_;               // of the simulator's state
  bool taken_ = false;            // there is a picture of it, or one on its way
  bool anew_ = false;             // what is seen beside the state has changed since the last one
  unsigned topology_seq_ = 0;     // of the last one
  double next_ = 0;               // [s] of simulated time: when a picture is due
  ros::SteadyTime next_refresh_;  // not before
  ros::SteadyTime stands_;        // from then on, if no frame comes until then: none is due soon
  RateMeter rate_;
  int drawn_ = 0;       // pictures that the last status knew of
  int dropped_ = 0;     // likewise
  std::string logged_;  // the failure that was logged last

  CameraTopics topics_;
  std::optional<clothsim::RenderThread> renderer_;  // last: it publishes
};

}  // namespace clothsim_ros
