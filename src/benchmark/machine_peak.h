#pragma once

namespace clothsim {

/// Peak rates of one core of this machine, in double precision and without fused multiply-add, by
/// loops compiled and chosen at run time like the kernels.
struct MachinePeak {
  double l1;           // bytes read per second, of a set that fits the first-level cache
  double l2;           // the same, of a set that fits only the second level
  double l2_copy;      // bytes read and written per second, of a set as for l2
  double mul_add;      // multiplications and additions per second
  double square_root;  // per second
  double division;     // per second
};

/// Measured at the first call, in about 0.1 s.
const MachinePeak& machine_peak();

}  // namespace clothsim
