#include "clothsim/search/tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr std::size_t n = TileShapes::tiles;
constexpr float epsilon = std::numeric_limits<float>::epsilon();

/// Of directions that count as parallel, and of squared lengths: more than some ten roundings of
/// products of the same size.
constexpr float rounding = 16 * epsilon;
constexpr float tiny = std::numeric_limits<float>::min();

// As ternaries they are vectorised.
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }
inline float to_unit(float t) { return smaller(larger(t, 0.0F), 1.0F); }
inline float root(float squared) { return std::sqrt(larger(squared, 0.0F)); }

struct Vector {
  float x, y, z;
};
inline float dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// A corner of sixteen tiles.
using Corner = std::array<TileShapes::Row, 3>;
using Corners = std::array<Corner, TileFeatures::corners>;
inline Vector between(const Corner& from, const Corner& to, std::size_t k) {
  return {to[0][k] - from[0][k], to[1][k] - from[1][k], to[2][k] - from[2][k]};
}

/// Of points a to triangles b, c, d: see Distances in geometry.
CLOTHSIM_TARGET_CLONES
void point_triangle(const Corner& a, const Corner& b, const Corner& c, const Corner& d,
                    const TileShapes::Row& lack, TileShapes::Row& values, TileShapes::Row& within) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < TileShapes::at_once; ++k) {
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
    values[k] = root(squared - rounding * (uu + vv + ww)) + lack[k];
    within[k] = least;
  }
}

/// Of edges a -> b to c -> d. Parallel ones are taken to be as near as a slight turn makes them.
CLOTHSIM_TARGET_CLONES
void edge_edge(const Corner& a, const Corner& b, const Corner& c, const Corner& d,
               const TileShapes::Row& lack_a, const TileShapes::Row& lack_c,
               TileShapes::Row& values) {
#pragma GCC ivdep
  for (std::size_t k = 0; k < TileShapes::at_once; ++k) {
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
    values[k] = larger(distance, 0.0F) + lack_a[k] + lack_c[k];
  }
}

void measure_all(const std::array<Corners, 2>& of,
                 const std::array<std::array<TileShapes::Row, 3>, 2>& lacks,
                 TileShapes::Distances& found) {
  for (std::size_t side = 0; side < 2; ++side) {
    const Corner& point = of[side][0];
    const Corners& other = of[1 - side];
    for (std::size_t t = 0; t < 2; ++t) {
      const auto& [a, b, c] = TileFeatures::triangles[t];
      point_triangle(point, other[a], other[b], other[c], lacks[1 - side][0],
                     found.values[2 * side + t], found.within[2 * side + t]);
    }
  }
  // Edges lack what their way does: the one across is no longer than the triangles.
  static constexpr std::array<std::size_t, 3> lack{1, 2, 0};
  for (std::size_t e = 0; e < 3; ++e) {
    for (std::size_t f = 0; f < 3; ++f) {
      const auto& [a, b] = TileFeatures::edges[e];
      const auto& [c, d] = TileFeatures::edges[f];
      edge_edge(of[0][a], of[0][b], of[1][c], of[1][d], lacks[0][lack[e]], lacks[1][lack[f]],
                found.values[TileFeatures::points + 3 * e + f]);
    }
  }
}

