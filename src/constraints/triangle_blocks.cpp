#include "clothsim/constraints/triangle_blocks.h"

#include <algorithm>

namespace clothsim {

void TriangleBlocks::reset(const Cloth& cloth) {
  triangles_ = cloth.triangles.size();
  points_.clear();
  ends_.clear();
  std::vector<int> here;
  for (std::size_t first = 0; first < triangles_; first += size) {
    here.clear();
    for (std::size_t t = first; t < std::min(first + size, triangles_); ++t) {
      here.insert(here.end(), cloth.triangles[t].begin(), cloth.triangles[t].end());
    }
    std::sort(here.begin(), here.end());
    points_.insert(points_.end(), here.begin(), std::unique(here.begin(), here.end()));
    ends_.push_back(static_cast<int>(points_.size()));
  }
}

Eigen::AlignedBox3d TriangleBlocks::box(int b, const Points& positions) const {
  const double* const columns[] = {positions.col(0).data(), positions.col(1).data(),
                                   positions.col(2).data()};
  double low[] = {infinity, infinity, infinity}, high[] = {-infinity, -infinity, -infinity};
  for (const int* point = begin(b); point != end(b); ++point) {
    for (int axis = 0; axis < 3; ++axis) {
      const double here = columns[axis][*point];
      low[axis] = here < low[axis] ? here : low[axis];
      high[axis] = here > high[axis] ? here : high[axis];
    }
  }
  return {Vector3(low[0], low[1], low[2]), Vector3(high[0], high[1], high[2])};
}

double TriangleBlocks::min(int b, const Scalars& values) const {
  double low = infinity;
  for (const int* point = begin(b); point != end(b); ++point) {
    low = values[*point] < low ? values[*point] : low;
  }
  return low;
}

}  // namespace clothsim
