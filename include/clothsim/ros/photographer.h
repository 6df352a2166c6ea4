#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/node_handle.h>
#include <ros/time.h>

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/render/render_thread.h"
#include "clothsim/ros/camera_topics.h"
#include "clothsim/ros/rate_meter.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/view/snapshot_maker.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim_ros {

/// What a camera does, for the diagnostics.
struct CameraStatus {
  std::string name;
  clothsim::RenderStatus render;
  clothsim::WantedImages subscribed;
  std::optional<double> rate;  // [Hz] of pictures since the last status; empty: too little time
  std::optional<double> drawn_share;  // of the pictures due, likewise; empty: none was due
  std::optional<FrameStatus> frame;   // that carries the camera
};

/// A camera that takes pictures of a simulation and publishes them. Until somebody subscribes there
/// is neither render thread nor OpenGL. To be used in the thread that serves the node's callbacks,
/// but for view(), set_view() and change_view(), which any thread may call.
class Photographer {
 public:
  /// Tells tf a static transform.
  using Broadcast = std::function<void(const geometry_msgs::TransformStamped&)>;

  /// Simulator and `tf` must outlive this. `camera` has the name of its topics and its view. Images
  /// come from the package and `image_folders`. `now` is the stamp of the simulator's state. Throws
  /// InvalidValue for a view that cannot be drawn.
  Photographer(const ros::NodeHandle&, const clothsim::NamedView& camera,
               const clothsim::Simulator&, TfListener& tf, Broadcast,
               std::vector<std::string> image_folders, const ros::Time& now);

  const std::string& name() const { return name_; }

  /// The one that was set last.
  clothsim::View view() const;

  /// Another view for the next picture, whose images are read by the calling thread. Throws
  /// InvalidValue and keeps the old one when refused. Samples and EGL device are those of the
  /// start.
  void set_view(const clothsim::View&);

  /// The same with what `change` makes of the newest view. One change waits for another.
  void change_view(const std::function<void(clothsim::View&)>& change);

  /// The simulator has a new state. Takes a picture if one is due in simulated time.
  void update(const ros::Time& stamp);

  /// Waits until the pictures that were taken are published.
  void wait();

  /// Takes a picture of the present state unless there is one or the view asks for none after each
  /// step, and waits until it is published.
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
  /// A view with its images.
  struct Sight {
    clothsim::View view;
    clothsim::PreparedView prepared;
  };

  /// Goes on with the view that was set last.
  void adopt();
  void take();
  ros::SteadyTime after_a_period() const;
  bool move_camera();
  std_msgs::Header header() const;
  void broadcast_own_frame();

  std::string name_;
  const clothsim::Simulator& simulator_;
  TfListener& tf_;
  Broadcast broadcast_;
  std::mutex change_mutex_;  // held while images are read
  clothsim::ImageStore images_;
  mutable std::mutex newest_mutex_;  // held for a moment only
  clothsim::View newest_;
  std::optional<Sight> set_;  // and not adopted yet
  clothsim::View view_;
  clothsim::PreparedView prepared_;
  clothsim::SnapshotMaker snapshots_;
  std::string shaders_;
  std::optional<TfFrame> frame_;            // that carries the camera
  std::string own_frame_;                   // of the camera while no other one carries it
  std::optional<clothsim::Pose> own_pose_;  // of own_frame_, as tf knows it

  ros::Time stamp_;               // of the simulator's state
  bool taken_ = false;            // there is a picture of it, or one on its way, or none is wanted
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
