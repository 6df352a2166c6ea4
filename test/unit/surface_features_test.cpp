#include "clothsim/search/tiles.h"
#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(NearestDistances, AreAQuarterOfThoseAtRestUpToTheContactDistance) {
  // Of edges inside the cloth: up to a share of it.
  for (const double thickness : {0.004, 0.02, 0.1, 1000.0}) {
    ClothSpec spec;
    spec.columns = 8;
    spec.rows = 7;
    spec.height = 0.5;
    spec.thickness = thickness;
    const Cloth cloth = make_grid(spec);
    const NearestDistances nearest(cloth);
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
    brute_force(cloth, [&](const SurfacePair& pair) {
      const double rest = separation(pair, cloth.rest_positions).distance;
      const auto& [a, b, c, d] = pair.points;
      const bool inside = pair.edges() && !is_border(a, b) && !is_border(c, d);
      insides += inside;
      const double share = inside ? NearestDistances::edge_share : 1;
      const double expected = std::min(share * 2 * thickness, rest / 4);
      EXPECT_NEAR(nearest_of(nearest, cloth.columns, pair), expected, 1e-12);
      least = std::min(least, expected);
      return false;
    });
    EXPECT_NEAR(nearest.least(), least, 1e-12);
    EXPECT_GT(insides, 100);
  }
}

TEST(TileFeatures, AreAllThatShareNoPointEachOnce) {
  for (const auto& [columns, rows] : {std::pair(6, 5), std::pair(2, 2), std::pair(2, 6)}) {
    const Cloth cloth = cloth_of(columns, rows, 0.01);
    const NearestDistances nearest(cloth);
    const TileFeatures features(columns);
    std::vector<SurfacePair> found;
    for (int a = 0; a < cloth.num_points(); ++a) {
      for (int b = a + 1; b < cloth.num_points(); ++b) {
        const NearestDistances::OfTiles of_tiles = nearest.of_tiles(a, b);
        for (std::size_t k = 0; k < TileFeatures::own_points; ++k) {
          if (of_tiles[k] < 0) continue;
          found.push_back(features.pair(a, b, k));
          EXPECT_EQ(of_tiles[k], static_cast<float>(nearest_of(nearest, columns, found.back())));
        }
      }
    }
    const auto all = brute_force(cloth, [](const SurfacePair&) { return true; });
    EXPECT_TRUE(sorted_features(found) == sorted_features(all)) << columns << " x " << rows;
  }
}

TEST(SurfaceMesh, KnowsTheTrianglesOfEachPoint) {
  const Cloth cloth = cloth_of(5, 4, 0.01);
  const SurfaceMesh mesh(cloth);
  EXPECT_EQ(mesh.triangles.size(), 2u * 4 * 3);
  EXPECT_EQ(mesh.edges.size(), 4u * 4 + 5 * 3 + 4 * 3);  // along rows, columns, diagonals
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (const int corner : mesh.triangles[static_cast<std::size_t>(t)]) {
      const auto& around = mesh.around_point[static_cast<std::size_t>(corner)];
      EXPECT_EQ(std::count(around.begin(), around.end(), t), 1);
    }
  }
}

}  // namespace
}  // namespace clothsim
