#include "clothsim/dynamics/verlet.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/model/point_run.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Half a step of drift: x = from + v (1 - exp(-c t)) / c for free points, v t for pins.
CLOTHSIM_TARGET_CLONES
void drift(int count, double t, double distance, const double* inv_mass, PointRun v, PointRun from,
           MutablePointRun to) {
#pragma GCC ivdep  // `to` may be `from`, nothing else overlaps
  for (int i = 0; i < count; ++i) {
    const double duration = inv_mass[i] > 0 ? distance : t;
    to.x[i] = from.x[i] + duration * v.x[i];
    to.y[i] = from.y[i] + duration * v.y[i];
    to.z[i] = from.z[i] + duration * v.z[i];
  }
}

/// Factors of a step of h [s] for velocities and positions, and the drag of half of it.
struct Kick {
  Kick(double damping, double step)
      : h(step),
        half(damping, h / 2),
        velocity(Drag(damping, h).distance),
        position(Drag(damping, h).fall) {}

  double h;
  Drag half;
  double velocity;  // per constant acceleration [s]
  double position;  // per constant acceleration [s^2]
};

/// The change of velocities by the first drift, v *= exp(-c h / 2), the kick and the second drift.
template <typename Real>
[[gnu::always_inline]] inline void kick_and_drift_by(int count, const Kick& kick,
                                                     const double* inv_mass, const Real* f,
                                                     const double* middle, double* x, double* v) {
  const auto [h, half, velocity, position] = kick;
#pragma GCC ivdep  // x may be `middle`, nothing else overlaps
  for (int i = 0; i < count; ++i) {
    const bool free = inv_mass[i] > 0;
    const double loss = free ? half.decay : 1.0;
    const double slowed = loss * v[i];
    const double a = inv_mass[i] * f[i];
    x[i] = middle[i] + (free ? half.distance : h / 2) * slowed + position * a;
    v[i] = loss * slowed + velocity * a;
  }
}

CLOTHSIM_TARGET_CLONES
void kick_and_drift(int count, const Kick& kick, const double* inv_mass, const double* f,
                    const double* middle, double* x, double* v) {
  kick_and_drift_by(count, kick, inv_mass, f, middle, x, v);
}
CLOTHSIM_TARGET_CLONES
void kick_and_drift(int count, const Kick& kick, const double* inv_mass, const float* f,
                    const double* middle, double* x, double* v) {
  kick_and_drift_by(count, kick, inv_mass, f, middle, x, v);
}

}  // namespace

double VelocityVerlet::displacement_factor(double damping, double h) {
  // Displacement over velocity by a constant force in one step.
  const Drag drag(damping, h);
  return drag.fall / (drag.distance * h);
}

void VelocityVerlet::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                          const Workers& workers) {
  if (cloth.is_mesh()) {
    step_mesh(cloth, loads, h, state, workers);
  } else if (parameters_.precision == Parameters::single_precision) {
    step_by(single_forces_, cloth, loads, h, state, workers);
  } else {
    step_by(forces_, cloth, loads, h, state, workers);
  }
}

void VelocityVerlet::step_mesh(const Cloth& cloth, const Loads& loads, double h, State& state,
                               const Workers& workers) {
  const int n = cloth.num_points();
  mesh_forces_.resize(n, 3);
  const auto in_bands = [&](const auto& visit) {
    workers.parallel_for(n,
                         [&](int begin, int end) { for_each_damping(cloth, begin, end, visit); });
  };
  in_bands([&](int begin, int end, double damping) {
    drift(end - begin, h / 2, Drag(damping, h / 2).distance, &cloth.inv_mass[begin],
          run_from(state.velocities, begin), run_from(state.positions, begin),
          run_from(state.positions, begin));
  });
  compute_triangle_forces(cloth, loads, state.positions, mesh_forces_, workers, &state.velocities);
  const double factor = displacement_factor(cloth.damping, h);
  in_bands([&](int begin, int end, double damping) {
    Kick kick(damping, h);
    // Constraints have one factor for all cloths.
    if (!loads.acts_alone) kick.position *= factor / displacement_factor(damping, h);
    for (int axis = 0; axis < 3; ++axis) {
      double* const x = &state.positions(begin, axis);
      kick_and_drift(end - begin, kick, &cloth.inv_mass[begin], &mesh_forces_(begin, axis), x, x,
                     &state.velocities(begin, axis));
    }
  });
}

/// Velocities for internal damping, of the next band too; null without damping.
const Points* VelocityVerlet::damped_velocities(const Cloth& cloth, const Points& middle,
                                                const Points& velocities, const Workers& workers) {
  if (!is_damped(cloth)) return nullptr;
  if (has_damped_bends(cloth)) {
    remove_rotation(cloth, middle, velocities, velocities_, workers);
  } else if (workers.threads() > 1) {
    velocities_ = velocities;
  } else {
    return &velocities;
  }
  return &velocities_;
}

template <typename Forces>
void VelocityVerlet::step_by(Forces& forces, const Cloth& cloth, const Loads& loads, double h,
                             State& state, const Workers& workers) {
  using Real = typename Forces::Scalar;
  const Kick kick(cloth.damping, h);
  const int n = cloth.num_points();
  // Positions in the middle of the step. A band must keep those that the next one needs: with a
  // single band, points move in place, which saves a third of the memory traffic.
  Points& middle = workers.threads() == 1 ? state.positions : middle_;
  if (middle.rows() != n) middle.resize(n, 3);  // another thread may read the size
  forces.resize(n);

  workers.parallel_for(n, [&](int begin, int end) {
    drift(end - begin, h / 2, kick.half.distance, &cloth.inv_mass[begin],
          run_from(state.velocities, begin), run_from(state.positions, begin),
          run_from(middle, begin));
  });
  const Points* const velocities = damped_velocities(cloth, middle, state.velocities, workers);
  workers.parallel_for(n, [&](int begin, int end) {
    for (ForceBlocks<Real> blocks(cloth, loads, middle, begin, end, velocities); blocks.next();) {
      const int i = blocks.first();
      for (int axis = 0; axis < 3; ++axis) {
        Real* f = &forces[i];  // of this axis
        blocks.sum(axis, f);
        kick_and_drift(blocks.count(), kick, &cloth.inv_mass[i], f, &middle(i, axis),
                       &state.positions(i, axis), &state.velocities(i, axis));
      }
    }
  });
}

}  // namespace clothsim
