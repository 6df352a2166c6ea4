#include "clothsim/shapes/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "near_surface.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// ---- Share of the way `from` -> `from` + d after which a point is within offset, if it ever is

/// Smaller root of a t^2 + 2 b t + c, where c > 0: empty where there is none ahead.
std::optional<double> first_root(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (b >= 0 || discriminant < 0) return std::nullopt;
  return c / (-b + std::sqrt(discriminant));
}

std::optional<double> hit(const Sphere& sphere, const Vector3& from, const Vector3& d,
                          double offset) {
  const double radius = sphere.radius + offset;
  return first_root(d.squaredNorm(), from.dot(d), from.squaredNorm() - radius * radius);
}

std::optional<double> hit(const Plane&, const Vector3&, const Vector3&, double) {
  return std::nullopt;
}

std::optional<double> hit(const Capsule& capsule, const Vector3& from, const Vector3& d,
                          double offset) {
  const double radius = capsule.radius + offset;
  std::optional<double> first;
  const auto take = [&](std::optional<double> t) {
    if (t && (!first || *t < *first)) first = t;
  };
  // Its round ends, and between them the cylinder.
  for (const double end : {-capsule.length / 2, capsule.length / 2}) {
    take(hit(Sphere{capsule.radius}, from - Vector3(0, 0, end), d, offset));
  }
  const Eigen::Vector2d from2 = from.head<2>(), d2 = d.head<2>();
  const double c = from2.squaredNorm() - radius * radius;
  if (c > 0) {
    const auto t = first_root(d2.squaredNorm(), from2.dot(d2), c);
    if (t && std::abs(from.z() + *t * d.z()) <= capsule.length / 2) take(t);
  }
  return first;
}

std::optional<double> hit(const Cuboid& box, const Vector3& from, const Vector3& d, double offset) {
  double in = 0, out = infinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = box.size[axis] / 2 + offset;
    if (d[axis] == 0) {
      if (std::abs(from[axis]) > half) return std::nullopt;
      continue;
    }
    const double towards = d[axis] > 0 ? 1 : -1;
    in = std::max(in, (-towards * half - from[axis]) / d[axis]);
    out = std::min(out, (towards * half - from[axis]) / d[axis]);
  }
  if (in > out) return std::nullopt;
  return in;
}

std::optional<double> hit(const Cylinder& cylinder, const Vector3& from, const Vector3& d,
                          double offset) {
  double in = 0, out = infinity;
  const auto keep_within = [&](double first, double last) {
    in = std::max(in, first);
    out = std::min(out, last);
  };
  const double half = cylinder.length / 2 + offset, radius = cylinder.radius + offset;
  if (d.z() != 0) {
    const double a = (-half - from.z()) / d.z(), b = (half - from.z()) / d.z();
    keep_within(std::min(a, b), std::max(a, b));
  } else if (std::abs(from.z()) > half) {
    return std::nullopt;
  }
  const Eigen::Vector2d from2 = from.head<2>(), d2 = d.head<2>();
  const double a = d2.squaredNorm(), b = from2.dot(d2), c = from2.squaredNorm() - radius * radius;
  const double discriminant = b * b - a * c;
  if (a > 0 && discriminant >= 0) {
    const double root = std::sqrt(discriminant);
    keep_within((-b - root) / a, (-b + root) / a);
  } else if (c > 0) {
    return std::nullopt;
  }
  if (in > out) return std::nullopt;
  return in;
}

std::optional<double> hit(const MeshShape& mesh, const Vector3& from, const Vector3& d,
                          double offset) {
  constexpr double near = 1.05;    // of the offset: there it has come in
  constexpr int most_steps = 300;  // then it grazes, and is stopped where it is
  const double way = d.norm();
  double share = 0;
  for (int step = 0; step < most_steps && share <= 1; ++step) {
    const Vector3 p = from + share * d;
    const NearSurface here = near_surface(mesh, p.x(), p.y(), p.z(), 0);
    const bool nears = here.x * d.x() + here.y * d.y() + here.z * d.z() < 0;
    if (here.value <= near * offset && nears) return share;
    share += std::max(here.value - offset, near / 2 * offset) / way;
  }
  if (share > 1) return std::nullopt;
  return share;
}

