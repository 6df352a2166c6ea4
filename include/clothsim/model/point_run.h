#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Consecutive points of N x 3, by the address of the first one's coordinate in each column: the
/// argument of vector loops over some of the points.
struct PointRun {
  const double* x;
  const double* y;
  const double* z;
};

/// The same, writable.
struct MutablePointRun {
  double* x;
  double* y;
  double* z;

  operator PointRun() const { return {x, y, z}; }
};

inline PointRun run_from(const Points& points, int first) {
  return {&points(first, 0), &points(first, 1), &points(first, 2)};
}
inline MutablePointRun run_from(Points& points, int first) {
  return {&points(first, 0), &points(first, 1), &points(first, 2)};
}

}  // namespace clothsim
