// The remaining violation of the strain limit, and the error of the rest shape, against cost.

#include <algorithm>
#include <memory>

#include "chart.h"
#include "classic.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/model/grid.h"
#include "dials.h"
#include "reference.h"
#include "table.h"

namespace clothsim::work_precision {
namespace {

struct Shared {
  Trial trial;
  Points rest;  // converged
  Table table{{"solver", "substeps", "tolerance", "passes", "status", "cost_ms_per_s",
               "sweeps_per_substep", "violation", "worst_violation", "rest_error", "rest_error_max",
               "rest_speed"}};
};

/// pinned2 at its defaults until it hangs still.
Trial hanging(bool quick) {
  return {"pinned2", shipped_scene("pinned2", quick ? 10 : 50), 540, Compared::rest_shape, false, 0,
          false};
}

/// Violation: stretch above the limit, of the rest length, at the end and the worst in any frame.
void measure(Shared& shared, const std::string& solver, double tolerance, int passes,
             const StepperMaker& make) {
  const Run result = run(make, shared.trial.frames);
  const Cloth cloth = make_grid(shared.trial.scene.cloth);
  const auto violation = [&](const State& state) {
    return std::max(0.0, worst_stretch(cloth, state.positions) - *cloth.strain_limit);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  double last = nan, worst = nan, rms = nan, farthest = nan, speed = nan;
  if (result.outcome == Outcome::done) {
    const State& end = result.trajectory.back();
    last = violation(end);
    for (const State& state : result.trajectory) worst = std::fmax(worst, violation(state));
    rms = rms_distance(end.positions, shared.rest);
    farthest = (end.positions - shared.rest).rowwise().norm().maxCoeff();
    speed = rms_velocity(end);
  }
  shared.table.add({solver, result.substeps, tolerance, passes, name_of(result.outcome),
                    result.cost, result.sweeps, last, worst, rms, farthest, speed});
}

}  // namespace

std::vector<Job> strain_limit_jobs(const Options& options) {
  auto shared = std::make_shared<Shared>();
  shared->trial = hanging(options.quick);
  std::vector<Job> jobs;
  jobs.push_back([=] {
    Scene scene = shared->trial.scene;
    scene.simulation.substeps = options.quick ? 20 : 52;
    scene.simulation.strain_tolerance = 1e-6;
    scene.simulation.method = VelocityVerlet::name;
    shared->rest =
        run(simulator_of(scene), shared->trial.frames, {0, 300}).trajectory.back().positions;
  });

  // The shipped limit, by its tolerance and the substeps.
  const auto tolerances =
      options.quick ? std::vector{0.004} : std::vector{0.1, 0.03, 0.01, 0.004, 1e-3, 1e-4, 1e-5};
  for (const int substeps : options.quick ? std::vector{0} : std::vector{0, 30}) {
    for (const double tolerance : tolerances) {
      jobs.push_back([=] {
        Scene scene = shared->trial.scene;
        if (substeps > 0) scene.simulation.substeps = substeps;
        scene.simulation.strain_tolerance = tolerance;
        measure(*shared, substeps > 0 ? "clothsim" : "auto", tolerance, 0, simulator_of(scene));
      });
    }
  }

  // The classic limit: 30 substeps and one pass; or more passes.
  for (const bool follow : {false, true}) {
    for (const int passes : options.quick ? std::vector{1} : std::vector{1, 4, 16}) {
      jobs.push_back([=] {
        measure(*shared, follow ? "classic_verlet" : "classic",
                std::numeric_limits<double>::quiet_NaN(), passes,
                classic(shared->trial.scene, 30, passes, follow));
      });
    }
  }
  jobs.push_back([=] { shared->table.write(options.output / "strain_limit.csv"); });
  return jobs;
}

}  // namespace clothsim::work_precision
