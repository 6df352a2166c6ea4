#include "dials.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/grid.h"

namespace clothsim::work_precision {
namespace {

/// Tolerance of Newton's method: rounding, for a step of a thousandth of a millimetre.
constexpr double newton_tolerance = 1e-8;

/// Most substeps a frame with iterations to convergence, which takes milliseconds a step.
constexpr int max_converged_substeps = 4;

/// Most substeps of explicit methods: on a stiff ribbon they take seconds.
constexpr int max_explicit_substeps = 4096;

template <typename Value>
struct Assign {
  const std::string wanted;
  const Value to;
  template <typename Any>
  void operator()(const std::string& key, Any& value, const Range&) const {
    if constexpr (std::is_same_v<Any, Value>) {
      if (key == wanted) value = to;
    }
  }
};

/// Sets parameter `key` in the method that has it.
template <typename Value>
void set_parameter(MethodParameters& parameters, const std::string& key, Value value) {
  std::visit(
      [&](auto& p) {
        using P = std::decay_t<decltype(p)>;
        if constexpr (!std::is_same_v<P, std::monostate>) P::each(p, Assign<Value>{key, value});
      },
      parameters);
}

bool uses_newton(const std::string& method) {
  return method == ImplicitEuler::name || method == Bdf2::name;
}

}  // namespace

Scene at(Scene scene, const Dial& dial) {
  SimulationSpec& simulation = scene.simulation;
  simulation.method = dial.method;
  simulation.substeps = dial.substeps;
  simulation.method_parameters = default_parameters(dial.method);
  if (dial.iterations) {
    set_parameter(simulation.method_parameters, "iterations", *dial.iterations);
  }
  if (dial.is_single) {
    using Parameters = VelocityVerlet::Parameters;
    simulation.method_parameters = Parameters{Parameters::single_precision};
  }
  return scene;
}

std::optional<Scene> converged(Scene scene, const Dial& dial) {
  if (dial.method != Xpbd::name && !uses_newton(dial.method)) return {};
  if (!dial.substeps || *dial.substeps > max_converged_substeps) return {};
  scene = at(scene, {uses_newton(dial.method) ? dial.method : ImplicitEuler::name, dial.substeps});
  set_parameter(scene.simulation.method_parameters, "tolerance", newton_tolerance);
  set_parameter(scene.simulation.method_parameters, "max_iterations", 200);
  return scene;
}

std::vector<Dial> dials(const Trial& trial, bool quick) {
  std::vector<int> explicit_steps =
      quick ? std::vector{1, 4, 8, 16} : std::vector{1, 2, 3, 4, 5, 6, 8, 12, 16, 32, 64, 128};
  const Cloth cloth = make_grid(trial.scene.cloth);
  const double least =
      omega_max_bound(cloth, cloth.rest_positions) / (2 * trial.scene.simulation.frames_per_second);
  const int unit = std::max(1, static_cast<int>(std::lround(least / 4)));
  for (int& steps : explicit_steps) steps = std::min(steps * unit, max_explicit_substeps);
  explicit_steps.erase(std::unique(explicit_steps.begin(), explicit_steps.end()),
                       explicit_steps.end());
  std::vector<Dial> list;
  if (!trial.reference_damping) list.push_back({"auto", {}});  // its choice is for motion
  for (const std::string& method : method_names()) {
    if (uses_newton(method)) {
      for (int n = 1; n <= trial.max_newton_substeps; n *= 2) list.push_back({method, n});
    } else if (method == Xpbd::name) {
      for (const int n : quick ? std::vector{8} : std::vector{1, 2, 4, 8, 16, 30, 64, 128, 256}) {
        list.push_back({method, n, 1});
      }
      if (!quick) {
        for (const int iterations : {5, 20}) list.push_back({method, 4, iterations});
      }
    } else {
      for (const int n : explicit_steps) list.push_back({method, n});
    }
  }
  for (const int n : explicit_steps) list.push_back({VelocityVerlet::name, n, {}, true});
  return list;
}

}  // namespace clothsim::work_precision
