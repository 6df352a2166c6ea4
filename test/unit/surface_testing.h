#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/search/near_pairs.h"
#include "clothsim/search/nearest_distances.h"
#include "verification/testing.h"

namespace clothsim::test {

constexpr double strip_thickness = 0.01;  // [m]

/// A strip, free and without springs that matter here.
inline Cloth strip(int columns, double friction = 0) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = 2;
  spec.width = 0.1 * (columns - 1);
  spec.height = 0.1;
  spec.origin = Vector3::Zero();
  spec.thickness = strip_thickness;
  spec.friction = friction;
  spec.material.density = 100;
  return make_grid(spec);
}

/// The strip's last cell, narrower, turned back over the first at height z and moved by `shift`.
inline State folded(const Cloth& cloth, double z, const Eigen::RowVector3d& shift) {
  State state{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  for (int row = 0; row < 2; ++row) {
    const int end = row * cloth.columns + cloth.columns - 1;
    state.positions.row(end) = Eigen::RowVector3d(0, 0.02 + 0.06 * row, z) + shift;
    state.positions.row(end - 1) = Eigen::RowVector3d(0.1, 0.02 + 0.06 * row, z) + shift;
    for (int column = 2; column < cloth.columns - 2; ++column) {  // the way round
      const double x = 0.2 + 0.1 * column;
      state.positions.row(row * cloth.columns + column) << x, 0.1 * row, z * column * 0.15;
    }
  }
  return state;
}

/// Pairs of different layers, which must keep the whole contact distance.
inline double min_distance(const Cloth& cloth, const Points& positions) {
  double least = 1;
  NearPairs finder(cloth);
  for (const NearPair& near : finder.approaching(positions, 10 * positions)) {
    if (near.pair.nearest == 2 * strip_thickness) least = std::min(least, near.separation.distance);
  }
  return least;
}

/// A flat cloth of 1 m x 1 m.
inline Cloth cloth_of(int columns, int rows, double thickness) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.origin = Vector3::Zero();
  spec.thickness = thickness;
  return make_grid(spec);
}

/// A surface as the search sees it.
struct Surface {
  Surface(const Cloth& cloth)  // NOLINT: a cloth is one
      : rest(cloth.rest_positions),
        thickness({cloth.thickness}),
        mesh(cloth),
        tiling(std::make_shared<Tiling>(cloth.columns, cloth.rows)),
        patches(cut_into_patches(*tiling, cloth.columns, cloth.rows)),
        nearest(cloth, tiling, patches, Tiling::of_surfaces) {}
  Surface(const Points& at_rest, const SurfaceMesh& of, const std::vector<double>& by_cloth)
      : rest(at_rest),
        thickness(by_cloth),
        mesh(of),
        tiling(std::make_shared<Tiling>(mesh)),
        patches(cut_into_patches(*tiling, rest)),
        nearest(mesh, rest, thickness, tiling, patches, Tiling::of_surfaces) {}

  int num_points() const { return static_cast<int>(rest.rows()); }
  double thickness_at(int point) const {
    return thickness[static_cast<std::size_t>(mesh.cloth_of(point))];
  }
  /// Contact distance of two features if they are no neighbours, and not both edges inside [m].
  double whole_distance(const SurfacePair& pair) const {
    return thickness_at(pair.points.front()) + thickness_at(pair.points.back());
  }

  /// Contact distance of a pair [m], from the tiles that have it.
  double nearest_of(const SurfacePair& pair) const {
    const auto& [a, b, c, d] = pair.points;
    if (!pair.edges()) return nearest.of_tracked(a, pair.triangle);
    const auto [first, k] = tile_of(a, b);
    const auto [second, l] = tile_of(c, d);
    return nearest.of(first, second, Tiling::points + 3 * k + l);
  }

  /// The tile of an edge, and its number there.
  std::pair<int, std::size_t> tile_of(int from, int to) const {
    for (int tile = 0; tile < static_cast<int>(tiling->tiles().size()); ++tile) {
      for (std::size_t k = 0; k < Tiling::edges.size(); ++k) {
        const int a = tiling->at(tile).points[0], b = tiling->at(tile).points[Tiling::edges[k][1]];
        if (tiling->at(tile).own[Tiling::first_edge + k] == Tiling::lacking) continue;
        if ((a == from && b == to) || (a == to && b == from)) return {tile, k};
      }
    }
    ADD_FAILURE() << "no tile has the edge of " << from << " and " << to;
    return {0, 0};
  }

