// Building blocks of shapes' queries.
#pragma once

#include <algorithm>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

using Weights = std::array<double, 3>;

/// Limit on the steps towards a surface. Each comes nearer by at least half the offset, so only a
/// grazing point takes so many steps; it is stopped there.
inline constexpr int max_approaches = 300;

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

/// Is corner j one of the ends of the edge from corner i?
inline bool is_end(std::size_t j, std::size_t i) { return j == i || j == (i + 1) % 3; }

inline Vector3 edge(const Triangle& t, std::size_t i) { return t[(i + 1) % 3] - t[i]; }

inline Box box_of(const Triangle& t) { return Box(t[0]).extend(t[1]).extend(t[2]); }

/// Distance between a box and a box about the origin, along the axis where it is largest [m];
/// negative: they overlap.
inline double outside(const Box& box, const Vector3& half) {
  return (box.min() - half).cwiseMax(-half - box.max()).maxCoeff();
}

/// The corner that lies farthest against `direction`.
inline std::size_t lowest(const Triangle& t, const Vector3& direction) {
  const double a = direction.dot(t[0]), b = direction.dot(t[1]), c = direction.dot(t[2]);
  if (a <= b && a <= c) return 0;
  return b <= c ? 1 : 2;
}

/// Smaller root of a t^2 + 2 b t + c, where c > 0: empty unless it is positive.
inline std::optional<double> first_root(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (b >= 0 || discriminant < 0) return std::nullopt;
  return c / (-b + std::sqrt(discriminant));
}

/// Turns a distance from a core into one from all points within `radius` of the core; empty beyond
/// `reach`.
inline std::optional<FaceDistance> within(double reach, FaceDistance found, double radius = 0) {
  found.value -= radius;
  if (found.value > reach) return std::nullopt;
  return found;
}

/// Where a triangle's corners have these distances, the nearest corner.
inline FaceDistance nearest_corner(const std::array<Distance, 3>& at) {
  FaceDistance nearest;
  for (std::size_t i = 0; i < 3; ++i) {
    if (at[i].value < nearest.value) nearest = {at[i].value, at[i].normal, corner(i)};
  }
  return nearest;
}

/// A bound on the signed distances of a triangle's points from a convex shape, from the tangents at
/// its corners.
inline double min_distance(const Triangle& t, const std::array<Distance, 3>& at) {
  double bound = -infinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3& n = at[i].normal;
    const double least = std::min({n.dot(t[0]), n.dot(t[1]), n.dot(t[2])});
    bound = std::max(bound, at[i].value + least - n.dot(t[i]));
  }
  return bound;
}

/// A search along an edge ends where the normal is as near to perpendicular to the edge [rad].
inline constexpr double turn_tolerance = 1e-9;

/// Does the tangent plane of a convex shape at the nearest point so far have the shape and the
/// triangle on its two sides? Then no other point is nearer.
inline bool is_separating(const FaceDistance& nearest, const Triangle& t) {
  const double height = nearest.normal.dot(at(t, nearest.weights)) - turn_tolerance * nearest.value;
  return nearest.value > 0 && std::all_of(t.begin(), t.end(), [&](const Vector3& corner) {
           return nearest.normal.dot(corner) >= height;
         });
}

/// Is the nearest corner nearer than all other points of the triangle? One that lies flat on a face
/// of a box touches edges and corners of the box, too.
inline bool is_only_nearest(const FaceDistance& corner, const Triangle& t) {
  const double height = corner.normal.dot(at(t, corner.weights));
  const auto higher = std::count_if(t.begin(), t.end(), [&](const Vector3& p) {
    return corner.normal.dot(p) > height + turn_tolerance * corner.value;
  });
  return corner.value > 0 && higher == 2;
}

/// The least of distances between features, and where it is.
class Closest {
 public:
  /// Adds the pair of `p` of the shape and the point of the triangle with these weights.
  void add(const Vector3& p, const Triangle& t, const Weights& weights) {
    const Vector3 gap = at(t, weights) - p;
    const double distance = gap.norm();
    if (distance >= found_.value) return;
    found_ = {distance, gap / distance, weights};
  }

  /// Adds a straight line of the shape against the triangle's edges.
  void add_line(const Vector3& low, const Vector3& high, const Triangle& t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t[i], t[(i + 1) % 3], low, high);
      add(low + where.t * (high - low), t, on_edge(i, where.s));
    }
  }

  double least() const { return found_.value; }

  /// Valid where the distance is not 0.
  const FaceDistance& result() const { return found_; }

 private:
  FaceDistance found_;
};

/// The shortest of the ways along which a triangle may leave a polyhedron.
class ShortestExit {
 public:
  /// `out` [m] is the way along the unit vector `direction`, negative where the triangle is out
  /// already.
  void add(double out, const Vector3& direction, const Weights& weights) {
    if (out >= shortest_.value) return;
    shortest_ = {out, direction, weights};
  }

  /// `out` is perpendicular to the edge from corner i and to the straight line a -> b of the shape.
  void add_across(double length, const Vector3& out, const Triangle& t, std::size_t i,
                  const Vector3& a, const Vector3& b) {
    const std::size_t low = lowest(t, out);
    const auto share = [&] { return closest_on_segments(t[i], t[(i + 1) % 3], a, b).s; };
    add(length, out, is_end(low, i) ? on_edge(i, share()) : corner(low));
  }

  /// `value` is the way's length.
  const FaceDistance& shortest() const { return shortest_; }

 private:
  FaceDistance shortest_;
};

/// Unit normal of a triangle, zero where it has no area.
inline Vector3 unit_normal(const Triangle& t) {
  const Vector3 e = edge(t, 0), f = edge(t, 1), n = e.cross(f);
  const double length = n.norm();
  return length * length > parallel * e.squaredNorm() * f.squaredNorm() ? Vector3(n / length)
                                                                        : Vector3::Zero();
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

}  // namespace clothsim
