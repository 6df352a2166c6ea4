#pragma once

#include <array>
#include <cstddef>

namespace clothsim {

/// Distances of sixteen pairs at once, side by side in single precision. They are never more than
/// they are, but for rounding of the places given.
struct DistanceRows {
  enum : std::size_t { size = 16 };
  using Row = std::array<float, size>;
  using Points = std::array<Row, 3>;    // by axis [m]
  using Hulls = std::array<Points, 4>;  // of four points each

  /// Of points a to triangles b, c, d [m], and the least barycentric coordinate of a.
  static void point_triangle(const Points& a, const Points& b, const Points& c, const Points& d,
                             Row& distances, Row& within);

  /// Of edges a -> b to c -> d [m].
  static void edge_edge(const Points& a, const Points& b, const Points& c, const Points& d,
                        Row& distances);

  /// Of point `number` of a to those of b [m].
  static void point_point(const Points& a, std::size_t number, const Points& b, Row& distances);

  /// Of hull `number` of a to those of b [m], by planes square to the line between their centres.
  static void hull_hull(const Hulls& a, std::size_t number, const Hulls& b, Row& distances);
};

}  // namespace clothsim
