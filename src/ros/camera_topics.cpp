#include "clothsim/ros/camera_topics.h"

#include <clothsim/VisiblePoints.h>
#include <ros/single_subscriber_publisher.h>
#include <sensor_msgs/fill_image.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>

#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

/// Images that wait for a slow subscriber before the oldest is dropped. One of 640 x 480 with depth
/// takes 1.2 MB.
constexpr std::uint32_t image_queue = 10;

}  // namespace

CameraTopics::CameraTopics(const ros::NodeHandle& node, const std::string& name,
                           const std::function<void()>& subscriber_came)
    : transport_(ros::NodeHandle(node, name)) {
  ros::NodeHandle camera(node, name);
  const std::array<std::string, 6> names = {"color", "depth", "mask", "uv", "normals", "flow"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    topics_[i].image = transport_.advertise(names[i] + "/image_raw", image_queue,
                                            [subscriber_came](const auto&) { subscriber_came(); });
    topics_[i].info = camera.advertise<sensor_msgs::CameraInfo>(
        names[i] + "/camera_info", image_queue,
        [subscriber_came](const ros::SingleSubscriberPublisher&) { subscriber_came(); });
  }
  visible_points_ = camera.advertise<clothsim::VisiblePoints>(
      "visible_points", image_queue,
      [subscriber_came](const ros::SingleSubscriberPublisher&) { subscriber_came(); });
}

clothsim::WantedImages CameraTopics::wanted() const {
  const auto listens = [](const Topic& topic) { return topic.image.getNumSubscribers() > 0; };
  return {listens(topics_[0]),
          listens(topics_[1]),
          listens(topics_[2]),
          listens(topics_[3]),
          listens(topics_[4]),
          listens(topics_[5]),
          visible_points_.getNumSubscribers() > 0};
}

bool CameraTopics::subscribed() const {
  if (visible_points_.getNumSubscribers() > 0) return true;
  return std::any_of(topics_.begin(), topics_.end(), [](const Topic& topic) {
    return topic.image.getNumSubscribers() > 0 || topic.info.getNumSubscribers() > 0;
  });
}

void CameraTopics::publish(const std_msgs::Header& header, unsigned topology_seq,
                           const clothsim::Camera& camera, const clothsim::Images& images) const {
  namespace encodings = sensor_msgs::image_encodings;
  send(topics_[0], header, encodings::RGB8, images, images.color);
  send(topics_[1], header, encodings::TYPE_32FC1, images, images.depth);
  send(topics_[2], header, encodings::MONO8, images, images.mask);
  send(topics_[3], header, encodings::TYPE_32FC2, images, images.uv);
  send(topics_[4], header, encodings::TYPE_32FC3, images, images.normals);
  send(topics_[5], header, encodings::TYPE_32FC2, images, images.flow);
  if (images.visible_points) {
    clothsim::VisiblePoints points;
    points.header = header;
    points.topology_seq = topology_seq;
    points.points = *images.visible_points;
    visible_points_.publish(points);
  }
  const sensor_msgs::CameraInfo info = to_camera_info(camera, header);
  for (const Topic& topic : topics_) topic.info.publish(info);
}

template <class Value>
void CameraTopics::send(const Topic& topic, const std_msgs::Header& header,
                        const std::string& encoding, const clothsim::Images& images,
                        const std::vector<Value>& pixels) const {
  if (pixels.empty()) return;
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->header = header;
  const auto height = static_cast<std::uint32_t>(images.height);
  const std::size_t bytes = pixels.size() * sizeof(Value);
  sensor_msgs::fillImage(*msg, encoding, height, static_cast<std::uint32_t>(images.width),
                         static_cast<std::uint32_t>(bytes) / height, pixels.data());
  topic.image.publish(sensor_msgs::ImageConstPtr(msg));
}

}  // namespace clothsim_ros
