#pragma once

#include <array>
#include <cstdint>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Density of air at 20 degrees and sea level [kg/m^3].
inline constexpr double air_density = 1.2;

/// Gusts of the wind: the same everywhere.
struct Gusts {
  double max = 0;  // largest deviation of a component from the mean [m/s]
  std::uint64_t seed = 1;
};

/// The wind [m/s], `mean` plus the gusts at `time` [s]: along each axis a sum of waves of 0.1 to 3
/// Hz with phases drawn from the seed. Their power falls with the frequency's 5/3, as in a wind
/// near the ground (Kaimal et al. 1972, "Spectral characteristics of surface-layer turbulence"),
/// and their amplitudes add up to `max`. A function of its arguments, without state.
Vector3 wind_at(const Vector3& mean, const Gusts&, double time);

/// Writes the forces of air that moves at `wind` [m/s] on the cloth's triangles [N], N x 3: with
/// the area vector N of a triangle, its size A and the relative wind w,
///   density / 2 (c_n |w_n| w_n + c_t |w_t| w_t) A,  w_n = (w . N) N / A^2,  w_t = w - w_n,
/// a third on each of its corners. The terms are the pressure across and the friction along a
/// sheet; lift is the part of the first across the wind. Wejchert & Haumann 1991, "Animation
/// aerodynamics". A triangle without area has no force. The
/// cloth's drag is c_n, c_t.
class AirForces {
 public:
  const Points& compute(const Cloth&, const Vector3& wind, const State&, const Workers& = {});

 private:
  Points lower_;   // on each corner of a cell's first triangle, by the cell's first point [N]
  Points upper_;   // the same for the second
  Points forces_;  // [N], N x 3
};

/// Largest rate of any of several cloths [1/s] at which air reduces the relative velocity of a
/// cloth at `speed` [m/s]: the derivative of its drag.
double air_rate(const Cloth&, double speed);

}  // namespace clothsim
