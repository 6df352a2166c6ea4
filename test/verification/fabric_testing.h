#pragma once

#include <cmath>

#include "verification/testing.h"

namespace clothsim::test {

inline constexpr double fabric_density = 0.2;  // [kg/m^2]

/// A fabric of `columns` x `rows` points, cells du x dv [m], without drag and strain limit.
inline ClothSpec fabric_spec(int columns, int rows, double du, double dv) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.width = columns > 1 ? du * (columns - 1) : du;
  spec.height = rows > 1 ? dv * (rows - 1) : dv;
  spec.origin = Vector3::Zero();
  spec.material.density = fabric_density;
  spec.material.damping = 0;
  spec.material.strain_limit.reset();
  Fabric fabric;
  fabric.stretch_stiffness = {900, 700};
  fabric.shear_stiffness = 30;
  fabric.bending_stiffness = {3e-5, 1e-5};
  spec.material.fabric = fabric;
  return spec;
}

inline constexpr double strip_length = 0.1;  // [m]

/// Bending stiffness of a strip with gamma = density g L^3 / B [N m].
inline double strip_bending(double gamma) {
  return fabric_density * 9.8 * std::pow(strip_length, 3) / gamma;
}

/// A strip of `points` along warp or weft, the first two held: clamped halfway between them.
inline ClothSpec strip(double gamma, int points, bool along_weft) {
  const double spacing = strip_length / (points - 1.5);
  ClothSpec spec = along_weft ? fabric_spec(3, points, spacing, spacing)
                              : fabric_spec(points, 3, spacing, spacing);
  Fabric& fabric = *spec.material.fabric;
  fabric.stretch_stiffness = {2e4, 2e4};
  fabric.shear_stiffness = 200;
  fabric.bending_stiffness[along_weft ? 1 : 0] = strip_bending(gamma);
  for (int across = 0; across < 3; ++across) {
    for (int along = 0; along < 2; ++along) {
      spec.pinned.push_back(along_weft ? Pin{across, along, ""} : Pin{along, across, ""});
    }
  }
  return spec;
}

}  // namespace clothsim::test
