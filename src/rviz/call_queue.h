#pragma once

#include <QObject>
#include <functional>
#include <memory>
#include <string>

namespace clothsim_rviz {

/// Calls of services, one after the other in a thread of their own: a node that is busy does not
/// stop RViz.
class CallQueue : public QObject {
 public:
  /// What to do with an answer, in RViz's thread.
  using Answer = std::function<void()>;
  using Call = std::function<Answer()>;

  CallQueue();
  /// Gives calls under way a moment. Answers are dropped from now on.
  ~CallQueue() override;
  CallQueue(const CallQueue&) = delete;
  CallQueue& operator=(const CallQueue&) = delete;

  void post(Call);

 private:
  struct Shared;
  static void work(const std::shared_ptr<Shared>&);

  std::shared_ptr<Shared> shared_;  // the thread may outlive this, in a call that does not return
};

/// Calls a service whose response has success and message. Empty: it succeeded; else why not.
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
