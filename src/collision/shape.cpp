#include "clothsim/collision/shape.h"

#include <cmath>
#include <limits>

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Distance distance(const Sphere& sphere, const Vector3& point, const Vector3&) {
  const double r = point.norm();
  return {r - sphere.radius, r > 0 ? Vector3(point / r) : Vector3::UnitZ()};
}

Distance distance(const Plane& plane, const Vector3& point, const Vector3& side) {
  const double sign = plane.two_sided && side.z() < 0 ? -1 : 1;
  return {sign * point.z(), sign * Vector3::UnitZ()};
}

std::optional<Vector3> entry(const Sphere& sphere, const Vector3& from, const Vector3& to,
                             double offset) {
  // |from + t d| = R, the smaller root.
  const Vector3 d = to - from;
  const double radius = sphere.radius + offset;
  const double a = d.squaredNorm();
  const double b = from.dot(d);
  const double c = from.squaredNorm() - radius * radius;
  const double discriminant = b * b - a * c;
  if (b >= 0 || discriminant < 0 || from.norm() < sphere.radius) return std::nullopt;
  if (c <= 0) return from;
  const double t = c / (-b + std::sqrt(discriminant));
  if (t > 1) return std::nullopt;
  return from + t * d;
}

std::optional<Vector3> entry(const Plane&, const Vector3&, const Vector3&, double) {
  return std::nullopt;
}

}  // namespace

Distance signed_distance(const Shape& shape, const Vector3& point, const Vector3& side) {
  return std::visit([&](const auto& s) { return distance(s, point, side); }, shape);
}

std::optional<Vector3> entry_point(const Shape& shape, const Vector3& from, const Vector3& to,
                                   double offset) {
  return std::visit([&](const auto& s) { return entry(s, from, to, offset); }, shape);
}

double safe_depth(const Shape& shape) {
  const Sphere* sphere = std::get_if<Sphere>(&shape);
  return sphere ? sphere->radius / 2 : infinity;
}

double bounding_radius(const Shape& shape) {
  const Sphere* sphere = std::get_if<Sphere>(&shape);
  return sphere ? sphere->radius : infinity;
}

}  // namespace clothsim
