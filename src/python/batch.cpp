#include "batch.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <thread>

#include "clothsim/model/checks.h"
#include "errors.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;

int checked_threads(std::optional<int> threads) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  constexpr clothsim::Range range = clothsim::threads_range;
  if (!threads) return std::clamp(cores, 1, static_cast<int>(range.max));
  clothsim::check_range("threads", *threads, range);
  return *threads;
}

/// The simulations that an interrupt of the call stops.
class WatchedAll {
 public:
  WatchedAll(const std::vector<Simulation*>& all, SignalWatch& watch) : all_(all) {
    for (Simulation* one : all_) one->run()->watch = &watch;
  }
  ~WatchedAll() {
    for (Simulation* one : all_) one->run()->watch = nullptr;
  }

 private:
  const std::vector<Simulation*>& all_;
};

/// Row by row, as in numpy.
void copy_rows(const clothsim::Points& points, double* numbers) {
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) *numbers++ = points(i, axis);
  }
}

/// The targets of each of `count` environments, from a list or a dict of arrays.
std::vector<Targets> to_actions(const py::object& actions, std::size_t count) {
  std::vector<Targets> all(count);
  if (actions.is_none()) return all;
  const auto check_count = [&](std::size_t got, const std::vector<std::string>& key) {
    if (got == count) return;
    throw InvalidValue(key, std::to_string(got) + " items",
                       std::to_string(count) + ", one for each simulator");
  };
  if (py::isinstance<py::dict>(actions)) {
    for (const auto& [frame, poses] : py::reinterpret_borrow<py::dict>(actions)) {
      if (!py::isinstance<py::str>(frame) || !py::isinstance<py::sequence>(poses)) {
        throw InvalidValue({"actions"}, "a dict with something else",
                           "a dict from frames to arrays of poses");
      }
      const auto items = py::reinterpret_borrow<py::sequence>(poses);
      check_count(items.size(), {"actions", py::cast<std::string>(frame)});
      for (std::size_t e = 0; e < count; ++e) {
        py::dict one;
        one[frame] = items[e];
        clothsim::inside("actions", [&] { all[e].merge(to_targets(one, std::to_string(e))); });
      }
    }
    return all;
  }
  if (!py::isinstance<py::sequence>(actions) || py::isinstance<py::str>(actions)) {
    throw InvalidValue({"actions"}, describe(actions), "a list or a dict");
  }
  const auto items = py::reinterpret_borrow<py::sequence>(actions);
  check_count(items.size(), {"actions"});
  for (std::size_t e = 0; e < count; ++e) {
    clothsim::inside("actions", [&] { all[e] = to_targets(items[e], std::to_string(e)); });
  }
  return all;
}

std::string joined(const std::vector<int>& numbers) {
  std::vector<std::string> words;
  for (const int number : numbers) words.push_back(std::to_string(number));
  constexpr std::size_t longest = 200;
  return clothsim::shortened(clothsim::join(words), longest);
}

/// Throws the first error other than Diverged, else one Diverged for all environments that have
/// one.
void raise_errors(const std::vector<std::exception_ptr>& errors, SignalWatch& watch) {
  std::vector<int> diverged;
  std::string first;
  for (std::size_t e = 0; e < errors.size(); ++e) {
    if (!errors[e]) continue;
    try {
      std::rethrow_exception(errors[e]);
    } catch (const clothsim::Interrupted&) {
      watch.raise();
      throw;
    } catch (const clothsim::Diverged& error) {
      if (diverged.empty()) first = error.what();
      diverged.push_back(static_cast<int>(e));
    }
  }
  if (diverged.empty()) return;
  const py::object type = py::module_::import("clothsim").attr("Diverged");
  const py::object exception = type("environments " + joined(diverged) + ": " + first);
  exception.attr("environments") = diverged;
  PyErr_SetObject(type.ptr(), exception.ptr());
  throw py::error_already_set();
}

}  // namespace

