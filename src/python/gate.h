#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace clothsim_python {

namespace py = pybind11;

/// Running calls of this module. A thread that returns from a computation after Python has ended
/// would crash the process, so calls of daemon threads are ended before.
class Calls {
 public:
  /// With the GIL held. Throws std::runtime_error while Python is ending, except in its last
  /// thread.
  static void begin() {
    if (must_end(std::this_thread::get_id())) throw std::runtime_error("Python is ending");
    ++count_;
  }

  static void end() { --count_; }

  /// Whether calls from `thread` must stop.
  static bool must_end(std::thread::id thread) { return ending_ && thread != last_thread_; }

  /// Makes Python wait, when it ends, until no call is running.
  static void end_with_python() {
    py::module_::import("atexit").attr("register")(py::cpp_function([] {
      last_thread_ = std::this_thread::get_id();
      ending_ = true;
      const py::gil_scoped_release release;
      while (count_ > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }));
  }

 private:
  static inline std::atomic<int> count_{0};
  static inline std::atomic<bool> ending_{false};
  static inline std::atomic<std::thread::id> last_thread_{};
};

/// Lets one thread at a time use an object. All calls with the GIL held; a waiting thread releases
/// it, so that the thread inside can continue.
class Gate {
 public:
  /// Inside from construction to destruction. Throws std::runtime_error for a thread that is inside
  /// already, as a signal's handler may be, and while Python is ending.
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
  void enter() {
    const std::thread::id self = std::this_thread::get_id();
    if (owner_ == self) throw std::runtime_error("used again from within one of its own calls");
    Calls::begin();
    if (!mutex_.try_lock()) {
      const py::gil_scoped_release release;
      mutex_.lock();
    }
    owner_ = self;
  }

  void leave() {
    owner_ = std::thread::id();
    mutex_.unlock();
    Calls::end();
  }

  std::mutex mutex_;
  std::atomic<std::thread::id> owner_{};
};

}  // namespace clothsim_python
