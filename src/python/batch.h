#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <optional>
#include <vector>

#include "clothsim/model/workers.h"
#include "simulation.h"

namespace clothsim_python {

namespace py = pybind11;

/// clothsim.Batch: many simulations with equal numbers of points, stepped by all cores. Calls take
/// turns.
class Batch {
 public:
  /// `threads` empty: the number of cores of this process. Throws InvalidValue.
  Batch(const py::sequence& simulators, std::optional<int> threads);

  /// Steps each by `frames` and reads their states. `actions` is None, a list of targets as of
  /// Simulation::step(), one for each, or a dict {frame: one of these for each}. Throws
  /// InvalidValue before any step; throws Diverged after all have stepped, with the `environments`
  /// that have diverged.
  py::array step(const py::object& actions, int frames);

  /// Reads the states again, without a step.
  void read();

  const py::tuple& simulators() const { return simulators_; }
  const py::array& positions() const { return positions_; }    // E x N x 3 [m]
  const py::array& velocities() const { return velocities_; }  // E x N x 3 [m/s]
  int threads() const { return workers_.threads(); }

 private:
  using Visits = std::vector<Gate::Visit>;

  /// Waits for all simulations, and checks that they have the arrays' number of points.
  Visits enter_all();
  void set_targets(const std::vector<Targets>&, int frames);
  void copy_state(std::size_t environment);
  /// Runs `action` for each, by all threads, without the GIL; returns the errors by environment.
  template <class Action>
  std::vector<std::exception_ptr> for_all(const Action& action);

  Gate gate_;
  py::tuple simulators_;
  std::vector<Simulation*> simulations_;  // of the tuple
  std::vector<std::size_t> by_address_;   // the order in which they are entered
  py::ssize_t points_ = 0;
  py::array_t<double> positions_;
  py::array_t<double> velocities_;
  double* position_numbers_ = nullptr;  // of the arrays
  double* velocity_numbers_ = nullptr;
  clothsim::Workers workers_;
};

}  // namespace clothsim_python
