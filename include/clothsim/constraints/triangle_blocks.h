#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// The triangles of a cloth in blocks of neighbours: where the box around a block's points touches
/// nothing, none of its triangles does.
class TriangleBlocks {
 public:
  /// Triangles of a block: as many as the widest vector unit takes.
  static constexpr int size = num_lanes;

  void reset(const Cloth&);

  bool fits(const Cloth& cloth) const { return triangles_ == cloth.triangles.size(); }

  int count() const { return static_cast<int>(ends_.size()); }
  std::size_t first_of(int b) const { return static_cast<std::size_t>(b) * size; }
  std::size_t end_of(int b) const { return std::min(first_of(b + 1), triangles_); }

  /// Around all points of a block.
  Eigen::AlignedBox3d box(int b, const Points& positions) const;

  /// Least of the values of its points.
  double min(int b, const Scalars& values) const;

 private:
  const int* begin(int b) const { return b > 0 ? end(b - 1) : points_.data(); }
  const int* end(int b) const { return points_.data() + ends_[static_cast<std::size_t>(b)]; }

  std::size_t triangles_ = 0;
  std::vector<int> points_;  // by block, ascending
  std::vector<int> ends_;    // in points_, by block
};

}  // namespace clothsim
