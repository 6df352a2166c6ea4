#pragma once

#include <array>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// A stencil of bending of a grid: its points, with coefficients of sum 0. The two in the middle
/// are the same point where it runs along a line.
struct Bend {
  std::array<int, 4> points;
  double stiffness;  // [N/m]

  static double coefficient(std::size_t k) { return k == 0 || k == 3 ? 1 : -1; }

  /// Sum of coefficient times value [m, or m/s], N x 3.
  Vector3 of(const Points& values) const {
    return (values.row(points[0]) - values.row(points[1]) - values.row(points[2]) +
            values.row(points[3]))
        .transpose();
  }
  // As PatchBend's, for a stencil that is flat at rest.
  Vector3 deviation(const Points& positions) const { return of(positions); }
  Vector3 rate(const Points&, const Points& rates) const { return of(rates); }
};

/// Calls visit(bend) for every stencil, a Bend of a grid, in the order of cloth.bends, or a
/// PatchBend of a mesh. Not for hot loops.
template <typename Visitor>
void for_each_bend(const Cloth& cloth, Visitor&& visit) {
  if (cloth.is_mesh()) {
    for (const PatchBend& bend : cloth.triangle_fabric->bends) visit(bend);
  }
  for (const BendRun& run : cloth.bends) {
    for (int i = run.first; i < run.first + run.count; ++i) {
      visit(Bend{{i, i + run.a, i + run.b, i + run.a + run.b}, run.stiffness});
    }
  }
}

/// Calls visit(w, i, j) for all pairs of points i < j that a fabric's bends join, see PairBand.
template <typename Visitor>
void for_each_bent_pair(const Cloth& cloth, Visitor&& visit) {
  if (cloth.is_mesh()) {
    for (const auto& [i, j, weight] : cloth.triangle_fabric->pairs) visit(weight, i, j);
  }
  if (cloth.bends.empty()) return;
  for (const PairBand& band : cloth.pairs) {
    for (int i = 0; i < static_cast<int>(band.bend.size()); ++i) {
      if (band.bend[i] != 0) visit(band.bend[i], i, i + band.offset);
    }
  }
}

}  // namespace clothsim
