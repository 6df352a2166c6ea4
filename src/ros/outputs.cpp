#include "clothsim/ros/outputs.h"

#include <clothsim/ClothTopology.h>
#include <ros/single_subscriber_publisher.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <utility>

#include "clothsim/ros/conversions.h"
#include "clothsim/ros/markers.h"

namespace clothsim_ros {
namespace {

/// Messages that wait for a slow subscriber before the oldest is dropped: a second of states, so
/// that all frames of a ~step get through; messages for display need no queue.
constexpr std::uint32_t state_queue = 100;
constexpr std::uint32_t points_queue = 10;
constexpr std::uint32_t markers_queue = 1;
constexpr std::uint32_t topology_queue = 1;

/// Least average period of markers; RViz draws no faster.
const ros::WallDuration markers_period(1.0 / 30);

/// How much earlier than that markers may come, so that frames with a jitter about the period are
/// not skipped.
const ros::WallDuration markers_jitter(0.003);

/// Advertises a topic on which a new subscriber gets the message that `make` returns.
template <class Message, class Make>
ros::Publisher advertise(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
                         Make make) {
  return node.advertise<Message>(
      topic, queue_size,
      [make](const ros::SingleSubscriberPublisher& subscriber) { subscriber.publish(make()); });
}

/// Nodelets of the same process get the message itself, not a copy.
template <class Message>
void share(const ros::Publisher& publisher, Message message) {
  publisher.publish(boost::make_shared<const Message>(std::move(message)));
}

visualization_msgs::Marker delete_all(const std_msgs::Header& header) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.action = visualization_msgs::Marker::DELETEALL;
  marker.pose.orientation.w = 1;
  return marker;
}

}  // namespace

Outputs::Outputs(ros::NodeHandle& node, const clothsim::Simulator& simulator,
                 const std::string& world_frame, const ros::Time& now)
    : simulator_(simulator),
      markers_{{{"markers", make_markers, {}},
                {"markers/springs", make_spring_markers, {}},
                {"markers/colliders", make_collider_markers, {}}}} {
  header_.frame_id = world_frame;
  header_.stamp = now;
  topology_publisher_ = node.advertise<clothsim::ClothTopology>("topology", topology_queue, true);
  publish_topology();
  ros::NodeHandle greeted(node);
  greeted.setCallbackQueue(&newcomers_);
  state_publisher_ =
      advertise<clothsim::ClothState>(greeted, "state", state_queue, [this] { return state(); });
  points_publisher_ = advertise<sensor_msgs::PointCloud2>(greeted, "points", points_queue,
                                                          [this] { return points(); });
  colliders_publisher_ = advertise<clothsim::Colliders>(greeted, "colliders", points_queue,
                                                        [this] { return colliders(); });
  for (MarkerTopic& topic : markers_) {
    topic.publisher = advertise<visualization_msgs::MarkerArray>(node, topic.name, markers_queue,
                                                                 [&] { return anew(topic); });
  }
}

clothsim::ClothState Outputs::state() const {
  return to_state_msg(simulator_.state(), simulator_.grips(), header_, topology_seq_, step_);
}

sensor_msgs::PointCloud2 Outputs::points() const {
  return to_point_cloud(simulator_.cloth(), simulator_.state().positions, header_);
}

clothsim::Colliders Outputs::colliders() const {
  return to_colliders_msg(simulator_, header_, step_);
}

visualization_msgs::MarkerArray Outputs::anew(const MarkerTopic& topic) const {
  visualization_msgs::MarkerArray array = topic.make(simulator_, header_);
  array.markers.insert(array.markers.begin(), delete_all(header_));
  return array;
}

void Outputs::publish_topology() {
  topology_seq_ = simulator_.topology_seq();
  topology_publisher_.publish(
      to_topology_msg(simulator_.cloth(), simulator_.scene().cloth.parts, header_, topology_seq_));
}

void Outputs::publish(const ros::Time& stamp, std::uint64_t step) {
  header_.stamp = stamp;
  step_ = step;
  newcomers_.clear();  // all subscribers get the messages below
  if (state_publisher_.getNumSubscribers() > 0) share(state_publisher_, state());
  if (points_publisher_.getNumSubscribers() > 0) share(points_publisher_, points());
  if (colliders_publisher_.getNumSubscribers() > 0) share(colliders_publisher_, colliders());
  markers_due_ = true;
  refresh();
}

void Outputs::refresh() {
  newcomers_.callAvailable();
  if (topology_seq_ != simulator_.topology_seq()) {
    publish_topology();
    markers_due_ = true;
    others_shown_ = true;
  }

  const ros::SteadyTime now = ros::SteadyTime::now();
  if (!markers_due_ || now + markers_jitter < next_markers_) return;
  markers_due_ = false;
  bool published = false;
  for (const MarkerTopic& topic : markers_) {
    if (topic.publisher.getNumSubscribers() == 0) continue;
    share(topic.publisher, others_shown_ ? anew(topic) : topic.make(simulator_, header_));
    published = true;
  }
  if (!published) return;
  others_shown_ = false;
  next_markers_ = std::max(next_markers_ + markers_period, now);
}

}  // namespace clothsim_ros
