#include "clothsim/dynamics/stretch.h"

#include "verification/testing.h"

namespace clothsim::stretch_test {
namespace {

using namespace test;

TEST(Stretch, FastWorstEqualsThePlainOne) {
  for (const auto& [columns, rows] :
       {std::pair(1, 2), std::pair(7, 5), std::pair(50, 50), std::pair(1, 300)}) {
    ClothSpec spec;
    spec.columns = columns;
    spec.rows = rows;
    const Cloth cloth = make_grid(spec);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      for (const double size : {1e-3, 0.3, 100.0}) {
        const Points x = shaken(cloth, size, seed);
        const double worst = measure_stretch(cloth, x).worst;
        EXPECT_NEAR(worst_stretch(cloth, x), worst, 1e-13 * (1 + worst));
      }
    }
  }
}

TEST(Stretch, FindsTheOneLongSpringWhereverItIs) {
  // Each point in turn is pulled out of the plane.
  const Cloth cloth = make_grid(square_spec(7));
  for (int i = 0; i < cloth.num_points(); ++i) {
    Points x = cloth.rest_positions;
    x(i, 2) += 1;
    EXPECT_NEAR(worst_stretch(cloth, x), measure_stretch(cloth, x).worst, 1e-13);
    EXPECT_GT(worst_stretch(cloth, x), 3);
  }
}

TEST(Stretch, ScaledClothStretchesEvenly) {
  const Cloth cloth = make_grid(square_spec(7));
  const Points x = 1.25 * cloth.rest_positions;
  EXPECT_NEAR(measure_stretch(cloth, x).worst, 0.25, 1e-13);
  EXPECT_NEAR(measure_stretch(cloth, x).mean, 0.25, 1e-13);
}

TEST(Stretch, CollapsedClothIsAtMinusOne) {
  const Cloth cloth = make_grid(square_spec(7));
  const Points x = Points::Zero(cloth.num_points(), 3);
  EXPECT_EQ(measure_stretch(cloth, x).worst, -1);
  EXPECT_EQ(worst_stretch(cloth, x), -1);
}

TEST(Stretch, IsZeroWithoutSprings) {
  ClothSpec spec = square_spec(4);
  spec.material.springs = {false, false, false};
  const Cloth cloth = make_grid(spec);
  EXPECT_EQ(worst_stretch(cloth, cloth.rest_positions), 0);
  EXPECT_EQ(measure_stretch(cloth, cloth.rest_positions).worst, 0);
}

}  // namespace
}  // namespace clothsim::stretch_test
