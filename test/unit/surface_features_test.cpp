#include "clothsim/search/feature_pairs.h"
#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(NearestDistances, AreAQuarterOfThoseAtRestUpToTheContactDistance) {
  // Of two edges inside the cloth: up to a share of that.
  // Of edges inside the cloth: up to a share of it.
  for (const double thickness : {0.004, 0.02, 0.1, 1000.0}) {
    ClothSpec spec;
    spec.columns = 8;
    spec.rows = 7;
    spec.height = 0.5;
    spec.thickness = thickness;
    const Cloth cloth = make_grid(spec);
    const NearestDistances nearest(cloth);
    const SurfaceMesh mesh(cloth);
    const auto is_border = [&](int a, int b) {
      const Points& x = cloth.rest_positions;
      const auto ends = [&](int axis) {
        return x(a, axis) == x(b, axis) &&
               (x(a, axis) == x.col(axis).minCoeff() || x(a, axis) == x.col(axis).maxCoeff());
      };
      return ends(0) || ends(1);
    };
    double least = 2 * thickness;
    int insides = 0;
    const auto check = [&](const SurfacePair& pair, int cell, int other) {
      const double rest = separation(pair, cloth.rest_positions).distance;
      if (rest < 1e-9) return;  // they share a point
      const auto& [a, b, c, d] = pair.points;
      const bool inside = pair.edges() && !is_border(a, b) && !is_border(c, d);
      insides += inside;
      const double share = inside ? NearestDistances::edge_share : 1;
      const double expected = std::min(share * 2 * thickness, rest / 4);
      EXPECT_NEAR(nearest.of(pair), expected, 1e-12);
      EXPECT_GE(nearest.most_of_cells(cell, other), expected - 1e-12);
      if (pair.edges()) {
        EXPECT_GE(nearest.most_of_edges(cell, other), expected - 1e-12);
      }
      least = std::min(least, expected);
    };
    for (int p = 0; p < mesh.num_cells(); ++p) {
      for (int q = 0; q < mesh.num_cells(); ++q) {
        const auto cell = static_cast<std::size_t>(p), other = static_cast<std::size_t>(q);
        for (const int i : mesh.cell_points[cell]) {
          for (const int t : {2 * q, 2 * q + 1}) {
            const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(t)];
            check({t, {i, a, b, c}, 0}, p, q);
          }
        }
        for (const int e : mesh.cell_edges[cell]) {
          for (const int f : mesh.cell_edges[other]) {
            const auto& [a, b] = mesh.edges[static_cast<std::size_t>(e)];
            const auto& [c, d] = mesh.edges[static_cast<std::size_t>(f)];
            check({SurfacePair::no_triangle, {a, b, c, d}, 0}, p, q);
          }
        }
      }
    }
    EXPECT_NEAR(nearest.least(), least, 1e-12);
    EXPECT_GT(insides, 100);
  }
}

TEST(FeaturePairs, AreAllThatShareNoPointEachOnce) {
  for (const auto& [columns, rows] : {std::pair(6, 5), std::pair(2, 2), std::pair(2, 6)}) {
    const Cloth cloth = cloth_of(columns, rows, 0.01);
    const SurfaceMesh mesh(cloth);
    const FeaturePairs lists(mesh);
    std::vector<SurfacePair> found;
    for (int cell = 0; cell < mesh.num_cells(); ++cell) {
      for (int other = cell; other < mesh.num_cells(); ++other) {
        const std::array<int, 2> cells{cell, other};
        const FeaturePairs::List& list = lists[lists.number(cell, other)];
        for (const bool edges : {false, true}) {
          for (const FeaturePairs::Pair& features : list[edges]) {
            SurfacePair pair{SurfacePair::no_triangle, features.points, 0};
            if (!edges) pair.triangle = 2 * cells[features.of[1]] + features.triangle;
            for (std::size_t k = 0; k < 4; ++k) {
              pair.points[k] += lists.first_point(cells[features.of[k]]);
            }
            found.push_back(pair);
          }
        }
      }
    }
    const auto all = brute_force(cloth, [](const SurfacePair&) { return true; });
    EXPECT_TRUE(sorted_features(found) == sorted_features(all)) << columns << " x " << rows;
  }
}

TEST(SurfaceMesh, HasEachFeatureOnce) {
  const Cloth cloth = cloth_of(5, 4, 0.01);
  const SurfaceMesh mesh(cloth);
  EXPECT_EQ(mesh.triangles.size(), 2u * 4 * 3);
  EXPECT_EQ(mesh.edges.size(), 4u * 4 + 5 * 3 + 4 * 3);  // along rows, columns, diagonals
  std::vector<int> points(20, 0), edges(mesh.edges.size(), 0);
  for (int cell = 0; cell < mesh.num_cells(); ++cell) {
    for (const int i : mesh.cell_points[static_cast<std::size_t>(cell)]) {
      ++points[static_cast<std::size_t>(i)];
    }
    for (const int e : mesh.cell_edges[static_cast<std::size_t>(cell)]) {
      ++edges[static_cast<std::size_t>(e)];
    }
  }
  EXPECT_EQ(points, std::vector<int>(20, 1));
  EXPECT_EQ(edges, std::vector<int>(mesh.edges.size(), 1));
}

}  // namespace
}  // namespace clothsim
