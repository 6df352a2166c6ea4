#include "clothsim/geometry/tile_features.h"

#include <utility>

namespace clothsim {

SurfacePair TileFeatures::pair(int a, int b, std::size_t number) const {
  if (number == own_points) return {SurfacePair::no_triangle, {a, a, b, b}, 0};
  if (number >= points) {
    const auto& [i, j] = edges[(number - points) / 3];
    const auto& [k, l] = edges[(number - points) % 3];
    return {SurfacePair::no_triangle, {point(a, i), point(a, j), point(b, k), point(b, l)}, 0};
  }
  if (number >= 2) std::swap(a, b);
  const auto& [i, j, k] = triangles[number % 2];
  const int cell = b - b / columns_;  // one less in each row
  return {2 * cell + static_cast<int>(number % 2), {a, point(b, i), point(b, j), point(b, k)}, 0};
}

}  // namespace clothsim
