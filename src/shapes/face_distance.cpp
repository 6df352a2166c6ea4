#include "clothsim/shapes/face_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/geometry/closest_points.h"
#include "face_features.h"

namespace clothsim {
namespace {

// ---- Sphere: its centre

std::optional<FaceDistance> core_distance(const Sphere&, const Triangle& t, double) {
  Closest closest;
  const Weights weights = closest_on_triangle(Vector3::Zero(), t[0], t[1], t[2]);
  closest.add(Vector3::Zero(), t, weights);
  if (closest.least() > 0) return closest.result();
  const Vector3 n = unit_normal(t);
  return FaceDistance{0, n.isZero(0) ? Vector3::UnitZ() : n, weights};
}

// ---- Capsule: its axis

/// How a triangle that the axis passes through gets off it.
FaceDistance way_off(const Vector3& low, const Vector3& high, const Triangle& t) {
  WayOut way;
  const Vector3 n = unit_normal(t);
  for (const Vector3& out : {n, Vector3(-n)}) {
    if (n.isZero(0)) break;
    const Vector3& end = out.dot(high) > out.dot(low) ? high : low;
    way.add(out.dot(end - t[0]), out, closest_on_triangle(end, t[0], t[1], t[2]));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 across = (high - low).cross(edge(t, i));
    const double length = across.norm();
    if (length * length <= parallel * (high - low).squaredNorm() * edge(t, i).squaredNorm()) {
      continue;
    }
    for (const double sign : {-1.0, 1.0}) {
      const Vector3 out = sign / length * across;
      const std::size_t lowest_corner = lowest(t, out);
      const bool is_edge = lowest_corner == i || lowest_corner == (i + 1) % 3;
      const double s = closest_on_segments(t[i], t[(i + 1) % 3], low, high).s;
      way.add(out.dot(low - t[lowest_corner]), out,
              is_edge ? on_edge(i, s) : corner(lowest_corner));
    }
  }
  if (std::isinf(way.shortest().value)) way.add(0, Vector3::UnitX(), corner(0));  // all on a line
  return way.shortest();
}

std::optional<FaceDistance> core_distance(const Capsule& capsule, const Triangle& t, double reach) {
  const Vector3 high(0, 0, capsule.length / 2), low = -high;

  // A box about the triangle tells most that are far.
  const Vector3 least = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
  const Vector3 most = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  const Vector3 beyond = (least - high).cwiseMax(low - most);
  if (beyond.maxCoeff() > reach) return std::nullopt;

  if (passes_through(low, high, t)) {
    FaceDistance way = way_off(low, high, t);
    way.value *= -1;
    return way;
  }
  Closest closest;
  for (const Vector3& end : {low, high}) {
    closest.add(end, t, closest_on_triangle(end, t[0], t[1], t[2]));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const SegmentParameters where = closest_on_segments(t[i], t[(i + 1) % 3], low, high);
    closest.add(low + where.t * (high - low), t, on_edge(i, where.s));
  }
  if (closest.least() > 0) return closest.result();
  FaceDistance way = way_off(low, high, t);  // they just touch
  way.value = 0;
  return way;
}

// ---- Box: its faces, edges and corners

Vector3 box_corner(const Vector3& half, int index) {
  return {index & 1 ? half.x() : -half.x(), index & 2 ? half.y() : -half.y(),
          index & 4 ? half.z() : -half.z()};
}

/// The corner of a box that lies farthest along `direction`.
Vector3 box_corner(const Vector3& half, const Vector3& direction) {
  return {direction.x() < 0 ? -half.x() : half.x(), direction.y() < 0 ? -half.y() : half.y(),
          direction.z() < 0 ? -half.z() : half.z()};
}

/// The shortest way out of a box; not into it, so that the way is negative for a triangle outside.
FaceDistance way_out(const Vector3& half, const Triangle& t) {
  WayOut way;
  const auto try_along = [&](const Vector3& out, std::optional<std::size_t> triangle_edge,
                             int box_axis) {
    const std::size_t low = lowest(t, out);
    const double length = out.cwiseAbs().dot(half) - out.dot(t[low]);
    if (length >= way.shortest().value) return;
    const Vector3 support = box_corner(half, out);
    Weights weights = corner(low);
    if (triangle_edge && (low == *triangle_edge || low == (*triangle_edge + 1) % 3)) {
      Vector3 other = support;
      other[box_axis] *= -1;
      weights = on_edge(
          *triangle_edge,
          closest_on_segments(t[*triangle_edge], t[(*triangle_edge + 1) % 3], support, other).s);
    } else if (!triangle_edge && box_axis < 0) {
      weights = closest_on_triangle(support, t[0], t[1], t[2]);
    }
    way.add(length, out, weights);
  };

  for (int axis = 0; axis < 3; ++axis) {
    try_along(Vector3::Unit(axis), {}, axis);
    try_along(-Vector3::Unit(axis), {}, axis);
  }
  const Vector3 n = unit_normal(t);
  if (!n.isZero(0)) {
    try_along(n, {}, -1);
    try_along(-n, {}, -1);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 across = Vector3::Unit(axis).cross(edge(t, i));
      const double length = across.norm();
      if (length * length <= parallel * edge(t, i).squaredNorm()) continue;
      try_along(across / length, i, axis);
      try_along(-across / length, i, axis);
    }
  }
  return way.shortest();
}

/// How near the edges and corners of a box come to a triangle whose corners lie between `least` and
/// `most`; those farther than `reach` are left out.
Closest to_edges_and_corners(const Vector3& half, const Triangle& t, const Vector3& least,
                             const Vector3& most, double reach) {
  bool near[3][2];  // faces of the box, by axis and side
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, 1}) {
      const double at = side ? half[axis] : -half[axis];
      near[axis][side] = at >= least[axis] - reach && at <= most[axis] + reach;
    }
  }
  Closest closest;
  for (int index = 0; index < 8; ++index) {
    const std::array<int, 3> side{index & 1, (index >> 1) & 1, index >> 2};
    const Vector3 low = box_corner(half, index);
    if (near[0][side[0]] && near[1][side[1]] && near[2][side[2]]) {
      closest.add(low, t, closest_on_triangle(low, t[0], t[1], t[2]));
    }
    // The edges that go up from it.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (side[axis] == 1 || !near[u][side[u]] || !near[v][side[v]]) continue;
      Vector3 high = low;
      high[static_cast<Eigen::Index>(axis)] *= -1;
      for (std::size_t i = 0; i < 3; ++i) {
        const SegmentParameters where = closest_on_segments(t[i], t[(i + 1) % 3], low, high);
        closest.add(low + where.t * (high - low), t, on_edge(i, where.s));
      }
    }
  }
  return closest;
}

