#include "reference.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/grid.h"

namespace clothsim::work_precision {
namespace {

constexpr double nudge = 1e-10;  // of the size

/// How far inside Verlet's limit its coarsest reference run stays: h omega is at most 2 /
/// refinement, or as near to it as the largest number of substeps allows.
constexpr double refinement = 16;
constexpr double rough_refinement = 32;  // where contact or the strain limit lower the order
constexpr double cheap_refinement = 1.25;

/// Violation at which sweeps of the constraints end, so that only the error of the step is left.
constexpr double strain_tolerance = 1e-6;

Trajectory follow(Scene scene, const std::string& method, int substeps, int frames) {
  scene.simulation.method = method;
  scene.simulation.method_parameters = {};
  scene.simulation.substeps = substeps;
  scene.simulation.strain_tolerance = strain_tolerance;
  Run result = run(simulator_of(scene), frames, {0, infinity});
  if (result.outcome != Outcome::done) {
    throw Diverged("the reference diverged with " + method + " and " + std::to_string(substeps) +
                   " substeps a frame");
  }
  return std::move(result.trajectory);
}

}  // namespace

Scene twin_of(Scene scene) {
  scene.cloth.width *= 1 + nudge;
  scene.cloth.height *= 1 - nudge;
  scene.simulation.gravity += nudge * scene.simulation.gravity.norm() * Vector3(1, 0.7, 0.3);
  return scene;
}

double size_of(const Scene& scene) { return std::max(scene.cloth.width, scene.cloth.height); }

double rms_distance(const Points& a, const Points& b) {
  return (a - b).norm() / std::sqrt(static_cast<double>(a.rows()));
}

double rms_distance(const Trajectory& a, const Trajectory& b, std::size_t frames) {
  double sum = 0;
  for (std::size_t i = a.size() - frames; i < a.size(); ++i) {
    const double d = rms_distance(a[i].positions, b[i].positions);
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(frames));
}

namespace {

/// Steps a frame that keep h omega at 2 / `share` or less.
int substeps_of(const Scene& scene, double share) {
  const Cloth cloth = make_grid(scene.cloth);
  const double omega = omega_max_bound(cloth, cloth.rest_positions);
  return static_cast<int>(std::ceil(share * omega / (2 * scene.simulation.frames_per_second)));
}

/// Verlet at three steps.
Reference extrapolate(const Trial& trial, int coarsest) {
  const Trajectory coarse = follow(trial.scene, VelocityVerlet::name, coarsest, trial.frames);
  const Trajectory middle = follow(trial.scene, VelocityVerlet::name, 2 * coarsest, trial.frames);
  const Trajectory fine = follow(trial.scene, VelocityVerlet::name, 4 * coarsest, trial.frames);

  Reference reference;
  reference.substeps = 4 * coarsest;
  const std::size_t compared = trial.compared == Compared::rest_shape ? 1 : fine.size();
  reference.order =
      std::log2(rms_distance(coarse, middle, compared) / rms_distance(middle, fine, compared));
  reference.trajectory = fine;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    double change = rms_distance(middle[i].positions, fine[i].positions);
    if (trial.smooth) {
      // (4 x_{h/4} - x_{h/2}) / 3 is of order 4: its error is a fifteenth of its change by halving.
      State& best = reference.trajectory[i];
      best.positions += (fine[i].positions - middle[i].positions) / 3;
      best.velocities += (fine[i].velocities - middle[i].velocities) / 3;
      const Points coarser = (4 * middle[i].positions - coarse[i].positions) / 3;
      change = rms_distance(coarser, best.positions) / 15;
    }
    reference.uncertainty.push_back(change / size_of(trial.scene));
    reference.growth.push_back(1);
  }
  reference.horizon = fine.size();
  return reference;
}

}  // namespace

Reference make_cheap_reference(const Trial& trial) {
  return extrapolate(trial, substeps_of(trial.scene, cheap_refinement));
}

Reference make_reference(const Trial& original) {
  Trial trial = original;
  Material& material = trial.scene.cloth.material;
  material.damping = trial.reference_damping.value_or(material.damping);
  const int wanted = substeps_of(trial.scene, trial.smooth ? refinement : rough_refinement);
  const int coarsest = std::min(wanted, max_substeps / 4);
  Reference reference = extrapolate(trial, coarsest);

  // Another method, and twins of one method.
  const Trajectory other = follow(trial.scene, RungeKutta4::name, coarsest, trial.frames);
  const Trajectory one = follow(trial.scene, VelocityVerlet::name, coarsest, trial.frames);
  const Trajectory twin =
      follow(twin_of(trial.scene), VelocityVerlet::name, coarsest, trial.frames);
  const double size = size_of(trial.scene);
  const bool rest = trial.compared == Compared::rest_shape;
  for (std::size_t i = 0; i < other.size(); ++i) {
    const double to_other =
        rms_distance(reference.trajectory[i].positions, other[i].positions) / size;
    reference.uncertainty[i] = std::max(reference.uncertainty[i], to_other);
    const double apart = rms_distance(one[i].positions, twin[i].positions) / size;
    if (rest) {
      reference.uncertainty[i] = std::max(reference.uncertainty[i], apart);
    } else {
      reference.growth[i] = std::max(1.0, apart / nudge);
    }
  }
  reference.horizon = 0;
  while (reference.horizon < other.size() &&
         reference.own_error(reference.horizon) <= trusted * trial.charted_error) {
    ++reference.horizon;
  }
  const std::size_t compared = rest ? 1 : other.size();
  reference.cross_check = rms_distance(reference.trajectory, other, compared) / size;
  return reference;
}

}  // namespace clothsim::work_precision
