#include "clothsim/shapes/face_distance.h"

#include <algorithm>

#include "shape_parts.h"

namespace clothsim {

std::array<std::optional<FaceDistance>, 3> edges_along(const Shape& shape, const Triangle& t,
                                                       const FaceDistance& nearest, double reach) {
  std::array<std::optional<FaceDistance>, 3> found;
  const double farthest = reach + 2 * std::max(0.0, -nearest.value);
  const auto add_line = [&](const Vector3& low, const Vector3& high, double radius) {
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t[i], t[(i + 1) % 3], low, high);
      if (where.s <= 0 || where.s >= 1) continue;
      const Weights weights = on_edge(i, where.s);
      const Vector3 gap = at(t, weights) - low - where.t * (high - low);
      if (gap.norm() - radius > farthest) continue;
      const double value = nearest.normal.dot(gap) - radius;
      if (found[i] && found[i]->value <= value) continue;
      found[i] = FaceDistance{value, nearest.normal, weights};
    }
  };
  std::visit([&](const auto& s) { s.visit_lines(t, nearest.normal, farthest, std::ref(add_line)); },
             shape);
  return found;
}

bool touches_between_corners(const Shape& shape, const Triangle& t, double reach,
                             const FaceQuery& query) {
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) {
    return mesh->may_touch(box_of(t), &t, reach, query);
  }
  return std::visit([&](const auto& s) { return s.may_touch(box_of(t), &t, reach); }, shape);
}

bool touches_between_corners(const Shape& shape, const Box& box, double reach) {
  return std::visit([&](const auto& s) { return s.may_touch(box, nullptr, reach); }, shape);
}

std::optional<FaceDistance> face_distance(const Shape& shape, const Triangle& t, double reach,
                                          const FaceQuery& query) {
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) {
    return mesh->face_distance(t, reach, query);
  }
  return std::visit([&](const auto& s) { return s.face_distance(t, reach); }, shape);
}

}  // namespace clothsim
