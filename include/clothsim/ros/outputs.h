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

/// The topics ~state, ~points, ~colliders, ~topology and those of markers. Messages are built for
/// subscribers only, except for the latched topology. A new subscriber gets the present state, also
/// from a paused simulation: from refresh(), or from publish() where that comes first.
class Outputs {
 public:
  /// The simulator must outlive this. `now`: the stamp of the scene's start.
  Outputs(ros::NodeHandle&, const clothsim::Simulator&, const std::string& world_frame,
          const ros::Time& now);

  /// Publishes the simulator's state, frame number `step` since the scene's start.
  void publish(const ros::Time& stamp, std::uint64_t step);

  /// To be called often. Publishes changes between frames and messages that publish() has deferred.
  void refresh();

  /// To be called when markers change without a new state.
  void redraw() { markers_due_ = true; }

  /// The last published state.
  clothsim::ClothState state() const;

 private:
  void publish_topology();

  sensor_msgs::PointCloud2 points() const;
  clothsim::Colliders colliders() const;

  /// A topic of markers. Each shows a part, so that subscribers get only the part they display.
  struct MarkerTopic {
    using Make = visualization_msgs::MarkerArray(const clothsim::Simulator&,
                                                 const std_msgs::Header&);
    const char* name;
    Make* make;
    ros::Publisher publisher;
  };
  /// With a first marker that deletes all others, such as those of an earlier node.
  visualization_msgs::MarkerArray anew(const MarkerTopic&) const;

  const clothsim::Simulator& simulator_;
  std_msgs::Header header_;
  std::uint64_t step_ = 0;
  unsigned topology_seq_ = 0;     // of the topology published last
  bool markers_due_ = false;      // the state has changed since the last ones
  bool others_shown_ = false;     // markers of another scene may be shown
  ros::SteadyTime next_markers_;  // time before which none are sent
  ros::CallbackQueue newcomers_;  // subscribers that wait for a first message, not markers
  ros::Publisher state_publisher_;
  ros::Publisher points_publisher_;
  ros::Publisher colliders_publisher_;
  std::array<MarkerTopic, 3> markers_;
  ros::Publisher topology_publisher_;
};

}  // namespace clothsim_ros
