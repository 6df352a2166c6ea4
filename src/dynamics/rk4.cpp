#include "clothsim/dynamics/rk4.h"

#include "clothsim/dynamics/drag.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// to = from + t rate.
CLOTHSIM_TARGET_CLONES
void advance(int count, double t, const double* from, const double* rate, double* to) {
  for (int i = 0; i < count; ++i) to[i] = from[i] + t * rate[i];
}

/// to = decay from + t f / m; pins keep their velocity.
CLOTHSIM_TARGET_CLONES
void kick(int count, double decay, double t, const double* inv_mass, const double* from,
          const double* f, double* to) {
  for (int i = 0; i < count; ++i) {
    to[i] = (inv_mass[i] > 0 ? decay : 1.0) * from[i] + t * inv_mass[i] * f[i];
  }
}

/// Points [begin, end) of one cloth: the updates between two forces, each of its points alone.
struct Band {
  const Cloth& cloth;
  int begin;
  int end;
  double half;   // decay by drag in half a step
  double whole;  // and in a whole one

  void advance(double t, const Points& from, const Points& rate, Points& to) const {
    for (int axis = 0; axis < 3; ++axis) {
      clothsim::advance(end - begin, t, &from(begin, axis), &rate(begin, axis), &to(begin, axis));
    }
  }

  void kick(double decay, double t, const Points& from, const Points& forces, Points& to) const {
    for (int axis = 0; axis < 3; ++axis) {
      clothsim::kick(end - begin, decay, t, &cloth.inv_mass[begin], &from(begin, axis),
                     &forces(begin, axis), &to(begin, axis));
    }
  }
};

}  // namespace

double RungeKutta4::displacement_factor(double damping, double h) {
  // Displacement over velocity by a constant force in one step.
  const double half = Drag(damping, h / 2).decay;
  return (1 + 2 * half) / (1 + 4 * half + half * half);
}

void RungeKutta4::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                       const Workers& workers) {
  for (Points* points : {&forces_, &x_, &v_, &end_positions_, &end_velocities_}) {
    points->resize(cloth.num_points(), 3);
  }
  const Points& x0 = state.positions;
  const Points& v0 = state.velocities;
  // The forces at x, then the updates that follow from them, point by point.
  const auto stage = [&](const Points& x, const Points& v, const auto& update) {
    compute_forces(cloth, loads, x, forces_, workers, &v);
    workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
      for_each_damping(cloth, begin, end, [&](int first, int next, double damping) {
        update(Band{cloth, first, next, Drag(damping, h / 2).decay, Drag(damping, h).decay});
      });
    });
  };

  // Slopes at the start.
  stage(x0, v0, [&](const Band& band) {
    band.advance(h / 6, x0, v0, end_positions_);
    band.kick(band.whole, h / 6 * band.whole, v0, forces_, end_velocities_);
    band.advance(h / 2, x0, v0, x_);
    band.kick(band.half, h / 2 * band.half, v0, forces_, v_);
  });

  // Slopes in the middle, with the first ones.
  stage(x_, v_, [&](const Band& band) {
    band.advance(h / 3, end_positions_, v_, end_positions_);
    band.kick(1, h / 3 * band.half, end_velocities_, forces_, end_velocities_);
    band.advance(h / 2, x0, v_, x_);
    band.kick(band.half, h / 2, v0, forces_, v_);
  });

  // Slopes in the middle, with the second ones.
  stage(x_, v_, [&](const Band& band) {
    band.advance(h / 3, end_positions_, v_, end_positions_);
    band.kick(1, h / 3 * band.half, end_velocities_, forces_, end_velocities_);
    band.advance(h, x0, v_, x_);
    band.kick(band.whole, h * band.half, v0, forces_, v_);
  });

  // Slopes at the end.
  stage(x_, v_, [&](const Band& band) {
    band.advance(h / 6, end_positions_, v_, state.positions);
    band.kick(1, h / 6, end_velocities_, forces_, state.velocities);
  });
}

}  // namespace clothsim
