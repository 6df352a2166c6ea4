#pragma once

#include <array>
#include <cassert>
#include <cstddef>

#include "clothsim/model/types.h"

namespace clothsim {

/// Distances of some hundred points to triangles at once, several times as fast as separation() for
/// each: without branches, vectorised, and few enough to stay in the nearest caches.
class Distances {
 public:
  static constexpr std::size_t capacity = 256;

  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  std::size_t room() const { return capacity - size_; }

  /// A pair, by the points of SurfacePair. Needs room.
  void add(const std::array<int, 4>& points) {
    assert(room() > 0);
    for (std::size_t k = 0; k < 4; ++k) points_[k][size_] = points[k];
    ++size_;
  }

  /// Measures all pairs at `positions` [m, N x 3].
  void measure(const Points& positions);

  /// Distance of pair `k` [m]. Never more than it is, and less by a part in 1e10 of that or 1e-7 of
  /// the lengths between its points at most, where these are far longer, times the triangle's
  /// length over its height, and a thousandth at most.
  double operator[](std::size_t k) const { return values_[k]; }

  /// Is the point closest to an edge or a corner of its triangle?
  bool at_edge(std::size_t k) const { return inside_[k] == 0; }

 private:
  std::size_t size_ = 0;
  std::array<std::array<int, capacity>, 4> points_;
  std::array<double, capacity> values_;
  std::array<double, capacity> inside_;  // the triangle; 0: at an edge
};

}  // namespace clothsim
