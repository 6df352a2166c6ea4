#include "clothsim/render/image_tiles.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Number of tiles of a row or column before the one with `pixel`.
std::int16_t tiles_before(double pixel, double side, int count) {
  return static_cast<std::int16_t>(
      std::clamp(std::floor((pixel + 0.5) / side), 0.0, double(count)));
}

}  // namespace

Eigen::AlignedBox2d seen_box(const Camera& camera, const std::array<Vector3, 3>& triangle) {
  Eigen::AlignedBox2d seen;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 &a = triangle[k], &b = triangle[(k + 1) % 3];
    const double before = a.z() - camera.near, after = b.z() - camera.near;
    if (before >= 0) seen.extend(pixel_of(camera, a));
    if ((before >= 0) != (after >= 0))
      seen.extend(pixel_of(camera, a + before / (before - after) * (b - a)));
  }
  return seen;
}

ImageTiles::ImageTiles(const Camera& camera, std::size_t number)
    : side_(std::max(1.0, std::sqrt(double(camera.width) * camera.height /
                                    static_cast<double>(std::max<std::size_t>(number, 1))))),
      columns_(static_cast<int>(std::ceil(camera.width / side_))),
      rows_(static_cast<int>(std::ceil(camera.height / side_))) {}

int ImageTiles::tile_at(const Eigen::Vector2d& pixel) const {
  return tiles_before(pixel.y(), side_, rows_ - 1) * columns_ +
         tiles_before(pixel.x(), side_, columns_ - 1);
}

ImageTiles::Block ImageTiles::covered(const Eigen::AlignedBox2d& box) const {
  if (box.isEmpty()) return {0, 0, 0, 0};
  const Eigen::Vector2d &least = box.min(), &most = box.max();
  return {tiles_before(least.x(), side_, columns_), tiles_before(most.x() + side_, side_, columns_),
          tiles_before(least.y(), side_, rows_), tiles_before(most.y() + side_, side_, rows_)};
}

}  // namespace clothsim
