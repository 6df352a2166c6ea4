#pragma once

#include <array>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Tells a method when what it keeps from earlier steps (a factor, colours, history) no longer
/// holds.
class ClothWatch {
 public:
  /// Do springs, bends, masses, pins, drag or the step h [s] differ from those of the last call?
  /// True at the first call.
  bool changed(const Cloth&, double h);

  /// The same question, which leaves the last call as it is.
  bool differs(const Cloth&, double h) const;

 private:
  double h_ = 0;
  double damping_ = 0;
  Scalars mass_;
  Scalars inv_mass_;
  std::vector<SpringRun> springs_;
  std::vector<BendRun> bends_;
  std::array<double, 2> internal_damping_{};
};

}  // namespace clothsim
