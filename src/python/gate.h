#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace clothsim_python {

namespace py = pybind11;

/// Lets one thread at a time use something. All calls with the GIL held; who waits gives it away,
/// so that the one inside can go on.
class Gate {
 public:
  /// Throws std::runtime_error for a thread that is inside, as a signal's handler may be.
  void enter() {
    const std::thread::id self = std::this_thread::get_id();
    if (owner_ == self) throw std::runtime_error("used again from within one of its own calls");
    if (!mutex_.try_lock()) {
      const py::gil_scoped_release release;
      mutex_.lock();
    }
    owner_ = self;
  }

  void leave() {
    owner_ = std::thread::id();
    mutex_.unlock();
  }

  /// Inside from construction to destruction.
  class Visit {
   public:
    explicit Visit(Gate& gate) : gate_(&gate) { gate.enter(); }
    ~Visit() {
      if (gate_ != nullptr) gate_->leave();
    }
    Visit(Visit&& other) noexcept : gate_(other.gate_) { other.gate_ = nullptr; }
    Visit& operator=(Visit&&) = delete;

   private:
    Gate* gate_;
  };

 private:
  std::mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace clothsim_python
