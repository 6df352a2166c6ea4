#include "clothsim/ros/cameras.h"

#include <algorithm>

#include "clothsim/ros/parameters.h"

namespace clothsim_ros {

Cameras::Cameras(const ros::NodeHandle& node, const std::vector<clothsim::NamedView>& cameras,
                 const clothsim::Simulator& simulator, TfListener& tf,
                 const std::vector<std::string>& image_folders, const ros::Time& now) {
  for (const clothsim::NamedView& camera : cameras) {
    with_full_name(node, "camera/", [&] {
      cameras_.emplace_back(
          node, camera, simulator, tf,
          [this](const geometry_msgs::TransformStamped& msg) { broadcast(msg); }, image_folders,
          now);
    });
  }
}

void Cameras::broadcast(const geometry_msgs::TransformStamped& msg) {
  if (!broadcaster_) broadcaster_.emplace();
  broadcaster_->sendTransform(msg);
}

std::vector<std::string> Cameras::names() const {
  std::vector<std::string> names;
  for (const Photographer& camera : cameras_) names.push_back(camera.name());
  return names;
}

std::vector<clothsim::View> Cameras::views() const {
  std::vector<clothsim::View> views;
  for (const Photographer& camera : cameras_) views.push_back(camera.view());
  return views;
}

void Cameras::set_views(const std::vector<clothsim::View>& views) {
  const std::vector<clothsim::View> last = this->views();
  const auto set = [this](const std::vector<clothsim::View>& all) {
    auto view = all.begin();
    for (Photographer& camera : cameras_) {
      clothsim::inside(camera.name(), [&] { camera.set_view(*view++); });
    }
  };
  try {
    set(views);
  } catch (const clothsim::InvalidValue&) {
    set(last);
    throw;
  }
}

void Cameras::change_view(const std::string& name,
                          const std::function<void(clothsim::View&)>& change) {
  const auto camera = std::find_if(cameras_.begin(), cameras_.end(),
                                   [&](const Photographer& c) { return c.name() == name; });
  camera->change_view(change);
}

void Cameras::change_looks(const std::function<void(clothsim::View&)>& change) {
  for (Photographer& camera : cameras_) camera.change_view(change);
}

void Cameras::update(const ros::Time& stamp) {
  for (Photographer& camera : cameras_) camera.update(stamp);
}

void Cameras::wait() {
  for (Photographer& camera : cameras_) camera.wait();
}

void Cameras::finish() {
  for (Photographer& camera : cameras_) camera.finish();
}

void Cameras::refresh(bool paused) {
  for (Photographer& camera : cameras_) camera.refresh(paused);
}

void Cameras::redraw() {
  for (Photographer& camera : cameras_) camera.redraw();
}

std::vector<CameraStatus> Cameras::status() {
  std::vector<CameraStatus> all;
  for (Photographer& camera : cameras_) all.push_back(camera.status());
  return all;
}

}  // namespace clothsim_ros