Batch::Batch(const py::sequence& simulators, std::optional<int> threads)
    : simulators_(simulators), workers_(checked_threads(threads)) {
  if (simulators_.empty()) throw InvalidValue({"simulators"}, "none", "at least one");
  std::set<Simulation*> seen;
  for (const py::handle item : simulators_) {
    const std::string index = std::to_string(simulations_.size());
    if (!py::isinstance<Simulation>(item)) {
      throw InvalidValue({"simulators", index}, describe(item), "a Simulator");
    }
    simulations_.push_back(py::cast<Simulation*>(item));
    if (!seen.insert(simulations_.back()).second) {
      throw InvalidValue({"simulators", index}, "one that is there already", "each once");
    }
  }
  by_address_.resize(simulations_.size());
  std::iota(by_address_.begin(), by_address_.end(), std::size_t{0});
  std::sort(by_address_.begin(), by_address_.end(), [&](std::size_t a, std::size_t b) {
    return std::less<>()(simulations_[a], simulations_[b]);
  });

  points_ = simulations_.front()->run()->simulator.cloth().num_points();
  const std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(simulations_.size()), points_,
                                          3};
  for (py::array_t<double>* array : {&positions_, &velocities_}) {
    *array = py::array_t<double>(shape);
  }
  position_numbers_ = positions_.mutable_data();
  velocity_numbers_ = velocities_.mutable_data();
  for (py::array_t<double>* array : {&positions_, &velocities_}) {
    array->attr("flags").attr("writeable") = false;
  }
  read();
}

Batch::Visits Batch::enter_all() {
  Visits visits;
  for (const std::size_t i : by_address_) visits.emplace_back(simulations_[i]->gate());
  for (std::size_t e = 0; e < simulations_.size(); ++e) {
    const int points = simulations_[e]->run()->simulator.cloth().num_points();
    if (points == points_) continue;
    throw InvalidValue({"simulators", std::to_string(e)}, std::to_string(points) + " points",
                       std::to_string(points_) + ", as the first has");
  }
  return visits;
}

void Batch::set_targets(const std::vector<Targets>& actions, int frames) {
  clothsim::inside("actions", [&] {
    for (std::size_t e = 0; e < actions.size(); ++e) {
      clothsim::inside(std::to_string(e),
                       [&] { check_targets(actions[e], *simulations_[e]->run()); });
    }
    for (std::size_t e = 0; e < actions.size(); ++e) {
      Run& run = *simulations_[e]->run();
      if (!actions[e].empty()) run.frames.set_targets(actions[e], frames, run.simulator);
    }
  });
}

void Batch::copy_state(std::size_t environment) {
  const clothsim::State& state = simulations_[environment]->run()->simulator.state();
  const auto offset = static_cast<std::size_t>(3 * points_) * environment;
  copy_rows(state.positions, position_numbers_ + offset);
  copy_rows(state.velocities, velocity_numbers_ + offset);
}

template <class Action>
std::vector<std::exception_ptr> Batch::for_all(const Action& action) {
  const py::gil_scoped_release release;
  const int count = static_cast<int>(simulations_.size());
  std::vector<std::exception_ptr> errors(simulations_.size());
  const auto act = [&](int begin, int end) {
    for (auto e = static_cast<std::size_t>(begin); e < static_cast<std::size_t>(end); ++e) {
      try {
        action(e);
      } catch (...) {
        errors[e] = std::current_exception();
      }
      copy_state(e);
    }
  };
  workers_.parallel_for(count, act, 1, count);  // one by one, as they take unequal times
  return errors;
}

py::array Batch::step(const py::object& actions, int frames) {
  check_frames(frames);
  const std::vector<Targets> targets = to_actions(actions, simulations_.size());
  const Gate::Visit visit(gate_);
  const Visits visits = enter_all();
  set_targets(targets, frames);
  SignalWatch watch;
  const WatchedAll watched(simulations_, watch);
  raise_errors(for_all([&](std::size_t e) { simulations_[e]->run()->step(frames); }), watch);
  return positions_;
}

void Batch::read() {
  const Gate::Visit visit(gate_);
  const Visits visits = enter_all();
  for_all([](std::size_t) {});
}

}  // namespace clothsim_python
