#pragma once

#include <array>
#include <cstddef>

namespace clothsim {

/// Distances of sixteen pairs at once, in single precision. Each is a lower bound of the true
/// distance, but for the rounding of the positions given.
struct DistanceRows {
  enum : std::size_t { size = 16 };
  using Row = std::array<float, size>;
  using Points = std::array<Row, 3>;    // by axis [m]
  using Hulls = std::array<Points, 4>;  // of four points each

  /// Points a and triangles b, c, d [m]: distances, and the least barycentric coordinate of a.
  static void point_triangle(const Points& a, const Points& b, const Points& c, const Points& d,
                             Row& distances, Row& within);

  /// Edges a -> b and c -> d [m].
  static void edge_edge(const Points& a, const Points& b, const Points& c, const Points& d,
                        Row& distances);

  /// Point `number` of a and the points of b [m].
  static void point_point(const Points& a, std::size_t number, const Points& b, Row& distances);

  /// Hull `number` of a and the hulls of b [m], by planes perpendicular to the line between their
  /// centres.
  static void hull_hull(const Hulls& a, std::size_t number, const Hulls& b, Row& distances);
};

}  // namespace clothsim
