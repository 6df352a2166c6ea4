#pragma once

namespace clothsim {

/// Eight numbers as a vector, at any address: for sums and maxima, which a compiler that keeps the
/// order of operations does not vectorise. The lanes are independent, so the result is the same on
/// every vector unit.
using Lanes = double __attribute__((vector_size(64), aligned(8), may_alias));
constexpr int num_lanes = 8;

inline const Lanes& lanes_at(const double* numbers) {
  return *reinterpret_cast<const Lanes*>(numbers);
}

/// Calls body(i) for i in [0, count), in loops of eight that a compiler vectorises. Bodies must not
/// depend on each other, and must be inlined: [&](int i) CLOTHSIM_INLINE { ... }.
#define CLOTHSIM_INLINE __attribute__((always_inline))
template <typename Body>
[[gnu::always_inline]] inline void for_each_lane(int count, const Body& body) {
  int first = 0;
  for (; first + num_lanes <= count; first += num_lanes) {
#pragma GCC ivdep
    for (int lane = 0; lane < num_lanes; ++lane) body(first + lane);
  }
  for (int i = first; i < count; ++i) body(i);
}

/// Compilers vectorise these ternaries, but not std::min and std::max.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

}  // namespace clothsim
