#pragma once

#include <algorithm>

namespace clothsim {

/// Least gravity [m/s^2] for the weight of a cloth in contact: cloth without gravity is pressed and
/// pulled, too.
inline constexpr double min_gravity = 9.81;

/// Share of its thickness at which a fabric is all fibre. Thinner layers press as at this share:
/// the solids that hold them would give way. Fabrics are 65 to 80 % air (Morton & Hearle 2008,
/// Physical Properties of Textile Fibres).
inline constexpr double solid_share = 0.25;

/// Share of its thickness to which the weight of the whole cloth compresses a point of a cloth
/// without `compression`.
inline constexpr double share_under_weight = 0.99;

/// Pressure [Pa] of a layer at `share` of its thickness: kappa ((1 / share)^3 - 1), with kappa [Pa]
/// the compression modulus (van Wyk 1946, J. Text. Inst. 37, T285). Zero for shares above 1.
inline double compression_pressure(double kappa, double share) {
  if (share >= 1) return 0;
  const double s = std::max(share, solid_share);
  return kappa * (1 / (s * s * s) - 1);
}

}  // namespace clothsim