/// Does a distance along a line have no second minimum? What moves away does not come back.
template <class Convex>
bool is_convex(const Convex&) {
  return true;
}
bool is_convex(const MeshShape&) { return false; }

double depth(const Sphere& sphere) { return sphere.radius / 2; }
double depth(const Plane&) { return infinity; }
double depth(const Capsule& capsule) { return capsule.radius / 2; }
double depth(const Cuboid& box) { return box.size.minCoeff() / 4; }
double depth(const Cylinder& cylinder) {
  return std::min(cylinder.radius, cylinder.length / 2) / 2;
}
double depth(const MeshShape& mesh) { return mesh.file->solid.thickness() / 4; }

double bounds(const Sphere& sphere) { return sphere.radius; }
double bounds(const Plane&) { return infinity; }
double bounds(const Capsule& capsule) { return capsule.length / 2 + capsule.radius; }
double bounds(const Cuboid& box) { return box.size.norm() / 2; }
double bounds(const Cylinder& cylinder) { return std::hypot(cylinder.length / 2, cylinder.radius); }

double bounds(const MeshShape& mesh) { return mesh.file->solid.radius() + mesh.padding; }

// ---- How far from a surface the corners of flat triangles are to be

/// A triangle lies within edge / sqrt(3) of its circumcentre.
double corners_off_round(double radius, double edge, double offset) {
  const double kept = radius + offset;
  return std::sqrt(kept * kept + edge * edge / 3) - radius;
}

double corners_off(const Sphere& sphere, double edge, double offset) {
  return corners_off_round(sphere.radius, edge, offset);
}
double corners_off(const Plane&, double, double offset) { return offset; }
double corners_off(const Capsule& capsule, double edge, double offset) {
  return corners_off_round(capsule.radius, edge, offset);
}
double corners_off(const Cuboid&, double, double) { return infinity; }
double corners_off(const Cylinder&, double, double) { return infinity; }
double corners_off(const MeshShape& mesh, double edge, double offset) {
  return offset + mesh.file->solid.dip(edge);
}

}  // namespace

Distance signed_distance(const Shape& shape, const Vector3& point, const Vector3& side) {
  const NearSurface near = std::visit(
      [&](const auto& s) { return near_surface(s, point.x(), point.y(), point.z(), side.z()); },
      shape);
  return {near.value, {near.x, near.y, near.z}};
}

std::optional<Vector3> entry_point(const Shape& shape, const Vector3& from, const Vector3& to,
                                   double offset) {
  if (std::isinf(safe_depth(shape))) return std::nullopt;  // it has no far side
  const Distance start = signed_distance(shape, from, from);
  const Vector3 d = to - from;
  if (start.value < 0) return std::nullopt;
  const bool nears = start.normal.dot(d) < 0;
  if (nears && start.value <= offset) return from;
  if (!nears && std::visit([](const auto& s) { return is_convex(s); }, shape)) return std::nullopt;
  const auto t = std::visit([&](const auto& s) { return hit(s, from, d, offset); }, shape);
  if (!t || *t > 1) return std::nullopt;
  return from + *t * d;
}

double safe_depth(const Shape& shape) {
  return std::visit([](const auto& s) { return depth(s); }, shape);
}

double corner_distance(const Shape& shape, double edge, double offset) {
  return std::visit([&](const auto& s) { return corners_off(s, edge, offset); }, shape);
}

double bounding_radius(const Shape& shape) {
  return std::visit([](const auto& s) { return bounds(s); }, shape);
}

}  // namespace clothsim
