#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace clothsim_python {

namespace py = pybind11;

/// Calls of this module that are under way. A thread that came back from a computation when Python
/// has ended would take the process down: the calls of daemon threads end before.
class Calls {
 public:
  /// With the GIL held. Throws std::runtime_error when Python is ending, but in its last thread.
  static void begin() {
    if (must_end(std::this_thread::get_id())) throw std::runtime_error("Python is ending");
    ++count_;
  }

  static void end() { --count_; }

  /// Whether calls that `thread` has made are to be broken off.
  static bool must_end(std::thread::id thread) { return ending_ && thread != last_thread_; }

  /// Has Python wait, when it ends, until there are none.
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

/// Lets one thread at a time use something. All calls with the GIL held; who waits gives it away,
/// so that the one inside can go on.
class Gate {
 public:
  /// Inside from construction to destruction. Throws std::runtime_error for a thread that is inside
  /// already, as a signal's handler may be, and when Python is ending.
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
