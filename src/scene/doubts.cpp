#include "clothsim/scene/doubts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <variant>

#include "clothsim/model/checks.h"
#include "clothsim/model/grid.h"
#include "clothsim/model/make_cloth.h"
#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/signed_distances.h"

namespace clothsim {
namespace {

using Lines = std::vector<std::string>;

/// A larger angle is more than a full turn, which nobody needs.
constexpr double largest_angle = 2 * M_PI;

/// A cloth of this size with cells of this size has no visible fold: the size may be in another
/// unit [m].
constexpr double large_size = 10;
constexpr double coarse_cell = 0.25;

/// Centimetres in a metre.
constexpr double centimetres = 100;

/// The value with enough digits for a message.
std::string rounded(double value) { return to_text(std::round(1e4 * value) / 1e4); }

bool is_number(const YAML::Node& node, double& value) {
  return node.IsScalar() && YAML::convert<double>::decode(node, value);
}

/// The angles of all maps within a node at `path`.
void doubt_angles(const YAML::Node& node, const std::string& path, Lines& lines) {
  std::size_t index = 0;
  for (const auto& item : node) {
    if (node.IsSequence()) {
      if (!item.IsScalar()) doubt_angles(item, path + std::to_string(index), lines);
      ++index;
      continue;
    }
    const std::string key = path + (path.empty() ? "" : ".") + item.first.Scalar();
    if (item.second.IsMap() || item.first.Scalar() != "rpy") {
      if (!item.second.IsScalar()) {
        doubt_angles(item.second, key + (item.second.IsSequence() ? "." : ""), lines);
      }
      continue;
    }
    for (const auto& angle : item.second) {
      double value = 0;
      if (!is_number(angle, value) || std::abs(value) <= largest_angle) continue;
      lines.push_back(key + ": got " + to_text(value) + " [rad]; did you mean " +
                      rounded(value * M_PI / 180) + ", " + to_text(value) + " degrees?");
      break;
    }
  }
}

void doubt_size(const ClothSpec& cloth, Lines& lines) {
  const auto doubt = [&](const std::string& key, double size, int points) {
    const double cell = size / std::max(1, points - 1);
    if (size < large_size || cell < coarse_cell) return;
    lines.push_back(key + ": got " + to_text(size) + " [m], cells of " + rounded(cell) +
                    " m; did you mean " + to_text(size / centimetres) + ", " + to_text(size) +
                    " cm?");
  };
  for (std::size_t i = 0; i < cloth.parts.size(); ++i) {
    const ClothPart& part = cloth.parts[i];
    if (!part.is_grid) continue;
    doubt("cloths." + std::to_string(i) + ".width", part.width, part.columns);
    doubt("cloths." + std::to_string(i) + ".height", part.height, part.rows);
  }
  if (cloth.mesh) return;
  doubt("cloth.width", cloth.width, cloth.columns);
  doubt("cloth.height", cloth.height, cloth.rows);
}

/// Whether the box of `points` is near enough for contact with the collider.
bool may_reach(const ColliderSpec& collider, const Points& points) {
  const Vector3 middle = (collider.pose * collider.offset).position;
  const Vector3 low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  return (middle - middle.cwiseMax(low).cwiseMin(high)).norm() <= bounding_radius(collider.shape);
}

/// Counts the points of the cloth that start in the collider.
int count_inside(const ColliderSpec& collider, const Points& points) {
  const int count = static_cast<int>(points.rows());
  const Frame frame(collider.pose * collider.offset);
  std::vector<double> distances(static_cast<std::size_t>(count));
  Points normals(count, 3);
  signed_distances(collider.shape, frame, run_from(points, 0), frame, run_from(points, 0), count,
                   MeshQuery{0, nullptr}, distances.data(), run_from(normals, 0));
  return static_cast<int>(std::count_if(distances.begin(), distances.end(),
                                        [](double d) { return d < -written_rounding; }));
}

/// Counts the triangles with corners on both sides of a plane.
int count_parted(const ColliderSpec& collider, const Cloth& cloth, const Points& points) {
  const Pose pose = collider.pose * collider.offset;
  const auto height = [&](int i) { return to_local(pose, points.row(i)).z(); };
  return static_cast<
      int>(std::count_if(cloth.triangles.begin(), cloth.triangles.end(), [&](const auto& corners) {
    const std::array<double, 3> z = {height(corners[0]), height(corners[1]), height(corners[2])};
    return *std::min_element(z.begin(),
                             z.end())<-written_rounding&& * std::max_element(z.begin(), z.end())>
        written_rounding;
  }));
}

/// Counts the triangles that reach into the collider, which may be thin and pass through the cloth
/// between points.
int count_crossed(const ColliderSpec& collider, const Cloth& cloth, const Points& points) {
  const Plane* plane = std::get_if<Plane>(&collider.shape);
  if (plane && plane->two_sided) return count_parted(collider, cloth, points);
  const Pose pose = collider.pose * collider.offset;
  int crossed = 0;
  for (const auto& corners : cloth.triangles) {
    Triangle local;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      local[i] = to_local(pose, points.row(corners[i]));
    }
    if (!touches_between_corners(collider.shape, local, 0)) continue;
    const auto distance = face_distance(collider.shape, local, 0);
    if (distance && distance->value < -written_rounding) ++crossed;
  }
  return crossed;
}

void doubt_start(const Scene& scene, Lines& lines) {
  if (scene.colliders.empty()) return;
  const Cloth cloth = make_cloth(scene.cloth, scene.simulation.gravity.norm());
  const Points points = start_state(scene.cloth, cloth, scene.simulation.seed).positions;
  for (const ColliderSpec& collider : scene.colliders) {
    if (!collider.enabled || !may_reach(collider, points)) continue;
    const int inside = count_inside(collider, points);
    const int crossed = inside == 0 ? count_crossed(collider, cloth, points) : 0;
    if (inside + crossed == 0) continue;
    const std::string which =
        inside > 0 ? std::to_string(inside) + " of " + std::to_string(points.rows()) + " points"
                   : std::to_string(crossed) + " of " + std::to_string(cloth.triangles.size()) +
                         " triangles";
    lines.push_back(which + " of the cloth start in collider " + collider.name +
                    "; did you mean another " +
                    (!scene.cloth.parts.empty() ? "place in cloths?"
                     : scene.cloth.mesh         ? "cloth.mesh.pose?"
                                                : "cloth.origin?"));
  }
}

}  // namespace

std::vector<std::string> doubts(const YAML::Node& root, const Scene& scene) {
  Lines lines;
  doubt_angles(root, "", lines);
  doubt_size(scene.cloth, lines);
  doubt_start(scene, lines);
  return lines;
}

}  // namespace clothsim
