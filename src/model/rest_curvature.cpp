#include "clothsim/model/rest_curvature.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

/// SmoothNormal's softening as a share of the triangle's |N|: it shortens the normal by half a
/// percent, and a collapsed triangle turns it at most ten times as fast as the triangle at rest.
constexpr double softening_share = 0.1;
/// A curvature below this share of its terms is 0.
constexpr double curvature_rounding = 1e-9;

/// Index of each pair of points.
std::map<std::array<int, 2>, int> pair_numbers(const TriangleFabric& fabric) {
  std::map<std::array<int, 2>, int> numbers;
  for (const TriangleFabric::Pair& pair : fabric.pairs) {
    numbers.emplace(std::array<int, 2>{pair.i, pair.j}, static_cast<int>(numbers.size()));
  }
  return numbers;
}

}  // namespace

double angle_across(const std::array<Vector3, 3>& corners, std::size_t k, const Vector3& far) {
  const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  const Vector3 outward = (corners[(k + 1) % 3] - corners[k]).normalized().cross(normal);
  const Vector3 to = far - corners[k];
  return std::atan2(to.dot(normal), to.dot(outward));
}

void keep_curvature(const std::array<Vector3, PatchBend::near>& places, PatchBend& bend) {
  Vector3 along = Vector3::Zero();
  double size = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    along += bend.coefficients[k] * places[k];
    size += std::abs(bend.coefficients[k]) * (places[k] - places[0]).norm();
  }
  const Vector3 first = places[1] - places[0], second = places[2] - places[0];
  Eigen::Matrix3d axes;  // both sides, and the normal N
  axes << first, second, first.cross(second);
  const Vector3 parts = axes.inverse() * along;
  for (std::size_t k = 1; k < 3; ++k) {
    const double part = parts[static_cast<Eigen::Index>(k) - 1];
    bend.coefficients[k] -= part;
    bend.coefficients[0] += part;
  }
  const double area2 = axes.col(2).norm();
  if (std::abs(parts[2]) * area2 < curvature_rounding * size) return;  // as the twist of a cylinder
  bend.softening = softening_share * area2;
  bend.curvature = parts[2] * std::hypot(area2, bend.softening);
}

void add_curved_triangles(TriangleFabric& fabric) {
  std::map<std::array<int, 2>, int> numbers;
  for (const PatchBend& bend : fabric.bends) {
    if (bend.curvature == 0) continue;
    std::array<int, PatchBend::near> points{};
    std::copy_n(bend.points.begin(), points.size(), points.begin());
    if (fabric.curved.empty() || fabric.curved.back().points != points) {
      if (numbers.empty()) numbers = pair_numbers(fabric);
      CurvedTriangle curved{points, {}, 0, bend.softening, {}};
      std::size_t pair = 0;
      for (std::size_t k = 0; k < PatchBend::near; ++k) {
        for (std::size_t l = k + 1; l < PatchBend::near; ++l) {
          const auto [i, j] = std::minmax(bend.points[k], bend.points[l]);
          curved.pairs[pair++] = i == j ? -1 : numbers.at({i, j});
        }
      }
      fabric.curved.push_back(curved);
    }
    CurvedTriangle& curved = fabric.curved.back();
    for (std::size_t k = 0; k < PatchBend::near; ++k) {
      curved.weights[k] += bend.stiffness * bend.curvature * bend.coefficients[k];
    }
    curved.stiffness += bend.stiffness * bend.curvature * bend.curvature;
  }
  if (fabric.curved.empty()) return;

  std::vector<std::vector<TriangleFabric::CurvedLink>> of_point(fabric.piece_ids.size());
  for (std::size_t t = 0; t < fabric.curved.size(); ++t) {
    for (std::size_t k = 0; k < PatchBend::near; ++k) {
      const CurvedTriangle& curved = fabric.curved[t];
      if (curved.weights[k] == 0 && k >= 3) continue;  // a repeated point
      of_point[static_cast<std::size_t>(curved.points[k])].push_back(
          {static_cast<int>(t), static_cast<int>(k)});
    }
  }
  for (const auto& links : of_point) {
    fabric.first_curved_links.push_back(static_cast<int>(fabric.curved_links.size()));
    fabric.curved_links.insert(fabric.curved_links.end(), links.begin(), links.end());
  }
  fabric.first_curved_links.push_back(static_cast<int>(fabric.curved_links.size()));
}

}  // namespace clothsim
