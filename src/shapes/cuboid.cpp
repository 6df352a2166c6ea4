#include "clothsim/shapes/cuboid.h"

#include "shape_parts.h"

namespace clothsim {
namespace {

/// The shortest way out of a box; not into it, so that the way is negative for a triangle outside.
FaceDistance shortest_exit(const Cuboid& box, const Triangle& t) {
  const Vector3 half = box.size / 2;
  ShortestExit exit;
  const auto try_along = [&](const Vector3& out, std::optional<std::size_t> on, int axis) {
    const std::size_t low = lowest(t, out);
    const double length = out.cwiseAbs().dot(half) - out.dot(t[low]);
    if (length >= exit.shortest().value) return;
    const Vector3 support = box.support(out);
    if (on) {
      Vector3 other = support;
      other[axis] *= -1;
      exit.add_across(length, out, t, *on, support, other);
    } else {
      exit.add(length, out,
               axis < 0 ? closest_on_triangle(support, t[0], t[1], t[2]) : corner(low));
    }
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
  return exit.shortest();
}

/// Does all of the box lie below the plane through its place nearest to the triangle?
bool is_below_plane(const Vector3& half, const FaceDistance& nearest, const Triangle& t) {
  const double gap =
      nearest.normal.dot(at(t, nearest.weights)) - half.dot(nearest.normal.cwiseAbs());
  return gap >= (1 - turn_tolerance) * nearest.value;
}

/// Distances of the edges and corners of a box from a triangle, up to `reach`.
Closest to_edges_and_corners(const Vector3& half, const Triangle& t, double reach) {
  const Box box = box_of(t);
  bool near[3][2];  // faces of the box, by axis and side
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {0, 1}) {
      const double at = side ? half[axis] : -half[axis];
      near[axis][side] = at >= box.min()[axis] - reach && at <= box.max()[axis] + reach;
    }
  }
  Closest closest;
  for (int index = 0; index < 8; ++index) {
    const std::array<int, 3> side{index & 1, (index >> 1) & 1, index >> 2};
    const Vector3 low = Box(-half, half).corner(static_cast<Box::CornerType>(index));
    if (near[0][side[0]] && near[1][side[1]] && near[2][side[2]]) {
      closest.add(low, t, closest_on_triangle(low, t[0], t[1], t[2]));
    }
    // The edges from this corner towards higher coordinates.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (side[axis] == 1 || !near[u][side[u]] || !near[v][side[v]]) continue;
      Vector3 high = low;
      high[static_cast<Eigen::Index>(axis)] *= -1;
      closest.add_line(low, high, t);
    }
  }
  return closest;
}

}  // namespace

std::optional<double> Cuboid::entry(const Vector3& from, const Vector3& displacement,
                                    double offset) const {
  double in = 0, out = infinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = size[axis] / 2 + offset;
    if (displacement[axis] == 0) {
      if (std::abs(from[axis]) > half) return std::nullopt;
      continue;
    }
    const double towards = displacement[axis] > 0 ? 1 : -1;
    in = std::max(in, (-towards * half - from[axis]) / displacement[axis]);
    out = std::min(out, (towards * half - from[axis]) / displacement[axis]);
  }
  if (in > out) return std::nullopt;
  return in;
}

std::optional<FaceDistance> Cuboid::face_distance(const Triangle& t, double reach) const {
  const Vector3 half = size / 2;
  const double apart = outside(box_of(t), half);
  if (apart > reach) return std::nullopt;

  // Corners of the triangle against faces of the box, then edges and corners of the box.
  std::array<Distance, 3> corners;
  std::transform(t.begin(), t.end(), corners.begin(),
                 [&](const Vector3& p) { return Distance(near_surface(p.x(), p.y(), p.z(), 0)); });
  const double least = min_distance(t, corners);
  if (least > reach) return std::nullopt;
  FaceDistance nearest = nearest_corner(corners);
  const auto exit_from = [](FaceDistance exit) {
    exit.value *= -1;
    return exit;
  };
  if (nearest.value < 0) return exit_from(shortest_exit(*this, t));
  if (is_only_nearest(nearest, t)) return within(reach, nearest);
  const Closest features = to_edges_and_corners(half, t, reach);
  if (features.least() > 0 && features.least() <= nearest.value) nearest = features.result();
  if (apart <= 0 && least <= 0 &&
      !(is_separating(nearest, t) && is_below_plane(half, nearest, t))) {
    const FaceDistance exit = shortest_exit(*this, t);
    if (exit.value >= 0) return exit_from(exit);
  }
  return within(reach, nearest);
}

void Cuboid::visit_lines(const Triangle&, const Vector3& normal, double,
                         const VisitLine& visit) const {
  const Vector3 corner = support(normal);
  for (int axis = 0; axis < 3; ++axis) {
    Vector3 other = corner;
    other[axis] *= -1;
    visit(corner, other, 0);
  }
}

/// Does `box` reach into this box, or come within `reach` of an edge of it? No edge is near where
/// it lies between the faces along two axes.
bool Cuboid::may_touch(const Box& box, const Triangle*, double reach) const {
  const Vector3 half = size / 2;
  if (outside(box, half) > reach) return false;
  int between = 0;
  bool apart = false;
  for (int axis = 0; axis < 3; ++axis) {
    const double least = box.min()[axis], most = box.max()[axis];
    if (least - reach > -half[axis] && most + reach < half[axis]) ++between;
    apart = apart || least > half[axis] || most < -half[axis];
  }
  return between < 2 || !apart;
}

}  // namespace clothsim
