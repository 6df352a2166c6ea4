#include "clothsim/simulation/energy_watch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/model/smooth_normal.h"
#include "clothsim/model/surface.h"

namespace clothsim {
namespace {

/// Factor by which kinetic energy may grow in a frame, in addition to that of a fall from rest over
/// two frames, before all energies are compared: an unstable method exceeds it.
constexpr double usual_growth = 1.5;

/// Energy of unknown source that a frame may gain, in addition to the kinetic and elastic energy at
/// its start: a lift of the cloth by this share of its size, plus the kinetic energy at rest_speed,
/// which rounding gives to a cloth without weight. The shipped scenes gain less than 0.004 of the
/// kinetic and elastic energy.
constexpr double lift = 0.02;

/// Bound on the kinetic energy after any number of frames, as a multiple of all energy that the
/// cloth can have received: explicit steps just below their stability limit show the fastest waves
/// with some tens of times the true energy.
constexpr double margin_in_all = 100;

Eigen::AlignedBox3d box_of(const State& before, const State& after) {
  Eigen::AlignedBox3d box;
  for (const Points* points : {&before.positions, &after.positions}) {
    box.extend(points->colwise().minCoeff().transpose());
    box.extend(points->colwise().maxCoeff().transpose());
  }
  return box;
}

/// Displacements of driven points in a frame [m], N x 3 each; empty: none.
struct Drive {
  double max_speed = 0;  // of pins and of the surfaces of colliders near the cloth [m/s]
  Points pinned;
  Points pushed;  // by colliders, possibly
};

void take(int i, const Vector3& displacement, int count, Points& displacements) {
  if (displacements.size() == 0) displacements.setZero(count, 3);
  if (displacement.squaredNorm() > displacements.row(i).squaredNorm())
    displacements.row(i) = displacement.transpose();
}

bool moves(const MovingCollider& collider) {
  const bool is_at_rest = collider.velocity().isZero(0) && collider.angular_velocity().isZero(0);
  return collider.enabled() && !is_at_rest;
}

Drive drive_of(const Cloth& cloth, double dt, const State& before, const State& after,
               const std::vector<MovingCollider>& colliders) {
  Drive drive;
  const int count = cloth.num_points();
  for (int i = 0; i < count; ++i) {
    if (cloth.inv_mass[i] > 0) continue;
    const Vector3 velocity = row(after.velocities, i);
    drive.max_speed = std::max(drive.max_speed, velocity.norm());
    if (!velocity.isZero()) take(i, dt * velocity, count, drive.pinned);  // except for rounding
  }
  // Bounds of all points take time, which colliders at rest do not need.
  if (std::none_of(colliders.begin(), colliders.end(), moves)) return drive;
  // The corners of a triangle in contact are at most as far away as its edges are long.
  const double edge =
      std::max(longest_rest_length(cloth), longest_edge(after.positions, cloth.triangles));
  const Eigen::AlignedBox3d box = box_of(before, after);
  for (const MovingCollider& collider : colliders) {
    const double speed = moves(collider) ? collider.max_speed_in(box) : 0;
    drive.max_speed = std::max(drive.max_speed, speed);
    if (speed == 0 || !collider.reaches(box, 2 * edge)) continue;
    for (int i = 0; i < count; ++i) {
      const Vector3 at = row(after.positions, i);
      if (cloth.inv_mass[i] == 0 || !collider.reaches({at, at}, 2 * edge)) continue;
      take(i, dt * collider.velocity_at(at), count, drive.pushed);
    }
  }
  return drive;
}

/// How far the curvature at rest of a bend turns when points are driven by these lengths [1/m].
double turn_of(const Bend&, const State&, const Scalars&) { return 0; }
double turn_of(const PatchBend& bend, const State& before, const Scalars& lengths) {
  if (bend.curvature == 0) return 0;
  const SmoothNormal normal(bend, before.positions);
  double turn = 0;
  for (std::size_t k = 0; k < 3; ++k) turn += normal.slope(k) * lengths[bend.points[k]];
  return std::abs(bend.curvature) * std::min(turn, 2.0);
}

/// Work [J] against bends when points are driven by these lengths [m], as in work_on_springs().
double work_on_bends(const Cloth& cloth, const State& before, const Scalars& lengths) {
  double work = 0;
  for_each_bend(cloth, [&](const auto& bend) {
    double change = turn_of(bend, before, lengths);  // of the stencil
    for (std::size_t k = 0; k < bend.points.size(); ++k) {
      change += std::abs(bend.coefficient(k)) * lengths[bend.points[k]];
    }
    if (change == 0) return;
    work +=
        bend.stiffness * (bend.deviation(before.positions).norm() * change + change * change / 2);
  });
  return work;
}

/// The same against cells.
double work_on_cells(const Cloth& cloth, const State& before, const Scalars& lengths) {
  double work = 0;
  for_each_cell(cloth, [&](const Cell& cell) {
    const double one = lengths[cell.corners[0]] + lengths[cell.corners[3]];
    const double two = lengths[cell.corners[1]] + lengths[cell.corners[2]];
    if (one == 0 && two == 0) return;
    const auto& [p, q, r, rest] = cell.strain;
    const Cell::Diagonals by = cell.gradients(before.positions);
    const double change = (by[0].norm() + std::abs(p) * one) * one +
                          (by[1].norm() + std::abs(q) * two) * two + std::abs(r) * one * two;
    work += cell.stiffness * (std::abs(cell.value(before.positions)) + change / 2) * change;
  });
  return work;
}

/// The same against the membrane of a mesh: pulls |s| on squared edges q, which change by at most
/// 2 l s + s^2 =: d, and d |K| d / 2.
double work_on_membrane(const Cloth& cloth, const State& before, const Points& displacements) {
  double work = 0;
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const std::array<int, 3>& corners = cloth.triangles[t];
    const Vector3 q = squared_edges(corners, before.positions);
    Vector3 change;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = displacements.row(corners[k]), b = displacements.row(corners[(k + 1) % 3]);
      const double longer = std::max({a.norm(), b.norm(), (b - a).norm()});
      const auto i = static_cast<Eigen::Index>(k);
      change[i] = (2 * std::sqrt(q[i]) + longer) * longer;
    }
    if (change.isZero(0)) continue;
    const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
    const Vector3 pulls = triangle.stretch * (q - triangle.rest2);
    work += pulls.cwiseAbs().dot(change) + change.dot(triangle.stretch.cwiseAbs() * change) / 2;
  }
  return work;
}

