#include "clothsim/render/visible_points.h"

#include <array>
#include <cmath>
#include <utility>

#include "clothsim/geometry/rays.h"
#include "clothsim/render/image_tiles.h"

namespace clothsim {
namespace {

/// Fine tiles: a test of a triangle and a point costs more than a tile.
constexpr std::size_t tiles_a_point = 4;

/// Bound on the rounding of pixel coordinates, which are at most 8192.
constexpr double tolerance = 1e-6;  // [pixel]

constexpr int no_point = -1;

/// Positions are relative to the camera, along the world's axes [m].
class Visibility {
 public:
  /// All points in the image are visible so far.
  Visibility(const Camera& camera, const Points& points)
      : camera_(camera),
        to_optical_(camera.pose.orientation.normalized().toRotationMatrix().transpose()),
        positions_(points.rowwise() - camera.pose.position.transpose()),
        pixels_(points.rows(), 2),
        visible_(static_cast<std::size_t>(points.rows()), false),
        tiles_(camera, tiles_a_point * visible_.size()),
        first_(static_cast<std::size_t>(tiles_.num_tiles()), no_point),
        next_(visible_.size(), no_point) {
    for (int i = 0; i < static_cast<int>(points.rows()); ++i) {
      const Vector3 optical = to_optical_ * row(positions_, i);
      if (optical.z() < camera.near || optical.z() > camera.far) continue;
      const Eigen::Vector2d pixel = pixel_of(camera, optical);
      if (pixel.x() < -0.5 || pixel.x() >= camera.width - 0.5 || pixel.y() < -0.5 ||
          pixel.y() >= camera.height - 0.5)
        continue;
      pixels_.row(i) = pixel;
      visible_[static_cast<std::size_t>(i)] = true;
      int& first = first_[static_cast<std::size_t>(tiles_.tile_at(pixel))];
      next_[static_cast<std::size_t>(i)] = std::exchange(first, i);
    }
  }

  void hide_behind_ball(const Vector3& center, double radius) {
    for (int i = 0; i < static_cast<int>(positions_.rows()); ++i) {
      if (!visible_[static_cast<std::size_t>(i)]) continue;
      const Vector3 p = row(positions_, i);
      const double a = p.squaredNorm(), b = p.dot(center);  // |t p - c|^2 = r^2
      const double chord = b * b - a * (center.squaredNorm() - radius * radius);
      if (chord <= 0) continue;
      hide_if_hit(i, (b - std::sqrt(chord)) / a);
      hide_if_hit(i, (b + std::sqrt(chord)) / a);
    }
  }

  /// Hides the points behind the triangles of an item. `has_points`: its corners are the points,
  /// which their own triangles do not hide.
  void hide_behind_triangles(const DrawItem& item, bool has_points) {
    const auto& [first, count] = item.own_triangles;
    for (int number = first; number < first + count; ++number) {
      const auto& corners = (*item.triangles)[static_cast<std::size_t>(number)];
      std::array<Vector3, 3> triangle, optical;
      for (std::size_t k = 0; k < 3; ++k) {
        triangle[k] = item.rotation * row(*item.positions, corners[k]) + item.translation;
        optical[k] = to_optical_ * triangle[k];
      }
      Eigen::AlignedBox2d seen = seen_box(camera_, optical);
      if (seen.isEmpty()) continue;
      seen.min().array() -= tolerance;
      seen.max().array() += tolerance;
      const auto test = [&](int i) {
        if (!visible_[static_cast<std::size_t>(i)]) return;
        if (!seen.contains(Eigen::Vector2d(pixels_.row(i)))) return;
        if (has_points && (corners[0] == i || corners[1] == i || corners[2] == i)) return;
        hide_if_hit(i, hit_by_ray(Vector3::Zero(), row(positions_, i), triangle));
      };
      tiles_.for_each(tiles_.covered(seen), [&](int tile) {
        for (int i = first_[static_cast<std::size_t>(tile)]; i != no_point;
             i = next_[static_cast<std::size_t>(i)])
          test(i);
      });
    }
  }

  /// Numbers of the points, ascending.
  std::vector<std::uint32_t> seen() const {
    std::vector<std::uint32_t> numbers;
    for (std::size_t i = 0; i < visible_.size(); ++i)
      if (visible_[i]) numbers.push_back(static_cast<std::uint32_t>(i));
    return numbers;
  }

 private:
  /// Hides a point behind a surface at the share `hit` of the way to it, beyond the near plane.
  void hide_if_hit(int i, double hit) {
    const Vector3 p = row(positions_, i);
    const double nearest = camera_.near / to_optical_.row(2).dot(p);
    if (hit >= nearest && hit <= 1 - on_surface / p.norm())
      visible_[static_cast<std::size_t>(i)] = false;
  }

  Camera camera_;
  Eigen::Matrix3d to_optical_;
  Points positions_;
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> pixels_;
  std::vector<bool> visible_;
  ImageTiles tiles_;
  std::vector<int> first_, next_;  // the points of each tile, in a linked list
};

}  // namespace

std::vector<std::uint32_t> visible_points(const Camera& camera, const Points& points, bool rope,
                                          const std::vector<DrawItem>& items) {
  Visibility visibility(camera, points);
  for (const DrawItem& item : items) {
    if (item.sphere_radius) {
      visibility.hide_behind_ball(item.translation, *item.sphere_radius);
    } else if (!item.is_cloth || !rope) {
      visibility.hide_behind_triangles(item, item.is_cloth);
    }
  }
  return visibility.seen();
}

}  // namespace clothsim
