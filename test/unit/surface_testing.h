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

/// A flat cloth of 1 m x 1 m.
inline Cloth cloth_of(int columns, int rows, double thickness) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.origin = Vector3::Zero();
  spec.thickness = thickness;
  return make_grid(spec);
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
    pair.nearest = nearest.of(pair);
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
