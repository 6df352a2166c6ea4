#include "clothsim/search/surface_pair.h"

#include <algorithm>

#include "clothsim/geometry/closest_points.h"

namespace clothsim {

Separation separation(const SurfacePair& pair, const Points& positions) {
  const auto at = [&](std::size_t k) {
    const int i = pair.points[k];
    return Vector3(positions(i, 0), positions(i, 1), positions(i, 2));
  };
  const Vector3 p0 = at(0), p1 = at(1), p2 = at(2), p3 = at(3);
  Separation result;
  Vector3 d;
  if (pair.edges()) {
    const auto [s, t] = closest_on_segments(p0, p1, p2, p3);
    result.weights = {1 - s, s, t - 1, -t};
    d = (1 - s) * p0 + s * p1 - (1 - t) * p2 - t * p3;
  } else {
    const auto [u, v, w] = closest_on_triangle(p0, p1, p2, p3);
    result.weights = {1, -u, -v, -w};
    d = p0 - u * p1 - v * p2 - w * p3;
  }
  result.distance = d.norm();
  result.normal = result.distance > 0 ? Vector3(d / result.distance) : Vector3::Zero();
  return result;
}

double gap_along(const Vector3& direction, const SurfacePair& pair, const Points& positions) {
  std::array<double, 4> along;
  for (std::size_t k = 0; k < 4; ++k) {
    const int i = pair.points[k];
    along[k] = direction[0] * positions(i, 0) + direction[1] * positions(i, 1) +
               direction[2] * positions(i, 2);
  }
  const double farther = std::max(along[2], along[3]);
  return pair.edges() ? std::min(along[0], along[1]) - farther
                      : along[0] - std::max(along[1], farther);
}

}  // namespace clothsim
