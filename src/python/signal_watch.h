#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "gate.h"

namespace clothsim_python {

namespace py = pybind11;

/// Checks, while a call computes without the GIL, whether Ctrl-C or another signal should end it;
/// the end of Python does, too. One per call: the calling thread asks Python, others only read the
/// answer.
class SignalWatch {
 public:
  /// True when the call should end.
  bool asks_to_end() {
    if (error_came_ || Calls::must_end(caller_)) return true;
    if (std::this_thread::get_id() != caller_) return false;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_look_) return false;
    next_look_ = now + period;
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() == 0) return false;
    error_ = std::make_unique<py::error_already_set>();
    error_came_ = true;
    return true;
  }

  /// With the GIL held: raises the exception of the signal's handler, such as KeyboardInterrupt.
  void raise() {
    if (error_) throw py::error_already_set(*error_);
  }

 private:
  /// Too short to notice, and long enough to need the GIL rarely.
  static constexpr std::chrono::milliseconds period{50};

  std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point next_look_ = std::chrono::steady_clock::now() + period;
  std::atomic<bool> error_came_{false};
  std::unique_ptr<py::error_already_set> error_;
};

}  // namespace clothsim_python
