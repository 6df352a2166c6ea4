#pragma once

#include <QObject>
#include <functional>
#include <memory>
#include <string>

namespace clothsim_rviz {

/// Service calls, one after the other in a thread of their own, so that a busy node does not block
/// RViz.
class CallQueue : public QObject {
 public:
  /// Handles a response, in RViz's thread.
  using Answer = std::function<void()>;
  using Call = std::function<Answer()>;

  CallQueue();
  /// Waits a moment for running calls. Later responses are dropped.
  ~CallQueue() override;
  CallQueue(const CallQueue&) = delete;
  CallQueue& operator=(const CallQueue&) = delete;

  void post(Call);

 private:
  struct Shared;
  static void work(const std::shared_ptr<Shared>&);

  std::shared_ptr<Shared> shared_;  // the thread may outlive this, in a call that does not return
};

/// Calls a service whose response has success and message. Returns an error message; empty:
/// success.
template <class Service>
std::string refusal_of(const std::string& name, Service& service);

}  // namespace clothsim_rviz

#include <ros/service.h>

template <class Service>
std::string clothsim_rviz::refusal_of(const std::string& name, Service& service) {
  if (!ros::service::call(name, service)) return "no answer from " + name;
  if (service.response.success) return "";
  return service.response.message.empty() ? name + " refused" : service.response.message;
}