/// How far the tiles b of a patch are from one tile a, by planes square to the line between their
/// centres. Tells which are within `gap` of their `nearest` or within `least`, if any, and keeps
/// how far the others are at least, and beyond their nearest.
CLOTHSIM_TARGET_CLONES
bool outline(const float* a, const float* __restrict b, const float* __restrict nearest, float gap,
             float least, std::array<int, n>& near, TileShapes::Row& rest,
             TileShapes::Row& rest_gap) {
  constexpr std::size_t corner = 3 * n, centre = 4 * corner;
  const Vector from{a[centre], a[centre + n], a[centre + 2 * n]};
  const auto of_a = [&](std::size_t k) -> Vector {
    const float* const at = a + k * corner;
    return {at[0] - from.x, at[n] - from.y, at[2 * n] - from.z};
  };
  const Vector a0 = of_a(0), a1 = of_a(1), a2 = of_a(2), a3 = of_a(3);
  int any = 0;
#pragma GCC ivdep
  for (std::size_t j = 0; j < n; ++j) {
    const auto of_b = [&](std::size_t k) -> Vector {
      const float* const at = b + k * corner + j;
      return {at[0] - from.x, at[n] - from.y, at[2 * n] - from.z};
    };
    const Vector way = of_b(TileFeatures::corners);
    const float highest =
        larger(larger(dot(way, a0), dot(way, a1)), larger(dot(way, a2), dot(way, a3)));
    const float lowest = smaller(smaller(dot(way, of_b(0)), dot(way, of_b(1))),
                                 smaller(dot(way, of_b(2)), dot(way, of_b(3))));
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

TileShapes::TileShapes(const Cloth& cloth, std::size_t num_patches)
    : columns_(cloth.columns),
      rows_(cloth.rows),
      values_(num_patches * rows * tiles),
      roundings_(num_patches),
      exists_(num_patches * tiles) {}

void TileShapes::update(int patch, const Patch& of, const Points& positions) {
  float* const values = values_.data() + static_cast<std::size_t>(patch) * rows * tiles;
  float farthest = 0;
  for (std::size_t k = 0; k < tiles; ++k) {
    const int tile = of.tiles[k] == Patch::none ? of.tiles[0] : of.tiles[k];
    exists_[static_cast<std::size_t>(patch) * tiles + k] = of.tiles[k] != Patch::none;
    const bool last_column = tile % columns_ == columns_ - 1,
               last_row = tile / columns_ == rows_ - 1;
    for (std::size_t axis = 0; axis < axes; ++axis) {
      float sum = 0;
      for (std::size_t corner = 0; corner < TileFeatures::corners; ++corner) {
        const auto& [along_row, along_column] = TileFeatures::ways[corner];
        const int point =
            tile + (last_column ? 0 : along_row) + (last_row ? 0 : along_column * columns_);
        const auto column = static_cast<Eigen::Index>(axis);
        const auto at = static_cast<float>(positions(point, column) - origin_[column]);
        values[(corner * axes + axis) * tiles + k] = at;
        farthest = std::max(farthest, std::abs(at));
        sum += at;
      }
      values[(centre * axes + axis) * tiles + k] = sum / TileFeatures::corners;
    }
    const auto lack = [&](std::size_t what, bool is_lacking) {
      values[(first_lack + what) * tiles + k] = is_lacking ? far : 0;
    };
    lack(0, last_column || last_row);
    lack(1, last_column);
    lack(2, last_row);
  }
  roundings_[static_cast<std::size_t>(patch)] = 4 * epsilon * farthest;
}

void TileShapes::look(int patch, int other, const PairValues& nearest, float gap, float least,
                      Near& near) const {
  const char* const exists = exists_.data() + static_cast<std::size_t>(patch) * tiles;
  const char* const other_exists = exists_.data() + static_cast<std::size_t>(other) * tiles;
  std::array<int, n> is_near;
  Row rest, rest_gap;
  rest.fill(far);
  rest_gap.fill(far);
  near.count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool any = outline(of(patch) + i, of(other), nearest.data() + i * n, gap, least, is_near,
                             rest, rest_gap);
    if (!any || exists[i] == 0) continue;
    for (std::size_t j = patch == other ? i + 1 : 0; j < n; ++j) {
      near.pairs[near.count] = static_cast<int>(i * n + j);
      near.count += is_near[j] != 0 && other_exists[j] != 0 ? 1 : 0;
    }
  }
  near.rest = *std::min_element(rest.begin(), rest.end());
  near.rest_gap = *std::min_element(rest_gap.begin(), rest_gap.end());
}

void TileShapes::measure(int patch, int other, const int* pairs, std::size_t count,
                         Distances& found) const {
  std::array<Corners, 2> corners;
  std::array<std::array<Row, 3>, 2> lacks;
  std::array<std::array<std::size_t, at_once>, 2> at;
  for (std::size_t k = 0; k < at_once; ++k) {
    const auto pair = static_cast<std::size_t>(pairs[std::min(k, count - 1)]);
    at[0][k] = pair / n;
    at[1][k] = pair % n;
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const float* const values = of(side == 0 ? patch : other);
    const auto take = [&](std::size_t row, Row& into) {
      for (std::size_t k = 0; k < at_once; ++k) into[k] = values[row * n + at[side][k]];
    };
    for (std::size_t corner = 0; corner < TileFeatures::corners; ++corner) {
      for (std::size_t axis = 0; axis < axes; ++axis) {
        take(corner * axes + axis, corners[side][corner][axis]);
      }
    }
    for (std::size_t what = 0; what < 3; ++what) take(first_lack + what, lacks[side][what]);
  }
  measure_all(corners, lacks, found);
}

}  // namespace clothsim
