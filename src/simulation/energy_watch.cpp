#include "clothsim/simulation/energy_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Kinetic energy may grow by this factor in a frame, or by that of twice a frame's fall from rest,
/// before all energies are compared: more cannot be a blow-up unseen.
constexpr double usual_growth = 1.5;

/// Energy that may come from nowhere in a frame: this share of kinetic and elastic energy, a lift
/// of the cloth by this share of its size, and this speed of it [m/s], as roundings give to a cloth
/// without weight. The shipped scenes stay under 0.004 of the first.
constexpr double margin = 1;
constexpr double lift = 0.02;
constexpr double tremble = 1e-3;

/// The same over any number of frames, of all that the cloth can have had: explicit steps just
/// below their limit show their fastest waves with some tens of the energy that they have.
constexpr double margin_in_all = 100;

/// Fastest speed of pins and of collider surfaces near the cloth [m/s].
double fastest_boundary(const Cloth& cloth, const State& before, const State& after,
                        const std::vector<MovingCollider>& colliders) {
  double fastest = 0;
  for (Eigen::Index i = 0; i < cloth.inv_mass.size(); ++i) {
    if (cloth.inv_mass[i] == 0) fastest = std::max(fastest, after.velocities.row(i).norm());
  }
  if (colliders.empty()) return fastest;
  Eigen::AlignedBox3d box;
  for (const Points* points : {&before.positions, &after.positions}) {
    box.extend(points->colwise().minCoeff().transpose());
    box.extend(points->colwise().maxCoeff().transpose());
  }
  for (const MovingCollider& collider : colliders) {
    if (collider.enabled()) fastest = std::max(fastest, collider.fastest_in(box));
  }
  return fastest;
}

/// Work of pins that move for dt against their bends [J], likewise.
double work_on_bends(const Cloth& cloth, double dt, const State& before, const State& after) {
  double work = 0;
  for_each_bend(cloth, [&](const Bend& bend) {
    double way = 0;  // of the stencil
    for (std::size_t k = 0; k < bend.points.size(); ++k) {
      const int i = bend.points[k];
      if (cloth.inv_mass[i] == 0) way += dt * after.velocities.row(i).norm();
    }
    if (way == 0) return;
    work += bend.stiffness * (bend.of(before.positions).norm() * way + way * way / 2);
  });
  return work;
}

/// Work of pins that move for dt against their springs [J]: F s + k s^2 / 2 with the force at
/// first.
double work_on_springs(const Cloth& cloth, double dt, const State& before, const State& after) {
  double work = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    for (const int pin : {a, b}) {
      if (cloth.inv_mass[pin] > 0) continue;
      const double way = dt * after.velocities.row(pin).norm();
      if (way == 0) continue;
      const double length = (before.positions.row(b) - before.positions.row(a)).norm();
      work += run.stiffness * (std::abs(length - run.rest_length) * way + way * way / 2);
    }
  });
  return work + work_on_bends(cloth, dt, before, after);
}

}  // namespace

void EnergyWatch::write(MemoryWriter& memory) const {
  memory.add(begun_);
  memory.add(begun_ ? given_ : 0);
  memory.add(begun_ ? potential_ : 0);
}

void EnergyWatch::read(MemoryReader& memory) {
  begun_ = memory.index(2) == 1;
  given_ = memory.energy();
  potential_ = memory.energy();
}

bool EnergyWatch::accepts(const Cloth& cloth, const Vector3& gravity, double dt,
                          const State& before, const State& after,
                          const std::vector<MovingCollider>& colliders, double push_out,
                          double wind) {
  const double mass = (cloth.inv_mass.array() > 0).select(cloth.mass.array(), 0).sum();
  const double g = gravity.norm();
  const Eigen::RowVector3d extent =
      cloth.rest_positions.colwise().maxCoeff() - cloth.rest_positions.colwise().minCoeff();
  const double unseen = mass * (g * lift * extent.maxCoeff() + tremble * tremble / 2);
  if (!begun_) {
    given_ = kinetic_energy(cloth, before) + elastic_energy(cloth, before.positions) + unseen;
    potential_ = gravitational_energy(cloth, gravity, before.positions);
    begun_ = true;
  }

  // A point that a moving surface hits leaves with twice its speed at most; work against weight.
  const double speed = std::max(fastest_boundary(cloth, before, after, colliders), wind) + push_out;
  const double work = mass * (2 * speed * speed + g * speed * dt);
  given_ += work;
  const double kinetic_before = kinetic_energy(cloth, before);
  const double kinetic_after = kinetic_energy(cloth, after);
  const double fallen = potential_ - gravitational_energy(cloth, gravity, after.positions);
  if (!(kinetic_after <= margin_in_all * (given_ + std::max(fallen, 0.0)))) return false;

  if (push_out > 0) return true;

  const double fall = 2 * g * dt;
  if (kinetic_after <= usual_growth * kinetic_before + mass * fall * fall / 2) return true;
  const double on_springs = speed > 0 ? work_on_springs(cloth, dt, before, after) : 0;
  const double elastic_before = elastic_energy(cloth, before.positions);
  const double gain = kinetic_after - kinetic_before + elastic_energy(cloth, after.positions) -
                      elastic_before + gravitational_energy(cloth, gravity, after.positions) -
                      gravitational_energy(cloth, gravity, before.positions);
  return gain <= work + on_springs + margin * (kinetic_before + elastic_before) + unseen;
}

}  // namespace clothsim