/// Work [J] against springs when points are driven: F s + k s^2 / 2, with F the initial force and s
/// the longer, for springs with one or both ends driven.
double work_on_springs(const Cloth& cloth, const State& before, const Points& displacements) {
  if (displacements.size() == 0) return 0;
  const Scalars lengths = displacements.rowwise().norm();
  if (cloth.is_mesh()) {
    return work_on_membrane(cloth, before, displacements) + work_on_bends(cloth, before, lengths);
  }
  double work = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    if (lengths[a] == 0 && lengths[b] == 0) return;  // nearly all where a pin is moved
    const double longer =
        std::max({lengths[a], lengths[b], (displacements.row(b) - displacements.row(a)).norm()});
    const double length = (before.positions.row(b) - before.positions.row(a)).norm();
    work += run.stiffness * (std::abs(length - run.rest_length) * longer + longer * longer / 2);
  });
  return work + work_on_cells(cloth, before, lengths) + work_on_bends(cloth, before, lengths);
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
                          const std::vector<MovingCollider>& colliders, double push_out_speed,
                          double wind, double external_work) {
  const double mass = (cloth.inv_mass.array() > 0).select(cloth.mass.array(), 0).sum();
  const double g = gravity.norm();
  const auto unseen = [&] {  // needed in few frames
    const Eigen::RowVector3d extent =
        cloth.rest_positions.colwise().maxCoeff() - cloth.rest_positions.colwise().minCoeff();
    return mass * (g * lift * extent.maxCoeff() + rest_speed * rest_speed / 2);
  };
  if (!begun_) {
    given_ = kinetic_energy(cloth, before) + elastic_energy(cloth, before.positions) + unseen();
    potential_ = gravitational_energy(cloth, gravity, before.positions);
    begun_ = true;
  }

  // A point that a moving surface hits leaves with at most twice the speed of the surface. Work
  // against the weight adds to that.
  const Drive drive = drive_of(cloth, dt, before, after, colliders);
  const double speed = std::max(drive.max_speed, wind) + push_out_speed;
  const double work = mass * (2 * speed * speed + g * speed * dt) + external_work;
  const double by_pins = work_on_springs(cloth, before, drive.pinned);
  const double by_colliders = work_on_springs(cloth, before, drive.pushed);
  given_ += work + by_pins + by_colliders;
  const double kinetic_before = kinetic_energy(cloth, before);
  const double kinetic_after = kinetic_energy(cloth, after);
  const double fallen = potential_ - gravitational_energy(cloth, gravity, after.positions);
  if (!(kinetic_after <= margin_in_all * (given_ + std::max(fallen, 0.0)))) return false;

  if (push_out_speed > 0) {
    restart();  // recovery has stretched the cloth
    return true;
  }

  const double fall = 2 * g * dt;
  if (kinetic_after <= usual_growth * kinetic_before + mass * fall * fall / 2) return true;
  const double elastic_before = elastic_energy(cloth, before.positions);
  const double gain = kinetic_after - kinetic_before + elastic_energy(cloth, after.positions) -
                      elastic_before + gravitational_energy(cloth, gravity, after.positions) -
                      gravitational_energy(cloth, gravity, before.positions);
  const double small = kinetic_before + elastic_before;
  return gain <= work + by_pins + std::max(by_colliders, small) + unseen();
}

}  // namespace clothsim