/// Does what lies between `least` and `most` reach into the box, or an edge of the box within
/// `reach` of it? There is none where it is between the faces along two axes.
bool is_near_edge(const Vector3& half, const Vector3& least, const Vector3& most, double reach) {
  if ((least - half).cwiseMax(-half - most).maxCoeff() > reach) return false;
  int between = 0;
  bool apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (least[axis] - reach > -half[axis] && most[axis] + reach < half[axis]) ++between;
    apart = apart || least[axis] > half[axis] || most[axis] < -half[axis];
  }
  return between < 2 || !apart;
}

std::optional<FaceDistance> distance(const Cuboid& box, const Triangle& t, double reach) {
  const Vector3 half = box.size / 2;
  const Vector3 least = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
  const Vector3 most = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  const double apart = (least - half).cwiseMax(-half - most).maxCoeff();
  if (apart > reach) return std::nullopt;

  if (apart <= 0) {
    FaceDistance way = way_out(half, t);
    if (way.value >= 0) {
      way.value *= -1;
      return way;
    }
  }

  // The faces of the box bound the corners of the triangle, its edges and corners the rest.
  FaceDistance nearest{std::numeric_limits<double>::infinity(), Vector3::UnitZ(), {1, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Distance d = signed_distance(box, t[i], t[i]);
    if (d.value < nearest.value) nearest = {d.value, d.normal, corner(i)};
  }
  const Closest features = to_edges_and_corners(half, t, least, most, reach);
  if (features.least() <= nearest.value) {
    if (const auto found = features.result()) nearest = *found;
  }
  if (nearest.value > reach) return std::nullopt;
  return nearest;
}

/// Shapes with a core and a radius about it.
template <class Round>
std::optional<FaceDistance> distance(const Round& shape, const Triangle& t, double reach) {
  auto found = core_distance(shape, t, reach + shape.radius);
  if (!found) return std::nullopt;
  found->value -= shape.radius;
  if (found->value > reach) return std::nullopt;
  return found;
}

std::optional<FaceDistance> distance(const Plane&, const Triangle&, double) { return std::nullopt; }

// ---- Straight lines of a shape's core that support it along the normal of `nearest`, as far as
// they may be within `reach` of the triangle: visit(one end, other end, radius about it)

template <class Visit>
void for_each_supporting_line(const Sphere&, const Triangle&, const Vector3&, double, Visit) {}

template <class Visit>
void for_each_supporting_line(const Plane&, const Triangle&, const Vector3&, double, Visit) {}

template <class Visit>
void for_each_supporting_line(const Capsule& capsule, const Triangle&, const Vector3&, double,
                              Visit visit) {
  const Vector3 end(0, 0, capsule.length / 2);
  visit(Vector3(-end), end, capsule.radius);
}

template <class Visit>
void for_each_supporting_line(const Cylinder& cylinder, const Triangle&, const Vector3& normal,
                              double, Visit visit) {
  const Vector3 up(0, 0, cylinder.length / 2);
  const Eigen::Vector2d across = normal.head<2>();
  const double slope = across.norm();
  if (slope > std::abs(normal.z())) {  // its side, along the axis
    const Vector3 out = cylinder.radius / slope * Vector3(across.x(), across.y(), 0);
    visit(Vector3(out - up), Vector3(out + up), 0.0);
    return;
  }
  // An end: two of its diameters.
  const Vector3 end = normal.z() < 0 ? Vector3(-up) : up;
  for (const int axis : {0, 1}) {
    const Vector3 out = cylinder.radius * Vector3::Unit(axis);
    visit(Vector3(end - out), Vector3(end + out), 0.0);
  }
}

template <class Visit>
void for_each_supporting_line(const MeshShape& mesh, const Triangle& t, const Vector3& normal,
                              double reach, Visit visit) {
  constexpr double square = 0.1;  // sine of the angle by which a ridge may be off that
  constexpr double sharp = 0.35;  // a triangle does not lie along ridges that bend less [rad]
  double most = reach + mesh.padding;
  mesh.file->solid.visit_ridges(t, most, [&](const Solid::Ridge& ridge) {
    if (ridge.angle < sharp) return;
    const Vector3 along = ridge.ends[1] - ridge.ends[0];
    if (std::abs(normal.dot(along)) > square * along.norm()) return;
    if (normal.dot(ridge.normal) <= 0) return;
    visit(ridge.ends[0], ridge.ends[1], mesh.padding);
  });
}

template <class Visit>
void for_each_supporting_line(const Cuboid& box, const Triangle&, const Vector3& normal, double,
                              Visit visit) {
  const Vector3 support = box_corner(box.size / 2, normal);
  for (int axis = 0; axis < 3; ++axis) {
    Vector3 other = support;
    other[axis] *= -1;
    visit(support, other, 0.0);
  }
}

// ---- touches_between_corners()

bool may_touch_in(const Sphere& sphere, const Eigen::AlignedBox3d& box, double reach) {
  return box.exteriorDistance(Vector3::Zero().eval()) <= sphere.radius + reach;
}

bool may_touch_in(const Cylinder& cylinder, const Eigen::AlignedBox3d& box, double reach) {
  const Vector3 half(cylinder.radius, cylinder.radius, cylinder.length / 2);
  return (box.min() - half).cwiseMax(-half - box.max()).maxCoeff() <= reach;
}

bool may_touch_in(const Capsule& capsule, const Eigen::AlignedBox3d& box, double reach) {
  const Vector3 high(0, 0, capsule.length / 2), low = -high;
  const Vector3 beyond = (box.min() - high).cwiseMax(low - box.max());
  return beyond.maxCoeff() <= capsule.radius + reach;
}

bool may_touch_in(const Plane&, const Eigen::AlignedBox3d&, double) { return false; }

bool may_touch_in(const Cuboid& cuboid, const Eigen::AlignedBox3d& box, double reach) {
  return is_near_edge(cuboid.size / 2, box.min(), box.max(), reach);
}

bool may_touch_in(const MeshShape& mesh, const Eigen::AlignedBox3d& box, double reach) {
  const double most = reach + mesh.padding;
  return squared_distance(mesh.file->solid.box(), box) <= most * std::abs(most);
}

template <class S>
bool may_touch_between(const S& shape, const Triangle& t, double reach) {
  return may_touch_in(shape, Eigen::AlignedBox3d(t[0]).extend(t[1]).extend(t[2]), reach);
}

}  // namespace

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
  std::visit(
      [&](const auto& s) { for_each_supporting_line(s, t, nearest.normal, farthest, add_line); },
      shape);
  return found;
}

bool touches_between_corners(const Shape& shape, const Triangle& t, double reach) {
  return std::visit([&](const auto& s) { return may_touch_between(s, t, reach); }, shape);
}

bool touches_between_corners(const Shape& shape, const Eigen::AlignedBox3d& box, double reach) {
  return std::visit([&](const auto& s) { return may_touch_in(s, box, reach); }, shape);
}

std::optional<FaceDistance> face_distance(const Shape& shape, const Triangle& triangle,
                                          double reach) {
  return std::visit([&](const auto& s) { return distance(s, triangle, reach); }, shape);
}

}  // namespace clothsim
