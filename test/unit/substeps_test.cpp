#include "clothsim/simulation/substeps.h"

#include <cmath>
#include <limits>

#include "verification/testing.h"

namespace clothsim::substeps_test {
namespace {

using namespace test;

TEST(CountSubsteps, FollowsTheFrequency) {
  // n = dt omega / (margin * limit): as the root of stiffness over mass, and with the frame.
  ClothSpec spec = square_spec(8, 4e6);
  const auto count = [&](double dt) {
    const Cloth cloth = make_grid(spec);
    return count_substeps(cloth, Vector3(0, 0, -9.8), cloth.rest_positions, 2, dt);
  };
  const int once = count(0.01);
  EXPECT_GT(once, 20);
  EXPECT_NEAR(count(0.02), 2 * once, 2);
  spec.material.ks *= 4;
  EXPECT_NEAR(count(0.01), 2 * once, 2);
  spec.material.density *= 4;
  EXPECT_NEAR(count(0.01), once, 1);
  spec.material.ks = 0;
  EXPECT_EQ(count(0.01), 1);
  spec.material.strain_limit = 0.1;
  EXPECT_GT(count(0.4), 5) << "the limit holds springs that have no stiffness";
}

TEST(CountSubsteps, AsTheWholeWeightOnOnePointAsks) {
  ClothSpec spec = square_spec(50, 0);
  spec.material.strain_limit = 0.1;
  const Cloth cloth = make_grid(spec);
  // All on one spring: omega^2 = M g / (m l) = 2500 * 9.8 * 49, for which h omega <= 4.4 is
  // required.
  const double steps = std::sqrt(2500 * 9.8 * 49) / 90 / 4.4;
  const auto count = [&](int least) {
    return count_substeps(cloth, Vector3(0, 0, -9.8), cloth.rest_positions, 2, 1.0 / 90, least);
  };
  EXPECT_EQ(count(1), std::ceil(steps));
  EXPECT_EQ(count(9), 9);
}

TEST(CountSubsteps, OneWithoutAStabilityLimitUnlessTensionAsksForMore) {
  const double infinite = std::numeric_limits<double>::infinity();
  ClothSpec spec = square_spec(8, 4e6);
  const auto count = [&](double limit) {
    const Cloth cloth = make_grid(spec);
    return count_substeps(cloth, Vector3(0, 0, -9.8), cloth.rest_positions, limit, 0.4);
  };
  EXPECT_EQ(count(infinite), 1);
  spec.material.ks = 0;
  spec.material.strain_limit = 0.1;
  EXPECT_GT(count(infinite), 5);
  EXPECT_EQ(count(infinite), count(2)) << "tension is the same for all methods";
}

}  // namespace
}  // namespace clothsim::substeps_test
