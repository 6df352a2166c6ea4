#include "clothsim/search/tiles.h"
#include "surface_testing.h"

namespace clothsim::surface_features_test {
namespace {

using namespace test;

TEST(NearestDistances, AreAQuarterOfThoseAtRestUpToTheContactDistance) {
  // Edges inside the cloth: up to a share of them.
  for (const double thickness : {0.004, 0.02, 0.1, 1000.0}) {
    ClothSpec spec;
    spec.columns = 8;
    spec.rows = 7;
    spec.height = 0.5;
    spec.thickness = thickness;
    const Cloth cloth = make_grid(spec);
    const Surface surface(cloth);
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
    brute_force(surface, [&](const SurfacePair& pair) {
      const double rest = separation(pair, cloth.rest_positions).distance;
      const auto& [a, b, c, d] = pair.points;
      const bool inside = pair.edges() && !is_border(a, b) && !is_border(c, d);
      insides += inside;
      const double share = inside ? NearestDistances::edge_share : 1;
      const double expected = std::min(share * 2 * thickness, rest / 4);
      EXPECT_NEAR(pair.nearest, expected, 1e-12);
      least = std::min(least, expected);
      return false;
    });
    EXPECT_NEAR(surface.nearest.min(), least, 1e-12);
    EXPECT_GT(insides, 100);
  }
}

TEST(Tiling, OfAGridHasAllThatShareNoPointEachOnce) {
  for (const auto& [columns, rows] : {std::pair(6, 5), std::pair(2, 2), std::pair(2, 6)}) {
    expect_all_once(cloth_of(columns, rows, 0.01));
  }
}

TEST(Tiling, OfAThinGridHasThemWherePatchesAreFarApart) { expect_all_once(cloth_of(14, 9, 0.001)); }

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
}  // namespace clothsim::surface_features_test
