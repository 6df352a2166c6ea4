// Forces of the cloth on held points.

#include <algorithm>
#include <utility>

#include "clothsim/constraints/holders.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {

namespace {

PatchBend as_patch(const PatchBend& bend) { return bend; }
PatchBend as_patch(const Bend& bend) {
  PatchBend patch{{}, {}, bend.stiffness};
  patch.points.fill(bend.points[0]);
  for (std::size_t k = 0; k < bend.points.size(); ++k) {
    patch.points[k] = bend.points[k];
    patch.coefficients[k] = Bend::coefficient(k);
  }
  if (bend.points[1] == bend.points[2]) {
    patch.coefficients[1] += patch.coefficients[2];
    patch.coefficients[2] = 0;
  }
  return patch;
}

}  // namespace

/// Lists what pulls at held points. `held`: by point of the cloth, its number in points_, or -1.
void Holders::list_springs(const Cloth& cloth, const std::vector<int>& held) {
  springs_.clear();
  if (cloth.is_mesh()) return;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    for (const auto& [end, other] : {std::pair(a, b), {b, a}}) {
      const int k = held[static_cast<std::size_t>(end)];
      if (k < 0) continue;
      springs_.push_back({static_cast<std::size_t>(k), other, run.stiffness, run.rest_length});
    }
  });
}

void Holders::list_corners(const Cloth& cloth, const std::vector<int>& held) {
  corners_.clear();
  if (!cloth.is_mesh()) return;
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int k = held[static_cast<std::size_t>(cloth.triangles[t][c])];
      if (k >= 0) corners_.push_back({static_cast<std::size_t>(k), t, c});
    }
  }
}

void Holders::list_bends(const Cloth& cloth, const std::vector<int>& held) {
  bends_.clear();
  for_each_bend(cloth, [&](const auto& bend) {
    const auto is_held = [&](int point) { return held[static_cast<std::size_t>(point)] >= 0; };
    if (std::none_of(bend.points.begin(), bend.points.end(), is_held)) return;
    const PatchBend patch = as_patch(bend);
    for (std::size_t c = 0; c < patch.points.size(); ++c) {
      const int k = held[static_cast<std::size_t>(patch.points[c])];
      if (k < 0 || patch.coefficients[c] == 0) continue;
      bends_.push_back({static_cast<std::size_t>(k), patch.coefficients[c], patch});
    }
  });
}

void Holders::add_spring_impulses(const Cloth& cloth, double h, const State& state,
                                  Points& impulses) const {
  const auto& [of_springs, of_bends] = cloth.internal_damping;
  for (const Spring& s : springs_) {
    const Point& p = points_[s.point];
    if (p.slips) continue;
    const int i = p.hold.point;
    const Vector3 d = row(state.positions, s.other) - row(state.positions, i);
    const Vector3 rate = row(state.velocities, s.other) - row(state.velocities, i);
    const double length = d.norm();
    if (length == 0) continue;  // has no direction
    const Vector3 u = d / length;
    const double tension = s.stiffness * (length - s.rest_length + of_springs * u.dot(rate));
    impulses.row(i) += h * tension * u.transpose();
  }
  for (const HeldBend& held : bends_) {
    const Point& p = points_[held.point];
    if (p.slips) continue;
    const Vector3 b = held.bend.of(state.positions);
    const double share = damping_share(of_bends, b, held.bend.of(state.velocities));
    impulses.row(p.hold.point) -=
        h * held.coefficient * held.bend.stiffness * (1 + share) * b.transpose();
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
}

}  // namespace clothsim
