#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/search/near_pairs.h"
#include "clothsim/search/nearest_distances.h"
#include "verification/testing.h"

namespace clothsim::testing {

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

/// Its last cell, narrower, turned back over the first at height z and moved by `shift`.
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

/// Of layers: pairs that must keep the whole contact distance.
inline double least_distance(const Cloth& cloth, const Points& positions) {
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

/// How near a pair may come [m], by the tiles that have it.
inline double nearest_of(const NearestDistances& nearest, int columns, const SurfacePair& pair) {
  const auto& [a, b, c, d] = pair.points;
  // A triangle's first corner is that of its cell.
  if (!pair.edges()) return nearest.of(a, b, static_cast<std::size_t>(pair.triangle % 2));
  const auto direction = [&](int first, int second) -> std::size_t {
    return second - first == 1 ? 0 : second - first == columns ? 1 : 2;
  };
  return nearest.of(a, c, TileFeatures::points + 3 * direction(a, b) + direction(c, d));
}

/// Every point and triangle, edge and edge that share no point and lie so that `chosen` holds.
template <typename Chosen>
std::vector<SurfacePair> brute_force(const Cloth& cloth, const Chosen& chosen) {
  const SurfaceMesh mesh(cloth);
  const NearestDistances nearest(cloth);
  std::vector<SurfacePair> pairs;
  const auto consider = [&](SurfacePair pair) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (pair.points[i] == pair.points[j]) return;
      }
    }
    pair.nearest = nearest_of(nearest, cloth.columns, pair);
    if (chosen(pair)) pairs.push_back(pair);
  };
  for (int i = 0; i < cloth.num_points(); ++i) {
    for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
      consider({t, {i, a, b, c}, 0});
    }
  }
  for (int e = 0; e < static_cast<int>(mesh.edges.size()); ++e) {
    for (int f = 0; f < e; ++f) {
      const auto& [a, b] = mesh.edges[static_cast<std::size_t>(e)];
      const auto& [c, d] = mesh.edges[static_cast<std::size_t>(f)];
      consider({SurfacePair::no_triangle, {a, b, c, d}, 0});
    }
  }
  return pairs;
}

using Features = std::pair<int, std::array<int, 4>>;

/// Of two edges, in the order of their points.
inline Features features(const SurfacePair& pair) {
  auto [a, b, c, d] = pair.points;
  if (pair.edges() && std::pair(c, d) < std::pair(a, b)) {
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

}  // namespace clothsim::testing
