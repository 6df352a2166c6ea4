#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>

#include <atomic>
#include <future>
#include <pluginlib/class_list_macros.hpp>
#include <thread>

#include "clothsim/ros/node.h"

namespace clothsim_ros {

/// The node as a nodelet, with a thread of its own beside its manager's threads: others in the
/// process get its messages by shared pointer.
class ClothNodelet : public nodelet::Nodelet {
 public:
  ~ClothNodelet() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  /// Throws the node's exceptions for a bad parameter.
  void onInit() override {
    std::promise<void> started;
    std::future<void> start = started.get_future();
    thread_ = std::thread([this, started = std::move(started)]() mutable { run(started); });
    start.get();
  }

  void run(std::promise<void>& started) {
    bool is_made = false;
    try {
      Node node(getPrivateNodeHandle(), queue_, [this] { return ends_.load(); });
      is_made = true;
      started.set_value();
      node.run();
    } catch (const std::exception& error) {
      NODELET_FATAL("%s", error.what());
      if (!is_made) started.set_exception(std::current_exception());
    }
  }

  ros::CallbackQueue queue_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace clothsim_ros

PLUGINLIB_EXPORT_CLASS(clothsim_ros::ClothNodelet, nodelet::Nodelet)
