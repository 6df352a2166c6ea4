#include "clothsim/shapes/capsule.h"

#include "shape_parts.h"

namespace clothsim {
namespace {

/// The shortest way off the axis for a triangle that the axis passes through.
FaceDistance shortest_exit(const Vector3& low, const Vector3& high, const Triangle& t) {
  ShortestExit exit;
  const Vector3 n = unit_normal(t);
  for (const Vector3& out : {n, Vector3(-n)}) {
    if (n.isZero(0)) break;
    const Vector3& end = out.dot(high) > out.dot(low) ? high : low;
    exit.add(out.dot(end - t[0]), out, closest_on_triangle(end, t[0], t[1], t[2]));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 across = (high - low).cross(edge(t, i));
    const double length = across.norm();
    if (length * length <= parallel * (high - low).squaredNorm() * edge(t, i).squaredNorm()) {
      continue;
    }
    for (const double sign : {-1.0, 1.0}) {
      const Vector3 out = sign / length * across;
      exit.add_across(out.dot(low - t[lowest(t, out)]), out, t, i, low, high);
    }
  }
  if (std::isinf(exit.shortest().value)) exit.add(0, Vector3::UnitX(), corner(0));  // all on a line
  return exit.shortest();
}

}  // namespace

std::optional<double> Capsule::entry(const Vector3& from, const Vector3& displacement,
                                     double offset) const {
  std::optional<double> first;
  const auto take = [&](std::optional<double> t) {
    if (t && (!first || *t < *first)) first = t;
  };
  // The round ends, and the cylinder between them.
  for (const double end : {-length / 2, length / 2}) {
    take(Sphere{radius}.entry(from - Vector3(0, 0, end), displacement, offset));
  }
  const double kept = radius + offset;
  const Eigen::Vector2d from2 = from.head<2>(), along2 = displacement.head<2>();
  const double c = from2.squaredNorm() - kept * kept;
  if (c > 0) {
    const auto t = first_root(along2.squaredNorm(), from2.dot(along2), c);
    if (t && std::abs(from.z() + *t * displacement.z()) <= length / 2) take(t);
  }
  return first;
}

std::optional<FaceDistance> Capsule::face_distance(const Triangle& t, double reach) const {
  const Vector3 high(0, 0, length / 2), low = -high;
  // Quick rejection by the triangle's box.
  if (outside(box_of(t), high) > reach + radius) return std::nullopt;
  if (passes_through(low, high, t)) {
    FaceDistance exit = shortest_exit(low, high, t);
    exit.value *= -1;
    return within(reach, exit, radius);
  }
  Closest closest;
  for (const Vector3& end : {low, high}) {
    closest.add(end, t, closest_on_triangle(end, t[0], t[1], t[2]));
  }
  closest.add_line(low, high, t);
  if (closest.least() > 0) return within(reach, closest.result(), radius);
  FaceDistance exit = shortest_exit(low, high, t);  // they just touch
  exit.value = 0;
  return within(reach, exit, radius);
}

bool Capsule::may_touch(const Box& box, const Triangle*, double reach) const {
  return outside(box, {0, 0, length / 2}) <= radius + reach;
}

}  // namespace clothsim
