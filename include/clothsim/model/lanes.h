#pragma once

namespace clothsim {

/// Eight numbers as the vector units see them, wherever they begin: for sums and maxima, which a
/// compiler that keeps the order of operations does not vectorise. Each of the eight goes its own
/// way, so the result is the same on every vector unit.
using Lanes = double __attribute__((vector_size(64), aligned(8), may_alias));
constexpr int num_lanes = 8;

inline const Lanes& lanes_at(const double* numbers) {
  return *reinterpret_cast<const Lanes*>(numbers);
}

}  // namespace clothsim
