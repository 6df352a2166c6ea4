#include "clothsim/geometry/distance_rows.h"

#include <cmath>
#include <limits>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Bound for parallel directions, and for the error of squared lengths: more than some ten
/// roundings of products of the same size.
constexpr float row_rounding = 16 * std::numeric_limits<float>::epsilon();
constexpr float tiny = std::numeric_limits<float>::min();

inline float to_unit(float t) { return smaller(larger(t, 0.0F), 1.0F); }
inline float root(float squared) { return std::sqrt(larger(squared, 0.0F)); }

struct Vector {
  float x, y, z;
};
inline float dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector at(const DistanceRows::Points& points, std::size_t k) {
  return {points[0][k], points[1][k], points[2][k]};
}

}  // namespace

/// The least distance from the triangle's edges, or from its plane where the projection lies
/// within. All terms come from dot products of vectors from b.
CLOTHSIM_TARGET_CLONES
void DistanceRows::point_triangle(const Points& a, const Points& b, const Points& c,
                                  const Points& d, Row& distances, Row& within) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const Vector from = at(b, k), u = at(c, k) - from, v = at(d, k) - from, w = at(a, k) - from;
    const float uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ww = dot(w, w), uw = dot(u, w),
                vw = dot(v, w);

    const float per_uu = 1 / (uu + tiny);
    const float s = to_unit(uw * per_uu);
    const float t = to_unit(vw / (vv + tiny));
    const float ee = uu - 2 * uv + vv, ew = vw - uw - uv + uu;
    const float r = to_unit(ew / (ee + tiny));
    const float on_u = ww - 2 * s * uw + s * s * uu;
    const float on_v = ww - 2 * t * vw + t * t * vv;
    const float on_e = ww - 2 * uw + uu - 2 * r * ew + r * r * ee;
    const float on_edges = smaller(on_u, smaller(on_v, on_e));

    const float area2 = uu * vv - uv * uv;
    const float share = 1 / (area2 + tiny);
    const float of_c = (uw * vv - vw * uv) * share;
    const float of_d = (vw * uu - uw * uv) * share;
    const float least = smaller(smaller(of_c, of_d), 1 - of_c - of_d);
    const float thinness = uu * vv * share;
    const float on_plane = ww - (of_c * uw + of_d * vw);
    // The rounding of on_plane grows in thin triangles; there the edges bound the distance, which
    // differs from theirs by at most the triangle's height.
    const float inside = larger(on_plane - row_rounding * thinness * ww, on_edges - area2 * per_uu);
    const bool is_within = (least >= 0) & (area2 > row_rounding * uu * vv);
    const float squared = is_within ? inside : on_edges;
    distances[k] = root(squared - row_rounding * (uu + vv + ww));
    within[k] = least;
  }
}

CLOTHSIM_TARGET_CLONES
void DistanceRows::point_point(const Points& a, std::size_t number, const Points& b,
                               Row& distances) {
  const Vector of_a = at(a, number);
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const Vector difference = at(b, k) - of_a;
    distances[k] = root((1 - row_rounding) * dot(difference, difference));
  }
}

/// Parallel edges count as near as a slight rotation would bring them.
CLOTHSIM_TARGET_CLONES
void DistanceRows::edge_edge(const Points& a, const Points& b, const Points& c, const Points& d,
                             Row& distances) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const Vector from_a = at(a, k), from_c = at(c, k), u = at(b, k) - from_a, v = at(d, k) - from_c,
                 w = from_a - from_c;
    const float uu = dot(u, u) + tiny, vv = dot(v, v) + tiny, uv = dot(u, v), uw = dot(u, w),
                vw = dot(v, w), ww = dot(w, w);
    const float area2 = uu * vv - uv * uv;
    const bool crossing = area2 > row_rounding * uu * vv;
    const float free = crossing ? to_unit((uv * vw - uw * vv) / (area2 + tiny)) : 0.0F;
    const float t = to_unit((uv * free + vw) / vv);
    const float s = to_unit((uv * t - uw) / uu);
    const Vector difference{w.x + s * u.x - t * v.x, w.y + s * u.y - t * v.y,
                            w.z + s * u.z - t * v.z};
    const float turn = root(crossing ? 0.0F : row_rounding * (uu + vv));
    const float distance = root(dot(difference, difference) - row_rounding * (uu + vv + ww)) - turn;
    distances[k] = larger(distance, 0.0F);
  }
}

CLOTHSIM_TARGET_CLONES
void DistanceRows::hull_hull(const Hulls& a, std::size_t number, const Hulls& b, Row& distances) {
  const Vector from = at(a[0], number);
  const Vector a1 = at(a[1], number) - from, a2 = at(a[2], number) - from,
               a3 = at(a[3], number) - from;
#pragma GCC ivdep
  for (std::size_t k = 0; k < size; ++k) {
    const Vector b0 = at(b[0], k) - from, b1 = at(b[1], k) - from, b2 = at(b[2], k) - from,
                 b3 = at(b[3], k) - from;
    const Vector difference{b0.x + b1.x + b2.x + b3.x - a1.x - a2.x - a3.x,
                            b0.y + b1.y + b2.y + b3.y - a1.y - a2.y - a3.y,
                            b0.z + b1.z + b2.z + b3.z - a1.z - a2.z - a3.z};
    const float highest =
        larger(larger(0.0F, dot(difference, a1)), larger(dot(difference, a2), dot(difference, a3)));
    const float lowest = smaller(smaller(dot(difference, b0), dot(difference, b1)),
                                 smaller(dot(difference, b2), dot(difference, b3)));
    distances[k] = larger((lowest - highest) / (root(dot(difference, difference)) + tiny), 0.0F);
  }
}

}  // namespace clothsim
