#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Sum of m v^2 / 2 over the free points [J].
double kinetic_energy(const Cloth&, const State&);

/// Sum of k (l - L0)^2 / 2 over the springs, plus the energy of bends [J].
double elastic_energy(const Cloth&, const Points& positions);

/// Sum of -m g.x over the free points [J], zero at the origin.
double gravitational_energy(const Cloth&, const Vector3& gravity, const Points& positions);

/// Root mean square speed over all points [m/s].
double rms_velocity(const State&);

}  // namespace clothsim
