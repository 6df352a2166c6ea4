#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Consecutive points of N x 3, where each coordinate's column goes on from the first of them: what
/// a vector loop over some of the points takes.
template <typename Real>
struct RunOf {
  Real* x;
  Real* y;
  Real* z;
};
using PointRun = RunOf<const double>;
using MutablePointRun = RunOf<double>;

inline PointRun run_from(const Points& points, int first) {
  return {&points(first, 0), &points(first, 1), &points(first, 2)};
}
inline MutablePointRun run_from(Points& points, int first) {
  return {&points(first, 0), &points(first, 1), &points(first, 2)};
}
inline PointRun read_only(const MutablePointRun& run) { return {run.x, run.y, run.z}; }

}  // namespace clothsim
