// What the distances between a triangle and shapes are put together from.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {

using Weights = std::array<double, 3>;

/// Square of the sine below which two edges are parallel and have no common normal.
inline constexpr double parallel = 1e-12;

inline Vector3 at(const Triangle& t, const Weights& w) {
  return w[0] * t[0] + w[1] * t[1] + w[2] * t[2];
}

inline Weights corner(std::size_t i) {
  Weights w{0, 0, 0};
  w[i] = 1;
  return w;
}

/// A share `s` of the way along the edge from corner i.
inline Weights on_edge(std::size_t i, double s) {
  Weights w{0, 0, 0};
  w[i] = 1 - s;
  w[(i + 1) % 3] = s;
  return w;
}

inline Vector3 edge(const Triangle& t, std::size_t i) { return t[(i + 1) % 3] - t[i]; }

/// The least of distances between features, and its place.
class Closest {
 public:
  /// `p` of the shape is near to the point of the triangle with these weights.
  void add(const Vector3& p, const Triangle& t, const Weights& weights) {
    const Vector3 gap = at(t, weights) - p;
    const double distance = gap.norm();
    if (distance >= least_) return;
    least_ = distance;
    gap_ = gap;
    weights_ = weights;
  }

  double least() const { return least_; }

  /// Where it is not nil.
  std::optional<FaceDistance> result() const {
    if (least_ == 0 || std::isinf(least_)) return std::nullopt;
    return FaceDistance{least_, gap_ / least_, weights_};
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  Vector3 gap_{0, 0, 0};
  Weights weights_{1, 0, 0};
};

/// Of directions along which a triangle may leave a polyhedron, the shortest way.
class WayOut {
 public:
  /// `out` [m] is the way along the unit vector `direction`, negative where it is already out.
  void add(double out, const Vector3& direction, const Weights& weights) {
    if (out >= shortest_.value) return;
    shortest_ = {out, direction, weights};
  }

  /// `value` is the way's length.
  const FaceDistance& shortest() const { return shortest_; }

 private:
  FaceDistance shortest_{std::numeric_limits<double>::infinity(), Vector3::UnitZ(), {1, 0, 0}};
};

/// Unit normal of a triangle, zero where it has no area.
inline Vector3 unit_normal(const Triangle& t) {
  const Vector3 e = edge(t, 0), f = edge(t, 1), n = e.cross(f);
  const double length = n.norm();
  return length * length > parallel * e.squaredNorm() * f.squaredNorm() ? Vector3(n / length)
                                                                        : Vector3::Zero();
}

/// The corner that lies farthest against `direction`.
inline std::size_t lowest(const Triangle& t, const Vector3& direction) {
  const double a = direction.dot(t[0]), b = direction.dot(t[1]), c = direction.dot(t[2]);
  if (a <= b && a <= c) return 0;
  return b <= c ? 1 : 2;
}

/// Does the segment pass through the inside of the triangle?
inline bool passes_through(const Vector3& low, const Vector3& high, const Triangle& t) {
  const Vector3 n = edge(t, 0).cross(edge(t, 1));
  const double a = n.dot(low - t[0]), b = n.dot(high - t[0]);
  if ((a > 0) == (b > 0) || a == b) return false;
  const Vector3 p = low + a / (a - b) * (high - low);
  for (std::size_t i = 0; i < 3; ++i) {
    if (n.dot(edge(t, i).cross(p - t[i])) < 0) return false;
  }
  return true;
}

/// face_distance() of the shapes that have files of their own.
std::optional<FaceDistance> distance(const Cylinder&, const Triangle&, double reach);
std::optional<FaceDistance> distance(const MeshShape&, const Triangle&, double reach);

/// touches_between_corners() of a mesh.
bool may_touch_between(const MeshShape&, const Triangle&, double reach);

}  // namespace clothsim
