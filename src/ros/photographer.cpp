#include "clothsim/ros/photographer.h"

#include <ros/console.h>

#include <algorithm>
#include <utility>

#include "clothsim/ros/conversions.h"
#include "clothsim/view/resources.h"

namespace clothsim_ros {
namespace {

/// Bound on the rounding of frames' times, which are sums of their durations [s].
constexpr double time_tolerance = 1e-6;

/// `/a/clothsim` has `camera` on `a_clothsim_camera_optical`.
std::string own_frame_name(const ros::NodeHandle& node, const std::string& camera) {
  std::string name = node.getNamespace().substr(1);
  std::replace(name.begin(), name.end(), '/', '_');
  return name + '_' + camera + "_optical";
}

clothsim::ImageFolders with_own(std::vector<std::string> folders) {
  folders.insert(folders.begin(), clothsim::textures_folder());
  return clothsim::ImageFolders(folders);
}

}  // namespace

Photographer::Photographer(const ros::NodeHandle& node, const clothsim::NamedView& camera,
                           const clothsim::Simulator& simulator, TfListener& tf,
                           Broadcast broadcast, std::vector<std::string> image_folders,
                           const ros::Time& now)
    : name_(camera.name),
      simulator_(simulator),
      tf_(tf),
      broadcast_(std::move(broadcast)),
      images_(clothsim::textures_folder(), with_own(std::move(image_folders))),
      shaders_(clothsim::shaders_folder()),
      own_frame_(own_frame_name(node, name_)),
      stamp_(now),
      topics_(node, name_, [this] { redraw(); }) {
  set_view(camera.view);
  adopt();
}

clothsim::View Photographer::view() const {
  const std::lock_guard lock(newest_mutex_);
  return newest_;
}

void Photographer::set_view(const clothsim::View& view) {
  change_view([&](clothsim::View& newest) { newest = view; });
}

void Photographer::change_view(const std::function<void(clothsim::View&)>& change) {
  const std::lock_guard change_lock(change_mutex_);
  Sight sight;
  sight.view = view();
  change(sight.view);
  sight.prepared = clothsim::prepare(sight.view, images_);
  images_.sweep();
  const std::lock_guard lock(newest_mutex_);
  newest_ = sight.view;
  set_ = std::move(sight);
}

void Photographer::adopt() {
  std::optional<Sight> sight;
  {
    const std::lock_guard lock(newest_mutex_);
    sight.swap(set_);
  }
  if (!sight) return;
  view_ = std::move(sight->view);
  prepared_ = std::move(sight->prepared);
  if (view_.frame.empty()) {
    frame_.reset();
  } else if (!frame_ || frame_->status().frame != view_.frame) {
    frame_.emplace(view_.frame, tf_);
  }
  move_camera();
  if (!frame_) broadcast_own_frame();
  redraw();
}

bool Photographer::move_camera() {
  if (!frame_) return false;
  frame_->look_up();
  if (!frame_->pose() || same(*frame_->pose(), prepared_.camera.pose)) return false;
  prepared_.camera.pose = *frame_->pose();
  return true;
}

void Photographer::redraw() {
  taken_ = false;
  anew_ = true;
}

void Photographer::update(const ros::Time& stamp) {
  adopt();
  stamp_ = stamp;
  taken_ = false;
  stands_ = after_a_period();
  if (!topics_.subscribed()) return;

  // Also due: the first picture after a reset, and after a change of the rate.
  const double time = simulator_.state().time;
  const double period = 1 / view_.rate;
  if (next_ > time + period) next_ = time;
  if (next_ > time + time_tolerance) return;
  next_ = std::max(next_, time - period) + period;
  take();
}

ros::SteadyTime Photographer::after_a_period() const {
  return ros::SteadyTime::now() + ros::WallDuration(1 / view_.rate);
}

void Photographer::take() {
  taken_ = true;
  anew_ = false;
  topology_seq_ = simulator_.topology_seq();
  next_refresh_ = after_a_period();
  move_camera();
  broadcast_own_frame();

  clothsim::RenderJob job;
  job.wanted = topics_.wanted();
  if (!job.wanted.any()) {  // a camera_info needs no picture
    topics_.publish(header(), topology_seq_, prepared_.camera, {});
    return;
  }
  if (!renderer_) {
    renderer_.emplace(clothsim::RendererOptions{shaders_, view_.egl_device, view_.samples, false});
  }
  job.snapshot = snapshots_.make(simulator_, prepared_);
  job.camera = prepared_.camera;
  job.done = [this, header = header(), seq = topology_seq_, camera = job.camera](
                 const clothsim::Images& images) { topics_.publish(header, seq, camera, images); };
  renderer_->submit(std::move(job));
}

void Photographer::wait() {
  if (renderer_) renderer_->wait();
}

void Photographer::finish() {
  if (view_.each_step && !taken_ && topics_.subscribed()) take();
  taken_ = true;  // or not wanted
  wait();
}

void Photographer::refresh(bool paused) {
  adopt();
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (!topics_.subscribed() || now < next_refresh_ || (!paused && now < stands_)) return;
  if (move_camera() || topology_seq_ != simulator_.topology_seq()) redraw();
  if (anew_ || (paused && !taken_)) take();
}

std_msgs::Header Photographer::header() const {
  std_msgs::Header header;
  header.stamp = stamp_;
  header.frame_id = frame_ && frame_->pose() ? frame_->status().frame : own_frame_;
  return header;
}

/// Also before the first picture: without any transform RViz warns that there is no world frame.
void Photographer::broadcast_own_frame() {
  const clothsim::Pose& pose = prepared_.camera.pose;
  if (frame_ && frame_->pose()) return;
  if (own_pose_ && same(*own_pose_, pose)) return;
  geometry_msgs::TransformStamped msg;
  msg.header.stamp = stamp_;
  msg.header.frame_id = tf_.world_frame();
  msg.child_frame_id = own_frame_;
  msg.transform = to_transform_msg(pose);
  broadcast_(msg);
  own_pose_ = pose;
}

CameraStatus Photographer::status() {
  CameraStatus status;
  status.name = name_;
  if (renderer_) status.render = renderer_->status();
  status.subscribed = topics_.wanted();
  if (frame_) status.frame = frame_->status();

  const ros::SteadyTime now = ros::SteadyTime::now();
  const int drawn = status.render.drawn - std::exchange(drawn_, status.render.drawn);
  const int dropped = status.render.dropped - std::exchange(dropped_, status.render.dropped);
  rate_.add(drawn);
  status.rate = rate_.take(now.toSec());
  if (drawn + dropped > 0) status.drawn_share = drawn / static_cast<double>(drawn + dropped);

  const std::string& failure = status.render.failure;
  if (failure != logged_ && !failure.empty())
    ROS_WARN("No images of %s: %s", name_.c_str(), failure.c_str());
  logged_ = failure;
  return status;
}

}  // namespace clothsim_ros
