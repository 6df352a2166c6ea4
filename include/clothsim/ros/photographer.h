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
#include "clothsim/ros/rates.h"
#include "clothsim/ros/tf_frame.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/view/snapshot_maker.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim_ros {

/// The state of a camera for diagnostics.
struct CameraStatus {
  std::string name;
  clothsim::RenderStatus render;
  clothsim::WantedImages subscribed;
  std::optional<double> rate;  // [Hz] of pictures since the last status; empty: too little time
  std::optional<double> drawn_share;  // of the pictures due since then; empty: none was due
  std::optional<FrameStatus> frame;   // that carries the camera
};

/// A camera that takes pictures of a simulation and publishes them. Render thread and OpenGL start
/// with the first subscriber. To be used in the thread that serves the node's callbacks, except for
/// view(), set_view() and change_view(), which any thread may call.
class Photographer {
 public:
  /// Sends a static transform to tf.
  using Broadcast = std::function<void(const geometry_msgs::TransformStamped&)>;

  /// Simulator and `tf` must outlive this. `camera`: the name of its topics, and its view. Images
  /// come from the package and `image_folders`. `now`: the stamp of the simulator's state. Throws
  /// InvalidValue for a view that cannot be drawn.
  Photographer(const ros::NodeHandle&, const clothsim::NamedView& camera,
               const clothsim::Simulator&, TfListener& tf, Broadcast,
               std::vector<std::string> image_folders, const ros::Time& now);

  const std::string& name() const { return name_; }

  /// The view that was set last.
  clothsim::View view() const;

  /// Sets the view for the next picture; the calling thread reads its images. Throws InvalidValue
  /// and keeps the old one when refused. Samples and EGL device do not change.
  void set_view(const clothsim::View&);

  /// The same with the newest view as changed by `change`. Concurrent changes wait for each other.
  void change_view(const std::function<void(clothsim::View&)>& change);

  /// To be called for a new state of the simulator. Takes a picture if one is due in simulated
  /// time.
  void update(const ros::Time& stamp);

  /// Waits until the pictures that were taken are published.
  void wait();

  /// Takes a picture of the present state, unless there is one or the view wants none after each
  /// step, and waits until it is published.
  void finish();

  /// To be called often. Where no picture is due as no frame comes, while the simulation is paused
  /// or the clock stands: takes pictures for new subscribers, another look and a moving camera.
  void refresh(bool paused);

  /// To be called when the scene looks different in the same state: refresh() takes another
  /// picture.
  void redraw();

  /// Logs a new reason for the lack of pictures.
  CameraStatus status();

 private:
  /// A view with its images.
  struct Sight {
    clothsim::View view;
    clothsim::PreparedView prepared;
  };

  /// Adopts the view that was set last.
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
  std::optional<TfFrame> frame_;            // of the camera
  std::string own_frame_;                   // the camera's own frame, for a view without a frame
  std::optional<clothsim::Pose> own_pose_;  // of own_frame_, as tf knows it

  ros::Time stamp_;               // of the simulator's state
  bool taken_ = false;            // its picture is taken, under way, or not wanted
  bool anew_ = false;             // the scene looks different since the last one
  unsigned topology_seq_ = 0;     // of the last picture
  double next_ = 0;               // [s] of simulated time: when a picture is due
  ros::SteadyTime next_refresh_;  // time before which refresh() takes none
  ros::SteadyTime stands_;        // refresh() takes pictures from then on if no frame comes
  RateMeter rate_;
  int drawn_ = 0;       // pictures drawn up to the last status
  int dropped_ = 0;     // the same for dropped ones
  std::string logged_;  // the failure that was logged last

  CameraTopics topics_;
  std::optional<clothsim::RenderThread> renderer_;  // last, as its thread publishes
};

}  // namespace clothsim_ros
