#pragma once

#include <clothsim/ClothState.h>
#include <clothsim/Colliders.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <cstdint>
#include <string>

#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The topics ~state, ~points, ~colliders, ~topology and those of markers. No message is built
/// without a subscriber for it, but for the latched topology. A new subscriber gets the present
/// state, so that it sees a simulation that is paused, too: from refresh(), or from publish() where
/// that comes first.
class Outputs {
 public:
  /// The simulator must outlive this. `now` is the stamp of the scene's start.
  Outputs(ros::NodeHandle&, const clothsim::Simulator&, const std::string& world_frame,
          const ros::Time& now);

  /// Publishes the simulator's state, frame number `step` since the scene's start.
  void publish(const ros::Time& stamp, std::uint64_t step);

  /// To be called often. Publishes what changed between frames and what publish() left for later.
  void refresh();

  /// What is shown beside the state has changed.
  void redraw() { markers_due_ = true; }

  /// The state as it was last published.
  clothsim::ClothState state() const;

 private:
  void publish_topology();

  sensor_msgs::PointCloud2 points() const;
  clothsim::Colliders colliders() const;

  /// A topic of markers: each shows a part, so that nobody gets more than what is looked at.
  struct MarkerTopic {
    using Make = visualization_msgs::MarkerArray(const clothsim::Simulator&,
                                                 const std_msgs::Header&);
    const char* name;
    Make* make;
    ros::Publisher publisher;
  };
  /// With an order before them to delete all others, such as those of a node before this one.
  visualization_msgs::MarkerArray anew(const MarkerTopic&) const;

  const clothsim::Simulator& simulator_;
  std_msgs::Header header_;
  std::uint64_t step_ = 0;
  unsigned topology_seq_ = 0;     // of the topology published last
  bool markers_due_ = false;      // the state has moved on since the last ones
  bool others_shown_ = false;     // markers of another scene, maybe
  ros::SteadyTime next_markers_;  // not before
  ros::CallbackQueue newcomers_;  // subscribers of all but markers that have got none yet
  ros::Publisher state_publisher_;
  ros::Publisher points_publisher_;
  ros::Publisher colliders_publisher_;
  std::array<MarkerTopic, 3> markers_;
  ros::Publisher topology_publisher_;
};

}  // namespace clothsim_ros