  Points rest;
  std::vector<double> thickness;  // by cloth [m]
  SurfaceMesh mesh;
  std::shared_ptr<const Tiling> tiling;
  std::vector<Patch> patches;
  NearestDistances nearest;
};

/// Every point and triangle, edge and edge that share no point and for which `chosen` holds.
template <typename Chosen>
std::vector<SurfacePair> brute_force(const Surface& surface, const Chosen& chosen) {
  const SurfaceMesh& mesh = surface.mesh;
  std::vector<SurfacePair> pairs;
  const auto consider = [&](SurfacePair pair) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (pair.points[i] == pair.points[j]) return;
      }
    }
    if (chosen(pair)) pairs.push_back(pair);
  };
  for (int i = 0; i < surface.num_points(); ++i) {
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
      consider({t, {i, a, b, c}, surface.nearest.of_tracked(i, t)});
    }
  }
  std::vector<std::pair<int, std::size_t>> tiles;
  for (const auto& [a, b] : mesh.edges) tiles.push_back(surface.tile_of(a, b));
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    for (std::size_t f = 0; f < e; ++f) {
      const auto& [a, b] = mesh.edges[e];
      const auto& [c, d] = mesh.edges[f];
      const std::size_t number = Tiling::points + 3 * tiles[e].second + tiles[f].second;
      consider({SurfacePair::no_triangle,
                {a, b, c, d},
                surface.nearest.of(tiles[e].first, tiles[f].first, number)});
    }
  }
  return pairs;
}

using Features = std::pair<int, std::array<int, 4>>;

/// Sorted by their points: the order of tiles is arbitrary.
inline Features features(const SurfacePair& pair) {
  auto [a, b, c, d] = pair.points;
  if (!pair.edges()) {
    std::array<int, 3> corners{b, c, d};
    std::sort(corners.begin(), corners.end());
    return {pair.triangle, {a, corners[0], corners[1], corners[2]}};
  }
  if (a > b) std::swap(a, b);
  if (c > d) std::swap(c, d);
  if (std::pair(c, d) < std::pair(a, b)) {
    std::swap(a, c);
    std::swap(b, d);
  }
  return {pair.triangle, {a, b, c, d}};
}

inline std::vector<Features> sorted_features(const std::vector<SurfacePair>& pairs) {
  std::vector<Features> result;
  for (const SurfacePair& pair : pairs) result.push_back(features(pair));
  std::sort(result.begin(), result.end());
  return result;
}

inline std::vector<Features> sorted_features(const std::vector<NearPair>& pairs) {
  std::vector<Features> result;
  for (const NearPair& near : pairs) result.push_back(features(near.pair));
  std::sort(result.begin(), result.end());
  return result;
}

/// Tiles have all pairs of features that share no point, each once, at their contact distance.
inline void expect_all_once(const Surface& surface) {
  std::vector<SurfacePair> found;
  const auto count = static_cast<int>(surface.patches.size());
  constexpr std::size_t tiles = TileShapes::tiles;
  for (int p = 0; p < count; ++p) {
    for (int q = p; q < count; ++q) {
      const NearestDistances::OfPatches& of_patches = surface.nearest.of_patches(p, q);
      for (std::size_t pair = 0; pair < tiles * tiles; ++pair) {
        const std::size_t i = pair / tiles, j = pair % tiles;
        const int a = surface.patches[static_cast<std::size_t>(p)].tiles[i];
        const int b = surface.patches[static_cast<std::size_t>(q)].tiles[j];
        if (a == Patch::none || b == Patch::none || (p == q && i > j)) continue;
        const auto of_tiles = surface.nearest.of_tiles(of_patches, static_cast<int>(pair), a, b);
        for (std::size_t k = 0; k < Tiling::own_points; ++k) {
          if (of_tiles[k] < 0) continue;
          found.push_back(surface.tiling->pair(a, b, k));
          EXPECT_EQ(of_tiles[k], static_cast<float>(surface.nearest_of(found.back())));
        }
      }
    }
  }
  const auto all = brute_force(surface, [](const SurfacePair&) { return true; });
  EXPECT_TRUE(sorted_features(found) == sorted_features(all));
}

}  // namespace clothsim::test
