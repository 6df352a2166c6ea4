#include "stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "clothsim/render/shape_drawing.h"

namespace clothsim_rviz {
namespace {

using clothsim::Vector3;
using Box = Eigen::AlignedBox3d;

using clothsim::infinity;

/// Samples along the cloth and around colliders, and the margin around the box as a share of the
/// distance.
constexpr int samples = 10;
constexpr int segments = 16;
constexpr double frame_margin = 0.1;

/// How far a free upright cloth spreads from its plane as it falls, of its height.
constexpr double spread = 0.25;

Vector3 place(const clothsim::ClothSpec& cloth, double u, double v) {
  const bool upright = cloth.orientation == clothsim::Orientation::vertical;
  return cloth.origin +
         Vector3(u * cloth.width, upright ? 0 : v * cloth.height, upright ? v * cloth.height : 0);
}

/// One cloth at the start.
struct Sheet {
  std::vector<Vector3> places;  // of its points, or samples of them; the first is point [0, 0]
  std::vector<Vector3> pins;
  bool is_upright;
};

Sheet sheet_of_grid(const clothsim::ClothSpec& cloth) {
  Sheet sheet{{}, {}, cloth.orientation == clothsim::Orientation::vertical};
  for (int i = 0; i <= samples; ++i) {
    for (int j = 0; j <= samples; ++j) {
      sheet.places.push_back(place(cloth, double(i) / samples, double(j) / samples));
    }
  }
  for (const clothsim::Pin& pin : cloth.pinned) {
    sheet.pins.push_back(place(cloth, double(pin.column) / std::max(cloth.columns - 1, 1),
                               double(pin.row) / std::max(cloth.rows - 1, 1)));
  }
  return sheet;
}

/// Points [first, end) of a mesh.
Sheet sheet_of_mesh(const clothsim::ClothSpec& cloth, int first, int end) {
  Sheet sheet{{}, {}, false};
  for (int i = first; i < end; ++i) {
    sheet.places.push_back(clothsim::row(cloth.mesh->positions, i));
  }
  for (const clothsim::Pin& pin : cloth.pinned) {
    if (pin.column < first || pin.column >= end) continue;
    sheet.pins.push_back(clothsim::row(cloth.mesh->positions, pin.column));
  }
  return sheet;
}

std::vector<Sheet> sheets_of(const clothsim::ClothSpec& cloth) {
  if (!cloth.mesh) return {sheet_of_grid(cloth)};
  if (cloth.parts.empty()) return {sheet_of_mesh(cloth, 0, cloth.columns)};
  std::vector<Sheet> sheets;
  for (const clothsim::ClothPart& part : cloth.parts) {
    sheets.push_back(sheet_of_mesh(cloth, part.first_point, part.first_point + part.num_points()));
    sheets.back().is_upright = part.is_vertical;
  }
  return sheets;
}

/// Height of the ground straight below a point: of the highest plane there.
double ground_below(const Vector3& point, const clothsim::Scene& scene) {
  double ground = -infinity;
  for (const clothsim::ColliderSpec& collider : scene.colliders) {
    if (!std::holds_alternative<clothsim::Plane>(collider.shape)) continue;
    const clothsim::Pose pose = collider.pose * collider.offset;
    const Vector3 normal = pose.orientation * Vector3::UnitZ();
    if (normal.z() <= 0) continue;
    const double drop = normal.dot(point - pose.position) / normal.z();
    if (drop >= 0) ground = std::max(ground, point.z() - drop);
  }
  return ground;
}

/// The box of finite colliders, as far as they are within `reach`.
Box solids(const clothsim::Scene& scene, const Box& reach) {
  Box all;
  for (const clothsim::ColliderSpec& collider : scene.colliders) {
    if (!std::isfinite(clothsim::bounding_radius(collider.shape))) continue;
    const clothsim::Pose pose = collider.pose * collider.offset;
    Box box;
    const clothsim::Mesh mesh = clothsim::drawing_of(collider.shape).mesh(segments, 1);
    for (Eigen::Index i = 0; i < mesh.positions.rows(); ++i) {
      box.extend(clothsim::to_world(pose, mesh.positions.row(i).transpose()));
    }
    const Box seen = box.intersection(reach);
    if (!seen.isEmpty()) all.extend(seen);
  }
  return all;
}

/// Lowest height of a point that hangs from the nearest pin.
double hangs_at(const Vector3& point, const std::vector<Vector3>& pins) {
  const auto farther = [&](const Vector3& a, const Vector3& b) {
    return (a - point).norm() < (b - point).norm();
  };
  const Vector3& pin = *std::min_element(pins.begin(), pins.end(), farther);
  return std::min(point.z(), pin.z() - (pin - point).norm());
}

/// The box of all places through which a cloth falls or swings.
Box stage_of(const Sheet& sheet, const clothsim::Scene& scene) {
  Box start;
  for (const Vector3& point : sheet.places) start.extend(point);

  Box stage = start;
  const Vector3 size = Vector3::Constant(start.diagonal().norm());
  Box reach(start.min() - size, start.max() + size);
  if (sheet.pins.empty()) reach.min().z() = -infinity;
  const Box obstacles = solids(scene, reach);
  // A cloth that lies across an obstacle hangs down by half its side.
  const double side = start.sizes().maxCoeff();
  const double drapes_at = obstacles.isEmpty() ? infinity : obstacles.max().z() - side / 2;

  for (const Vector3& point : sheet.places) {
    const double ground = ground_below(point, scene);
    double lowest = sheet.pins.empty() ? std::min(ground, drapes_at) : hangs_at(point, sheet.pins);
    lowest = std::min(std::max(lowest, ground), point.z());
    if (std::isfinite(lowest)) stage.extend(Vector3(point.x(), point.y(), lowest));
  }
  if (!obstacles.isEmpty()) stage.extend(obstacles);
  if (sheet.pins.empty() && sheet.is_upright) {
    const Vector3 aside(0, spread * start.sizes().z(), 0), origin = sheet.places.front();
    stage.extend(origin - aside).extend(origin + aside);
  }
  return stage;
}

Box stage_in_world(const clothsim::Scene& scene) {
  Box stage;
  for (const Sheet& sheet : sheets_of(scene.cloth)) stage.extend(stage_of(sheet, scene));
  return stage;
}

constexpr int num_corners = 8;

Vector3 corner(const Box& box, int i) { return box.corner(static_cast<Box::CornerType>(i)); }

}  // namespace

Box stage_of(const clothsim::Scene& scene, const clothsim::Pose& in_fixed) {
  const Box stage = stage_in_world(scene);
  Box turned;
  for (int i = 0; i < num_corners; ++i)
    turned.extend(clothsim::to_world(in_fixed, corner(stage, i)));
  return turned;
}

double viewing_distance(const Box& box, const Vector3& out, const Lens& lens) {
  const Vector3 across = Vector3::UnitZ().cross(out).normalized();
  const Vector3 up = out.cross(across);
  double distance = 0;
  for (int i = 0; i < num_corners; ++i) {
    const Vector3 offset = corner(box, i) - box.center();
    const double needed =
        std::max(std::abs(across.dot(offset)) / lens.across, std::abs(up.dot(offset)) / lens.up);
    distance = std::max(distance, needed * (1 + frame_margin) + out.dot(offset));
  }
  return distance;
}

}  // namespace clothsim_rviz
