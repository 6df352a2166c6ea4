#include "clothsim/search/unfolded.h"

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(Unfolded, BoundsTheDistancesOfARectangle) {
  // Bent, sheared and shaken rectangles: where it holds, no two points are nearer than it says.
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Cloth cloth = cloth_of(4, 5, 0.01);
    const Points random = random_points(3, 1, seed);
    Points x = shaken(cloth, 0.05, seed);
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      x(i, 2) += 0.5 * random(0, 0) * x(i, 0) * x(i, 1) + random(0, 1) * x(i, 0) * x(i, 0);
      x(i, 0) += random(1, 0) * x(i, 1);
    }
    const double least = least_stretch(gradient_bounds(cloth, x, 0, 0, 3, 4));
    if (least > 0.2) ++held;
    for (int i = 0; i < cloth.num_points(); ++i) {
      for (int j = 0; j < i; ++j) {
        const double rest = (cloth.rest_positions.row(i) - cloth.rest_positions.row(j)).norm();
        EXPECT_GE((x.row(i) - x.row(j)).norm(), least * rest - 1e-12);
      }
    }
  }
  EXPECT_GT(held, 20);
}

TEST(Unfolded, HoldsForAnyRigidMotionAndNotForAFold) {
  const Cloth cloth = cloth_of(6, 6, 0.01);
  const Eigen::AngleAxisd turn(2, Vector3(1, 2, 3).normalized());
  const Points turned = cloth.rest_positions * turn.toRotationMatrix().transpose();
  Points folded = cloth.rest_positions;
  folded.col(0) = (folded.col(0).array() - 0.5).abs();
  EXPECT_NEAR(least_stretch(gradient_bounds(cloth, turned, 0, 0, 5, 5)), 1, 1e-12);
  EXPECT_LT(least_stretch(gradient_bounds(cloth, folded, 0, 0, 5, 5)), 0.01);
}

}  // namespace
}  // namespace clothsim
