#include "clothsim/model/grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/errors.h"

namespace clothsim::grid_test {
namespace {

ClothSpec small_spec() {
  ClothSpec spec;
  spec.columns = 5;
  spec.rows = 4;
  spec.width = 2;
  spec.height = 1.5;
  spec.origin = Vector3(-1, 3, 7);
  return spec;
}

int count(const Cloth& cloth, SpringFamily family) {
  int springs = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int, int) { springs += run.family == family; });
  return springs;
}

TEST(Grid, DefaultClothHasItsCountsAndMasses) {
  const Cloth cloth = make_grid(ClothSpec());
  EXPECT_EQ(cloth.num_points(), 2500);
  EXPECT_EQ(count(cloth, SpringFamily::structural), 2 * 50 * 49);
  EXPECT_EQ(count(cloth, SpringFamily::shear), 2 * 49 * 49);
  EXPECT_EQ(count(cloth, SpringFamily::bending), 2 * 50 * 48);
  EXPECT_EQ(cloth.num_springs(), 14502);
  EXPECT_DOUBLE_EQ(cloth.mass[0], 150.0 / 2500);
  EXPECT_NEAR(cloth.mass.sum(), 150, 1e-9);
}

TEST(Grid, EveryFamilyCanBeSwitchedOffAlone) {
  for (int mask = 0; mask < 8; ++mask) {
    ClothSpec spec = small_spec();
    spec.material.springs = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
    const Cloth cloth = make_grid(spec);
    EXPECT_EQ(count(cloth, SpringFamily::structural), mask & 1 ? 4 * 4 + 5 * 3 : 0);
    EXPECT_EQ(count(cloth, SpringFamily::shear), mask & 2 ? 2 * 4 * 3 : 0);
    EXPECT_EQ(count(cloth, SpringFamily::bending), mask & 4 ? 3 * 4 + 5 * 2 : 0);
  }
}

TEST(Grid, SpringsJoinExactlyTheNeighboursOfTheModel) {
  // All pairs one by one, against the runs: family, rest length, stiffness, and each pair once.
  const ClothSpec spec = small_spec();
  const Cloth cloth = make_grid(spec);
  std::map<std::pair<int, int>, SpringFamily> expected;
  for (int a = 0; a < cloth.num_points(); ++a) {
    for (int b = a + 1; b < cloth.num_points(); ++b) {
      const int columns = std::abs(b % 5 - a % 5);
      const int rows = b / 5 - a / 5;
      const auto is = [&](int c, int r) { return columns == c && rows == r; };
      if (is(1, 0) || is(0, 1)) expected[{a, b}] = SpringFamily::structural;
      if (is(1, 1)) expected[{a, b}] = SpringFamily::shear;
      if (is(2, 0) || is(0, 2)) expected[{a, b}] = SpringFamily::bending;
    }
  }
  std::set<std::pair<int, int>> seen;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    ASSERT_TRUE(expected.count({a, b})) << a << " " << b;
    EXPECT_EQ(run.family, expected.at({a, b}));
    EXPECT_TRUE(seen.insert({a, b}).second) << "twice: " << a << " " << b;
    const double rest = (cloth.rest_positions.row(b) - cloth.rest_positions.row(a)).norm();
    EXPECT_NEAR(run.rest_length, rest, 1e-14);
    EXPECT_EQ(run.stiffness, run.family == SpringFamily::bending ? 1000 : 5000);
  });
  EXPECT_EQ(seen.size(), expected.size());
}

TEST(Grid, PointsAreRowMajorFromTheOrigin) {
  ClothSpec spec = small_spec();
  Cloth cloth = make_grid(spec);
  EXPECT_EQ(cloth.rest_positions.row(0), Eigen::RowVector3d(-1, 3, 7));
  EXPECT_EQ(cloth.rest_positions.row(3 * 5 + 2), Eigen::RowVector3d(0, 4.5, 7));
  EXPECT_EQ(cloth.uv.row(0), Eigen::RowVector2d(0, 0));
  EXPECT_EQ(cloth.uv.row(19), Eigen::RowVector2d(1, 1));
  EXPECT_EQ(cloth.uv.row(4), Eigen::RowVector2d(1, 0));
  spec.orientation = Orientation::vertical;
  cloth = make_grid(spec);
  EXPECT_EQ(cloth.rest_positions.row(3 * 5 + 2), Eigen::RowVector3d(0, 3, 8.5));
}

