#pragma once

#include <array>
#include <memory>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Tells a method when data of earlier steps (a factorisation, colours, history) is no longer
/// valid.
class ClothWatch {
 public:
  /// Do springs, bends, cells, masses, pins, drag or the step h [s] differ from those of the last
  /// call? True at the first call.
  bool changed(const Cloth&, double h);

  /// The same without an update.
  bool differs(const Cloth&, double h) const;

 private:
  double h_ = 0;
  double damping_ = 0;
  std::vector<double> dampings_;
  Scalars mass_;
  Scalars inv_mass_;
  std::vector<SpringRun> springs_;
  std::vector<BendRun> bends_;
  std::vector<CellRun> cells_;
  std::shared_ptr<const TriangleFabric> triangle_fabric_;
  std::array<double, 2> internal_damping_{};
};

}  // namespace clothsim
