#pragma once

namespace clothsim {

/// What one core of this machine can do at most, in double precision and without fused
/// multiply-add, by loops compiled and picked at run time like the kernels.
struct MachinePeak {
  double l1;           // bytes read per second, of a set that fits the first-level cache
  double l2;           // the same, of a set that only fits the second level
  double l2_copy;      // bytes read and written per second, likewise
  double mul_add;      // multiplications and additions per second
  double square_root;  // per second
  double division;     // per second
};

/// Measured at the first call, in about 0.1 s.
const MachinePeak& machine_peak();

}  // namespace clothsim