TEST(Grid, TrianglesCoverTheSheetWithTheirFrontUp) {
  const Cloth cloth = make_grid(small_spec());
  EXPECT_EQ(cloth.triangles.size(), 2u * 4 * 3);
  double area = 0;
  for (const auto& [a, b, c] : cloth.triangles) {
    const Vector3 ab = (cloth.rest_positions.row(b) - cloth.rest_positions.row(a)).transpose();
    const Vector3 ac = (cloth.rest_positions.row(c) - cloth.rest_positions.row(a)).transpose();
    EXPECT_GT(ab.cross(ac).z(), 0);
    area += ab.cross(ac).z() / 2;
  }
  EXPECT_NEAR(area, 2 * 1.5, 1e-12);
}

TEST(Grid, PinsHaveInfiniteMass) {
  ClothSpec spec = small_spec();
  spec.pinned = {{4, 3, ""}, {1, 0, ""}};
  const Cloth cloth = make_grid(spec);
  EXPECT_EQ(cloth.pinned, (std::vector<int>{1, 19}));
  for (int i = 0; i < cloth.num_points(); ++i) {
    EXPECT_EQ(cloth.inv_mass[i], i == 1 || i == 19 ? 0 : 1 / cloth.mass[i]);
  }
}

TEST(Grid, AColumnIsAChain) {
  ClothSpec spec = small_spec();
  spec.columns = 1;
  const Cloth cloth = make_grid(spec);
  EXPECT_EQ(count(cloth, SpringFamily::structural), 3);
  EXPECT_EQ(count(cloth, SpringFamily::shear), 0);
  EXPECT_EQ(count(cloth, SpringFamily::bending), 2);
  EXPECT_TRUE(cloth.triangles.empty());
  EXPECT_TRUE(cloth.uv.allFinite());
}

TEST(Grid, RefusesABadSpec) {
  ClothSpec spec = small_spec();
  spec.columns = 0;
  EXPECT_THROW(make_grid(spec), InvalidValue);
  spec = small_spec();
  spec.pinned = {{5, 0, ""}};
  EXPECT_THROW(make_grid(spec), InvalidValue);
}

TEST(StartState, HorizontalClothLiesFlatAtRest) {
  const ClothSpec spec = small_spec();
  const Cloth cloth = make_grid(spec);
  const State state = start_state(spec, cloth, 1);
  EXPECT_EQ(state.positions, cloth.rest_positions);
  EXPECT_EQ(state.velocities.norm(), 0);
  EXPECT_EQ(state.time, 0);
}

TEST(StartState, VerticalClothStandsOffItsPlaneByTheSeed) {
  ClothSpec spec;
  spec.orientation = Orientation::vertical;
  const Cloth cloth = make_grid(spec);
  const State state = start_state(spec, cloth, 1);
  const Points off = state.positions - cloth.rest_positions;
  EXPECT_EQ(off.col(0).norm() + off.col(2).norm(), 0);
  EXPECT_LE(off.cwiseAbs().maxCoeff(), 1e-3);
  // Even over (-1 mm, 1 mm): the mean of 2500 draws has a deviation of 12 um, their variance is
  // (1 mm)^2 / 3 to 2 %.
  EXPECT_NEAR(off.col(1).mean(), 0, 4 * 12e-6);
  EXPECT_NEAR(off.col(1).squaredNorm() / 2500, 1e-6 / 3, 0.08e-6 / 3);
  EXPECT_EQ(start_state(spec, cloth, 1).positions, state.positions);
  EXPECT_NE(start_state(spec, cloth, 2).positions, state.positions);
}

TEST(Grid, ChoosesHowItIsKeptOffItself) {
  ClothSpec spec;
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::off);
  spec.self_collision = SelfCollision::automatic;
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::points);
  EXPECT_EQ(make_grid(spec, 20).self_collision, SelfCollision::surface) << "twice as heavy";
  spec.material.ks = 1000;  // pressed together by its weight
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::surface);
  spec.material.ks = 5000;
  spec.material.density = 500;
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::surface);
  spec.material.density = 150;
  spec.thickness = 0.009;  // points 20.4 mm apart, 18 of them covered
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::surface);
  spec.rows = 1;  // has none
  EXPECT_EQ(make_grid(spec).self_collision, SelfCollision::points);
  spec.self_collision = SelfCollision::surface;
  EXPECT_THROW(make_grid(spec), InvalidValue);
}

}  // namespace
}  // namespace clothsim::grid_test
