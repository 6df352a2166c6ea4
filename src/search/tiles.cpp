#include "clothsim/search/tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr std::size_t n = TileShapes::tiles;
constexpr float epsilon = std::numeric_limits<float>::epsilon();

/// Of directions that count as parallel, and of squared lengths: more than some ten roundings of
/// products of the same size.
constexpr float rounding = 16 * epsilon;
constexpr float tiny = std::numeric_limits<float>::min();

inline float to_unit(float t) { return smaller(larger(t, 0.0F), 1.0F); }
inline float root(float squared) { return std::sqrt(larger(squared, 0.0F)); }

struct Vector {
  float x, y, z;
};
inline float dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

using Row = TileShapes::Row;
using Corner = TileShapes::Corner;
using Corners = TileShapes::Corners;
inline Vector at(const Corner& corner, std::size_t k) {
  return {corner[0][k], corner[1][k], corner[2][k]};
}
inline Vector between(const Corner& from, const Corner& to, std::size_t k) {
  return {to[0][k] - from[0][k], to[1][k] - from[1][k], to[2][k] - from[2][k]};
}

/// Of points a to triangles b, c, d: the least to its edges, or to its plane where that is within.
/// All from the products of the ways from b.
CLOTHSIM_TARGET_CLONES
void point_triangle(const Corner& a, const Corner& b, const Corner& c, const Corner& d, Row& values,
                    Row& within) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < n; ++k) {
    const Vector u = between(b, c, k), v = between(b, d, k), w = between(b, a, k);
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
    // In thin triangles the first one's rounding grows, and edges are no farther than their height.
    const float inside = larger(on_plane - rounding * thinness * ww, on_edges - area2 * per_uu);
    const bool is_within = (least >= 0) & (area2 > rounding * uu * vv);
    const float squared = is_within ? inside : on_edges;
    values[k] = root(squared - rounding * (uu + vv + ww));
    within[k] = least;
  }
}

/// Of edges a -> b to c -> d. Parallel ones are taken to be as near as a slight turn makes them.
CLOTHSIM_TARGET_CLONES
void edge_edge(const Corner& a, const Corner& b, const Corner& c, const Corner& d, Row& values) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < n; ++k) {
    const Vector u = between(a, b, k), v = between(c, d, k), w = between(c, a, k);
    const float uu = dot(u, u) + tiny, vv = dot(v, v) + tiny, uv = dot(u, v), uw = dot(u, w),
                vw = dot(v, w), ww = dot(w, w);
    const float area2 = uu * vv - uv * uv;
    const bool crossing = area2 > rounding * uu * vv;
    const float free = crossing ? to_unit((uv * vw - uw * vv) / (area2 + tiny)) : 0.0F;
    const float t = to_unit((uv * free + vw) / vv);
    const float s = to_unit((uv * t - uw) / uu);
    const Vector way{w.x + s * u.x - t * v.x, w.y + s * u.y - t * v.y, w.z + s * u.z - t * v.z};
    const float turn = root(crossing ? 0.0F : rounding * (uu + vv));
    const float distance = root(dot(way, way) - rounding * (uu + vv + ww)) - turn;
    values[k] = larger(distance, 0.0F);
  }
}

/// How far the tiles b of a patch are from tile i of patch a, by planes square to the line between
/// their centres. Tells which are within `gap` of their `nearest` or within `least`, if any, and
/// keeps how far the others are at least, and beyond their nearest.
CLOTHSIM_TARGET_CLONES
bool outline(const Corners& a, std::size_t i, const Corners& b, const float* __restrict nearest,
             float gap, float least, std::array<int, n>& near, Row& rest, Row& rest_gap) {
  const Vector from = at(a[0], i);
  const auto seen = [&from](const Corner& corner, std::size_t k) -> Vector {
    return {corner[0][k] - from.x, corner[1][k] - from.y, corner[2][k] - from.z};
  };
  const Vector a1 = seen(a[1], i), a2 = seen(a[2], i), a3 = seen(a[3], i);
  int any = 0;
#pragma GCC ivdep
  for (std::size_t j = 0; j < n; ++j) {
    const Vector b0 = seen(b[0], j), b1 = seen(b[1], j), b2 = seen(b[2], j), b3 = seen(b[3], j);
    const Vector way{b0.x + b1.x + b2.x + b3.x - a1.x - a2.x - a3.x,
                     b0.y + b1.y + b2.y + b3.y - a1.y - a2.y - a3.y,
                     b0.z + b1.z + b2.z + b3.z - a1.z - a2.z - a3.z};
    const float highest = larger(larger(0.0F, dot(way, a1)), larger(dot(way, a2), dot(way, a3)));
    const float lowest =
        smaller(smaller(dot(way, b0), dot(way, b1)), smaller(dot(way, b2), dot(way, b3)));
    const float distance = larger((lowest - highest) / (root(dot(way, way)) + tiny), 0.0F);
    const int is_near = distance > larger(nearest[j] + gap, least) ? 0 : 1;
    near[j] = is_near;
    any |= is_near;
    rest[j] = is_near != 0 ? rest[j] : smaller(rest[j], distance);
    rest_gap[j] = is_near != 0 ? rest_gap[j] : smaller(rest_gap[j], distance - nearest[j]);
  }
  return any != 0;
}

}  // namespace

