// Where methods are stable, by step and stiffness and by step and density: the run of each step is
// compared with a reference, so that stable but wrong runs show, too.

#include <cmath>
#include <memory>

#include "chart.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/grid.h"
#include "dials.h"
#include "reference.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

constexpr int points_a_side = 10;
constexpr double duration = 0.5;

/// Most steps of a run, by the cost of a step.
constexpr int max_steps = 8192;
constexpr int max_iterative_steps = 1024;
constexpr int max_newton_steps = 64;

constexpr int min_reference_steps = 4000;  // of rk4, where the springs alone would allow more

/// Gain of energy over the start, of M g size, that counts as unstable: only gravity, whose energy
/// is counted, does work on an undamped cloth.
constexpr double energy_gain = 0.05;

struct Column {
  std::string varied;  // "ks" or "density"
  double value;
  Scene scene;
  double omega = 0;  // at rest [rad/s]
  Points end;        // of the reference
};

/// Undamped, so that growing oscillations show, and uneven, so that all modes are excited.
Scene scene_of(const std::string& varied, double value) {
  Scene scene = corner_drop(points_a_side);
  Material& material = scene.cloth.material;
  scene.cloth.orientation = Orientation::vertical;
  material.damping = 0;
  (varied == "ks" ? material.ks : material.density) = value;
  return scene;
}

/// `steps` steps as frames of one substep each. False where a step diverged or the energy grew;
/// `end` is then empty.
bool is_stable(Scene scene, const std::string& method, int steps, Points& end) {
  scene.simulation.frames_per_second = steps / duration;
  Simulator simulator(at(scene, {method, 1}));
  const Cloth& cloth = simulator.cloth();
  const Vector3& gravity = scene.simulation.gravity;
  const auto energy = [&] {
    const State& state = simulator.state();
    return kinetic_energy(cloth, state) + elastic_energy(cloth, state.positions) +
           gravitational_energy(cloth, gravity, state.positions);
  };
  const double most = energy() + energy_gain * cloth.mass.sum() * gravity.norm() * size_of(scene);
  end.resize(0, 3);
  try {
    for (int i = 0; i < steps; ++i) {
      simulator.step();
      if (energy() > most) return false;
    }
  } catch (const Diverged&) {
    return false;
  }
  end = simulator.state().positions;
  return true;
}

int finest(const std::string& method) {
  if (method == ImplicitEuler::name || method == Bdf2::name) return max_newton_steps;
  if (method == Xpbd::name) return max_iterative_steps;
  return max_steps;
}

/// Counts of steps, evenly spread over a log scale.
std::vector<int> step_counts(bool quick) {
  std::vector<int> counts;
  const double factor = quick ? 4 : std::sqrt(2);
  for (double n = 4; n < 1.01 * max_steps; n *= factor) {
    counts.push_back(static_cast<int>(std::lround(n)));
  }
  return counts;
}

void prepare(Column& column) {
  const Cloth cloth = make_grid(column.scene.cloth);
  column.omega = omega_max_bound(cloth, cloth.rest_positions);
  const int steps =
      std::max(min_reference_steps, static_cast<int>(std::ceil(8 * column.omega * duration)));
  if (!is_stable(column.scene, RungeKutta4::name, steps, column.end)) {
    throw Diverged("the reference of a stability map diverged");
  }
}

}  // namespace

std::vector<Job> stability_jobs(const Options& options) {
  auto table = std::make_shared<Table>(std::vector<std::string>{
      "method", "varied", "value", "step_s", "status", "position_error", "limit_s"});
  std::vector<Job> jobs;
  for (const char* varied : {"ks", "density"}) {
    const bool of_ks = std::string(varied) == "ks";
    const int columns = options.quick ? 2 : 11;
    for (int i = 0; i < columns; ++i) {
      const double value = (of_ks ? 5e2 : 0.15) * std::pow(10, i * 5.0 / (columns - 1));
      auto column = std::make_shared<Column>();
      column->varied = varied;
      column->value = value;
      column->scene = scene_of(varied, value);
      jobs.push_back([=] { prepare(*column); });
      for (const std::string& method : method_names()) {
        if (!wanted(options.methods, method)) continue;
        jobs.push_back([=] {
          const double limit =
              std::visit([](const auto& m) { return m.stability_limit; }, make_integrator(method));
          for (const int steps : step_counts(options.quick)) {
            if (steps > finest(method)) break;
            Points end;
            const bool stable = is_stable(column->scene, method, steps, end);
            const double nan = std::numeric_limits<double>::quiet_NaN();
            const double error =
                stable ? rms_distance(end, column->end) / size_of(column->scene) : nan;
            table->add({method, column->varied, column->value, duration / steps,
                        stable ? "done" : "failed", error, limit / column->omega});
          }
        });
      }
    }
  }
  jobs.push_back([=] { table->write(options.output / "stability.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
