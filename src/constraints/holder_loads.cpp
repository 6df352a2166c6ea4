// Forces of the cloth on held points.

#include "clothsim/constraints/holders.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {

/// The triangles and the bends of a mesh at held points.
void Holders::list_corners(const Cloth& cloth) {
  std::vector<int> number(static_cast<std::size_t>(cloth.num_points()), -1);  // in points_
  for (std::size_t k = 0; k < points_.size(); ++k) {
    number[static_cast<std::size_t>(points_[k].hold.point)] = static_cast<int>(k);
  }
  const auto held = [&](int point) { return number[static_cast<std::size_t>(point)]; };
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int k = held(cloth.triangles[t][c]);
      if (k >= 0) corners_.push_back({static_cast<std::size_t>(k), t, c});
    }
  }
  for_each_bent_pair(cloth, [&](double weight, int i, int j) {
    if (held(i) >= 0) springs_.push_back({static_cast<std::size_t>(held(i)), j, 0, 0, weight});
    if (held(j) >= 0) springs_.push_back({static_cast<std::size_t>(held(j)), i, 0, 0, weight});
  });
}

/// The cells of a fabric at held points.
void Holders::list_cells(const Cloth& cloth) {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const int i = points_[k].hold.point;
    for (const CellRun& run : cloth.cells) {
      const std::array<int, 4> steps{0, run.a, run.b, run.a + run.b};
      for (std::size_t corner = 0; corner < steps.size(); ++corner) {
        const int first = i - steps[corner];
        if (first < run.first || first >= run.first + run.count) continue;
        cells_.push_back({k, cell_of(run, first), corner});
      }
    }
  }
}

void Holders::list_springs(const Cloth& cloth) {
  springs_.clear();
  corners_.clear();
  cells_.clear();
  if (cloth.is_mesh()) return list_corners(cloth);
  list_cells(cloth);
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const int i = points_[k].hold.point;
    for (const PairBand& band : cloth.pairs) {
      for (const int first : {i, i - band.offset}) {
        if (first < 0 || first >= static_cast<int>(band.bend.size())) continue;
        const double spring = band.spring.size() == 0 ? 0 : band.spring[first];
        if (spring == 0 && band.bend[first] == 0) continue;
        const int other = first == i ? i + band.offset : first;
        springs_.push_back({k, other, spring, band.rest_length, band.bend[first]});
      }
    }
    if (cloth.has_bands()) continue;
    for (const SpringRun& run : cloth.springs) {
      for (const int first : {i, i - run.offset}) {  // the springs that it begins and ends
        if (first < run.first || first >= run.first + run.count) continue;
        const int other = first == i ? i + run.offset : first;
        springs_.push_back({k, other, run.stiffness, run.rest_length, 0});
      }
    }
  }
}

void Holders::add_spring_impulses(const Cloth& cloth, double h, const State& state,
                                  Points& impulses) const {
  for (const Spring& s : springs_) {
    const Point& p = points_[s.point];
    if (p.slips) continue;
    const int i = p.hold.point;
    const auto& [of_springs, of_bends] = cloth.internal_damping_at(i);
    const Vector3 d = row(state.positions, s.other) - row(state.positions, i);
    const Vector3 rate = row(state.velocities, s.other) - row(state.velocities, i);
    // Not relative to a rotation (see remove_rotation()), which adds some 1e-5 of a load.
    Vector3 force = s.bend * (d + of_bends * rate);
    const double length = d.norm();
    if (length > 0) {
      const Vector3 u = d / length;
      force += s.stiffness * (length - s.rest_length + of_springs * u.dot(rate)) * u;
    }
    impulses.row(i) += h * force.transpose();
  }
  for (const HeldCell& held : cells_) {
    if (points_[held.point].slips) continue;
    const Cell& cell = held.cell;
    const Vector3 by =
        Cell::sign(held.corner) * cell.gradients(state.positions)[Cell::diagonal_of(held.corner)];
    impulses.row(cell.corners[held.corner]) -=
        h * cell.stress(state, cloth.internal_damping[0]) * by.transpose();
  }
  const Points* const velocities = is_damped(cloth) ? &state.velocities : nullptr;
  for (const HeldCorner& held : corners_) {
    if (points_[held.point].slips) continue;
    const std::array<int, 3>& corners = cloth.triangles[held.triangle];
    const Vector3 pulls = triangle_pulls(cloth, held.triangle, state.positions, velocities);
    const std::size_t next = (held.corner + 1) % 3, last = (held.corner + 2) % 3;
    const int i = corners[held.corner];
    const auto pull = [&](std::size_t edge, std::size_t other) {
      const double strength = 2 * pulls[static_cast<Eigen::Index>(edge)];
      impulses.row(i) +=
          h * strength * (state.positions.row(corners[other]) - state.positions.row(i));
    };
    pull(held.corner, next);
    pull(last, last);
  }
  if (!cloth.is_mesh()) return;
  for (const Point& p : points_) {
    const int i = p.hold.point;
    if (p.slips) continue;
    const Vector3 force = curved_force_on(*cloth.triangle_fabric, i, state.positions, velocities);
    impulses.row(i) += h * force.transpose();
  }
}

}  // namespace clothsim