SurfacePair TileFeatures::point_and_triangle(int of_point, int of_triangle,
                                             std::size_t number) const {
  const auto& [a, b, c] = triangles[number];
  const int cell = of_triangle - of_triangle / columns_;  // one less in each row
  return {2 * cell + static_cast<int>(number),
          {of_point, point(of_triangle, a), point(of_triangle, b), point(of_triangle, c)},
          0};
}

SurfacePair TileFeatures::pair(int a, int b, std::size_t number) const {
  if (number < 2) return point_and_triangle(a, b, number);
  if (number < points) return point_and_triangle(b, a, number - 2);
  const auto& [i, j] = edges[(number - points) / 3];
  const auto& [k, l] = edges[(number - points) % 3];
  return {SurfacePair::no_triangle, {point(a, i), point(a, j), point(b, k), point(b, l)}, 0};
}

TileShapes::TileShapes(const Cloth& cloth, std::shared_ptr<const std::vector<Patch>> patches)
    : columns_(cloth.columns),
      rows_(cloth.rows),
      patches_(std::move(patches)),
      corners_(patches_->size()),
      roundings_(patches_->size()) {}

void TileShapes::update(int patch, const Points& positions) {
  const auto& tiles_of = (*patches_)[static_cast<std::size_t>(patch)].tiles;
  float farthest = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const int tile = exists(patch, k) ? tiles_of[k] : tiles_of[0];
    const bool last_column = tile % columns_ == columns_ - 1,
               last_row = tile / columns_ == rows_ - 1;
    for (std::size_t corner = 0; corner < TileFeatures::corners; ++corner) {
      const auto& [along_row, along_column] = TileFeatures::ways[corner];
      const int point =
          tile + (last_column ? 0 : along_row) + (last_row ? 0 : along_column * columns_);
      const Vector3 seen = row(positions, point) - row(positions, 0);  // fewer digits are lost
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<float>(seen[static_cast<Eigen::Index>(axis)]);
        corners_[static_cast<std::size_t>(patch)][corner][axis][k] = at;
        farthest = std::max(farthest, std::abs(at));
      }
    }
  }
  roundings_[static_cast<std::size_t>(patch)] = 4 * epsilon * farthest;
}

float TileShapes::rounding(int patch, int other) const {
  return std::max(roundings_[static_cast<std::size_t>(patch)],
                  roundings_[static_cast<std::size_t>(other)]);
}

void TileShapes::look(int patch, int other, const PairValues& nearest, float gap, float least,
                      Near& near) const {
  const Corners &a = corners_[static_cast<std::size_t>(patch)],
                &b = corners_[static_cast<std::size_t>(other)];
  std::array<int, n> is_near;
  Row rest, rest_gap;
  rest.fill(infinity);
  rest_gap.fill(infinity);
  near.count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool any = outline(a, i, b, nearest.data() + i * n, gap, least, is_near, rest, rest_gap);
    if (!any || !exists(patch, i)) continue;
    for (std::size_t j = patch == other ? i + 1 : 0; j < n; ++j) {
      near.pairs[near.count] = static_cast<int>(i * n + j);
      near.count += is_near[j] != 0 && exists(other, j) ? 1 : 0;
    }
  }
  near.rest = *std::min_element(rest.begin(), rest.end());
  near.rest_gap = *std::min_element(rest_gap.begin(), rest_gap.end());
}

void TileShapes::measure(int patch, int other, const int* pairs, std::size_t count,
                         Distances& found) const {
  std::array<Corners, 2> of;
  for (std::size_t k = 0; k < n; ++k) {
    const auto pair = static_cast<std::size_t>(pairs[std::min(k, count - 1)]);
    for (std::size_t corner = 0; corner < TileFeatures::corners; ++corner) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        of[0][corner][axis][k] = corners_[static_cast<std::size_t>(patch)][corner][axis][pair / n];
        of[1][corner][axis][k] = corners_[static_cast<std::size_t>(other)][corner][axis][pair % n];
      }
    }
  }
  for (std::size_t k = 0; k < TileFeatures::points; ++k) {
    const Corners &point = of[k / 2], &other_tile = of[1 - k / 2];
    const auto& [a, b, c] = TileFeatures::triangles[k % 2];
    point_triangle(point[0], other_tile[a], other_tile[b], other_tile[c], found.values[k],
                   found.within[k]);
  }
  for (std::size_t k = TileFeatures::points; k < TileFeatures::count; ++k) {
    const auto& [a, b] = TileFeatures::edges[(k - TileFeatures::points) / 3];
    const auto& [c, d] = TileFeatures::edges[(k - TileFeatures::points) % 3];
    edge_edge(of[0][a], of[0][b], of[1][c], of[1][d], found.values[k]);
  }
}

}  // namespace clothsim
