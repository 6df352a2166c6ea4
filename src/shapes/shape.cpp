#include "clothsim/shapes/shape.h"

namespace clothsim {

Distance signed_distance(const Shape& shape, const Vector3& point, const Vector3& side) {
  return std::visit(
      [&](const auto& s) { return s.near_surface(point.x(), point.y(), point.z(), side.z()); },
      shape);
}

std::optional<Vector3> entry_point(const Shape& shape, const Vector3& from, const Vector3& to,
                                   double offset) {
  if (std::isinf(safe_depth(shape))) return std::nullopt;  // a plane has no far side
  const Distance start = signed_distance(shape, from, from);
  const Vector3 displacement = to - from;
  if (start.value < 0) return std::nullopt;
  const bool nears = start.normal.dot(displacement) < 0;
  if (nears && start.value <= offset) return from;
  if (!nears && std::visit([](const auto& s) { return s.is_convex; }, shape)) return std::nullopt;
  const auto share =
      std::visit([&](const auto& s) { return s.entry(from, displacement, offset); }, shape);
  if (!share || *share > 1) return std::nullopt;
  return from + *share * displacement;
}

double safe_depth(const Shape& shape) {
  return std::visit([](const auto& s) { return s.safe_depth(); }, shape);
}

double corner_distance(const Shape& shape, double edge, double offset) {
  return std::visit([&](const auto& s) { return s.corner_distance(edge, offset); }, shape);
}

bool is_convex_solid(const Shape& shape) {
  return std::visit([](const auto& s) { return is_convex_solid_v<decltype(s)>; }, shape);
}

std::optional<Vector3> support(const Shape& shape, const Vector3& direction) {
  return std::visit(
      [&](const auto& s) -> std::optional<Vector3> {
        if constexpr (is_convex_solid_v<decltype(s)>) return s.support(direction);
        return std::nullopt;
      },
      shape);
}

double bounding_radius(const Shape& shape) {
  return std::visit([](const auto& s) { return s.bounding_radius(); }, shape);
}

}  // namespace clothsim
