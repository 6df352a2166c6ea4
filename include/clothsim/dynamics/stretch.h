#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Stretch l / L0 - 1 over the springs of a cloth; zero without springs.
struct Stretch {
  double worst = 0;  // largest
  double mean = 0;
};

Stretch measure_stretch(const Cloth&, const Points& positions);

/// The same `worst` alone, fast enough for every frame.
double worst_stretch(const Cloth&, const Points& positions);

/// Largest stretch of a spring beyond its strain limit; zero where all hold it or none has one.
/// `worst`: worst_stretch() there.
double worst_violation(const Cloth&, const Points& positions, double worst);

}  // namespace clothsim
