#include "score.h"

#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/grid.h"

namespace clothsim::work_precision {
namespace {

double total_energy(const Cloth& cloth, const Vector3& gravity, const State& state) {
  return kinetic_energy(cloth, state) + elastic_energy(cloth, state.positions) +
         gravitational_energy(cloth, gravity, state.positions);
}

Vector3 mean_by_mass(const Cloth& cloth, const Points& values) {
  return values.transpose() * cloth.mass / cloth.mass.sum();
}

double square(double x) { return x * x; }

void add_stretch(const Cloth& cloth, const Points& x, Score& score) {
  std::vector<double> stretch;
  for_each_spring(cloth, [&](const SpringRun& spring, int a, int b) {
    stretch.push_back((x.row(b) - x.row(a)).norm() / spring.rest_length - 1);
  });
  if (stretch.empty()) return;
  const auto p99 = stretch.begin() + static_cast<std::ptrdiff_t>(0.99 * double(stretch.size()));
  std::nth_element(stretch.begin(), p99, stretch.end());
  score.p99_stretch = std::fmax(score.p99_stretch, *p99);
  score.worst_stretch = std::fmax(score.worst_stretch, *std::max_element(p99, stretch.end()));
}

}  // namespace

Score score(const Run& run, const Reference& reference, const Trial& trial) {
  const Cloth cloth = make_grid(trial.scene.cloth);
  const Vector3& gravity = trial.scene.simulation.gravity;
  const double size = size_of(trial.scene);
  const double speed = std::sqrt(gravity.norm() * size);
  const double mass = cloth.mass.sum();

  Score score;
  double squares = 0;
  double velocity_squares = 0;
  double own_error = 0;
  int compared = 0;
  const std::size_t frames = run.trajectory.size();
  const bool rest = trial.compared == Compared::rest_shape;
  if (rest && run.outcome != Outcome::done) return score;
  for (std::size_t i = rest ? frames - 1 : 0; i < frames; ++i) {
    const State& state = run.trajectory[i];
    const State& truth = reference.trajectory[i];

    // Point by point, up to the horizon.
    if (rest || i < reference.horizon) {
      ++compared;
      squares += square(rms_distance(state.positions, truth.positions) / size);
      velocity_squares += square(rms_distance(state.velocities, truth.velocities) / speed);
      const double farthest =
          (state.positions - truth.positions).rowwise().norm().maxCoeff() / size;
      score.position_max = std::fmax(score.position_max, farthest);
      score.horizon = truth.time;
      own_error = std::max(own_error, reference.own_error(i));
    }

    // The whole cloth, in every frame.
    const double energy = total_energy(cloth, gravity, state) - total_energy(cloth, gravity, truth);
    score.energy = std::fmax(score.energy, std::abs(energy) / (mass * gravity.norm() * size));
    const Vector3 slip = mean_by_mass(cloth, state.velocities - truth.velocities);
    score.momentum = std::fmax(score.momentum, slip.norm() / speed);
    const Vector3 shift = mean_by_mass(cloth, state.positions - truth.positions);
    score.centre = std::fmax(score.centre, shift.norm() / size);
    add_stretch(cloth, state.positions, score);
  }
  if (compared == 0) return score;
  score.position = std::sqrt(squares / compared);
  score.velocity = std::sqrt(velocity_squares / compared);
  if (own_error > trusted * score.position) {
    score.position = score.position_max = score.velocity = Score::none;
  }
  return score;
}

}  // namespace clothsim::work_precision
