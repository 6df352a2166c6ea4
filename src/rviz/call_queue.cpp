#include "call_queue.h"

#include <QMetaObject>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace clothsim_rviz {
namespace {

/// How long RViz waits at its end for calls, such as the one that detaches the cloth.
constexpr std::chrono::seconds last_moment(2);

}  // namespace

struct CallQueue::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Call> calls;
  bool busy = false;
  QObject* owner = nullptr;  // null: destroyed
};

CallQueue::CallQueue() : shared_(std::make_shared<Shared>()) {
  shared_->owner = this;
  std::thread([shared = shared_] { work(shared); }).detach();
}

CallQueue::~CallQueue() {
  std::unique_lock<std::mutex> lock(shared_->mutex);
  shared_->changed.wait_for(lock, last_moment,
                            [this] { return shared_->calls.empty() && !shared_->busy; });
  shared_->owner = nullptr;
  shared_->calls.clear();
  shared_->changed.notify_all();
}

void CallQueue::post(Call call) {
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  shared_->calls.push_back(std::move(call));
  shared_->changed.notify_all();
}

void CallQueue::work(const std::shared_ptr<Shared>& shared) {
  std::unique_lock<std::mutex> lock(shared->mutex);
  while (true) {
    shared->changed.wait(lock, [&] { return !shared->calls.empty() || shared->owner == nullptr; });
    if (shared->owner == nullptr) return;
    const Call call = std::move(shared->calls.front());
    shared->calls.pop_front();
    shared->busy = true;
    lock.unlock();
    Answer answer = call();
    lock.lock();
    shared->busy = false;
    shared->changed.notify_all();
    if (shared->owner != nullptr && answer) {
      QMetaObject::invokeMethod(shared->owner, std::move(answer), Qt::QueuedConnection);
    }
  }
}

}  // namespace clothsim_rviz
