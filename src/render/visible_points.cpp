#include "clothsim/render/visible_points.h"

#include <array>
#include <cmath>
#include <optional>

#include "clothsim/geometry/nearest_tree.h"
#include "clothsim/geometry/rays.h"

namespace clothsim {
namespace {

/// Surfaces that may occlude points, relative to the camera, along the world's axes [m].
class Scenery {
 public:
  Scenery(const std::vector<DrawItem>& items, bool rope) {
    for (const DrawItem& item : items) {
      if (item.sphere_radius) {
        balls_.push_back({item.translation, *item.sphere_radius});
      } else if (!item.is_cloth || !rope) {
        add_triangles(item);
      }
    }
    std::vector<Box> boxes;
    boxes.reserve(triangles_.size());
    for (const auto& t : triangles_) boxes.push_back(Box(t[0]).extend(t[1]).extend(t[2]));
    tree_.emplace(boxes);
  }

  /// Whether a surface lies between the camera and point `i` at `p`, beyond the near plane, which
  /// is at the share `nearest` of the way to the point.
  bool hides(int i, const Vector3& p, double nearest) const {
    const double farthest = 1 - on_surface / p.norm();
    for (const Ball& ball : balls_)
      if (is_before(ball, p, nearest, farthest)) return true;
    double most = farthest;
    tree_->search([&](const Box& box) { return hit_by_ray(Vector3::Zero(), p, box); }, most,
                  [&](int triangle) {
                    const auto k = static_cast<std::size_t>(triangle);
                    const std::array<int, 3>& own = corners_[k];
                    if (own[0] == i || own[1] == i || own[2] == i) return;
                    const double hit = hit_by_ray(Vector3::Zero(), p, triangles_[k]);
                    if (hit >= nearest && hit <= farthest) most = found;
                  });
    return most == found;
  }

 private:
  struct Ball {
    Vector3 center;
    double radius;
  };

  static constexpr double found = -1;  // less than any bound: ends the search
  static constexpr int no_point = -1;  // for a collider's triangle

  void add_triangles(const DrawItem& item) {
    const auto& [first, count] = item.own_triangles;
    for (int number = first; number < first + count; ++number) {
      const auto& triangle = (*item.triangles)[static_cast<std::size_t>(number)];
      std::array<Vector3, 3> t;
      for (std::size_t k = 0; k < 3; ++k)
        t[k] = item.rotation * row(*item.positions, triangle[k]) + item.translation;
      triangles_.push_back(t);
      corners_.push_back(item.is_cloth ? triangle
                                       : std::array<int, 3>{no_point, no_point, no_point});
    }
  }

  /// |t p - c|^2 = r^2
  static bool is_before(const Ball& ball, const Vector3& p, double nearest, double farthest) {
    const double a = p.squaredNorm(), b = p.dot(ball.center);
    const double chord = b * b - a * (ball.center.squaredNorm() - ball.radius * ball.radius);
    if (chord <= 0) return false;
    const auto between = [&](double t) { return t >= nearest && t <= farthest; };
    return between((b - std::sqrt(chord)) / a) || between((b + std::sqrt(chord)) / a);
  }

  std::vector<Ball> balls_;
  std::vector<std::array<Vector3, 3>> triangles_;
  std::vector<std::array<int, 3>> corners_;  // points of the cloth
  std::optional<NearestTree> tree_;          // of the triangles
};

bool in_image(const Camera& c, const Vector3& optical) {
  if (optical.z() < c.near || optical.z() > c.far) return false;
  const double u = c.fx * optical.x() / optical.z() + c.cx;
  const double v = c.fy * optical.y() / optical.z() + c.cy;
  return u >= -0.5 && u < c.width - 0.5 && v >= -0.5 && v < c.height - 0.5;
}

}  // namespace

std::vector<std::uint32_t> visible_points(const Camera& camera, const Points& points, bool rope,
                                          const std::vector<DrawItem>& items) {
  const Scenery scenery(items, rope);
  const Eigen::Matrix3d to_optical =
      camera.pose.orientation.normalized().toRotationMatrix().transpose();
  std::vector<std::uint32_t> seen;
  for (int i = 0; i < static_cast<int>(points.rows()); ++i) {
    const Vector3 p = row(points, i) - camera.pose.position;
    const Vector3 optical = to_optical * p;
    if (in_image(camera, optical) && !scenery.hides(i, p, camera.near / optical.z()))
      seen.push_back(static_cast<std::uint32_t>(i));
  }
  return seen;
}

}  // namespace clothsim
