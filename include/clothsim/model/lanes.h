#pragma once

namespace clothsim {

/// Sums and maxima, which a compiler that keeps the order of operations does not vectorise, take
/// eight numbers at once, at any address, as two vectors of four. The lanes are independent, so the
/// result is the same on every vector unit. Vectors of eight are no faster with AVX-512, and ten
/// times as slow with AVX2, as GCC keeps them in memory.
constexpr int num_lanes = 8;
constexpr int half_size = 4;
using Half = double __attribute__((vector_size(32), aligned(8), may_alias));

inline const Half& half_at(const double* numbers) {
  return *reinterpret_cast<const Half*>(numbers);
}

/// Sum of eight lanes, in their order, from `sum` on.
[[gnu::always_inline]] inline void add_lanes(const Half (&lanes)[2], double& sum) {
  for (const Half& half : lanes) {
    for (int lane = 0; lane < half_size; ++lane) sum += half[lane];
  }
}
/// The largest of eight lanes and of `largest`.
[[gnu::always_inline]] inline void take_largest(const Half (&lanes)[2], double& largest) {
  for (const Half& half : lanes) {
    for (int lane = 0; lane < half_size; ++lane) {
      if (half[lane] > largest) largest = half[lane];
    }
  }
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
