#pragma once

#include <optional>

#include "clothsim/render/image.h"
#include "clothsim/render/mesh.h"

namespace clothsim {

/// Where a ray meets a mesh, in double: what a fragment shader is handed.
struct Hit {
  double distance;   // in lengths of the ray
  Vector3 position;  // [m]
  Vector3 normal;    // interpolated and made unit, towards where the ray comes from
  Vector3 tangent;   // interpolated, not made unit
  Eigen::Vector2d uv;
  bool front;  // the triangle's front side is seen
};

/// The nearest hit, by trying every triangle (Moeller and Trumbore 1997).
std::optional<Hit> trace(const Mesh&, const Vector3& eye, const Vector3& ray);

/// Linear value of a channel at (u, v), v upwards, between the four nearest pixels, repeating.
double sample(const Image&, int channel, const Eigen::Vector2d& uv);
double sample(const HeightMap&, const Eigen::Vector2d& uv);

}  // namespace clothsim
