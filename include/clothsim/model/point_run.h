#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Consecutive points of N x 3, where each coordinate's column goes on from the first of them: what
/// a vector loop over some of the points takes.
struct PointRun {
  const double* x;
  const double* y;
  const double* z;
};

/// The same, to be written.
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
