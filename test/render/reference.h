#pragma once

#include <optional>

#include "clothsim/render/image.h"
#include "clothsim/render/mesh.h"

namespace clothsim {

/// Hit of a ray on a mesh, in double precision: the input of a fragment shader.
struct Hit {
  double distance;   // in lengths of the ray
  Vector3 position;  // [m]
  Vector3 normal;    // interpolated and normalised, on the side of the ray's origin
  Vector3 tangent;   // interpolated, not normalised
  Eigen::Vector2d uv;
  bool front;  // whether the triangle's front side is visible
};

/// The nearest hit, by a test of every triangle (Moeller and Trumbore 1997).
std::optional<Hit> trace(const Mesh&, const Vector3& eye, const Vector3& ray);

/// Linear value of a channel at (u, v), v upwards, between the four nearest pixels, repeating.
double sample(const Image&, int channel, const Eigen::Vector2d& uv);
double sample(const HeightMap&, const Eigen::Vector2d& uv);

}  // namespace clothsim
