#include "clothsim/simulation/substeps.h"

#include <cmath>
#include <limits>
#include <optional>

#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

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
  EXPECT_GT(count(0.1), 5) << "the limit holds springs that have no stiffness";
}

TEST(CountSubsteps, FollowsTheTensionUpToAllOfTheWeight) {
  const auto under = [](double weight, double frequency, bool touches = false) {
    return substeps_under_tension(weight, {frequency, touches}, 0.0101);
  };
  EXPECT_EQ(under(1000, 0), 5);
  EXPECT_EQ(under(1000, 840), 8);  // h omega <= 1.2
  EXPECT_EQ(under(1000, 1e300), 11);
  EXPECT_EQ(under(0, 1000), 1);
  EXPECT_EQ(under(1000, 0, true), 8);
  EXPECT_EQ(under(1000, 700, true), 15);  // h omega <= 0.5
  EXPECT_EQ(under(1000, 1e300, true), 21);

  ClothSpec spec = square_spec(50, 0);
  spec.material.strain_limit = 0.1;
  const Cloth cloth = make_grid(spec);
  const Vector3 gravity(0, 0, -9.8);
  // All on one spring: omega^2 = M g / (m l) = 2500 * 9.8 * 49.
  EXPECT_NEAR(weight_frequency(cloth, gravity), std::sqrt(2500 * 9.8 * 49), 1e-9);
  const auto count = [&](std::optional<Tension> tension) {
    return count_substeps(cloth, gravity, cloth.rest_positions, 2, 1.0 / 90, tension);
  };
  EXPECT_EQ(count({}), 13);
  EXPECT_EQ(count(Tension{0, false}), 6);
  EXPECT_EQ(count(Tension{0, true}), 9);
}

TEST(CountSubsteps, OneWithoutAStabilityLimitUnlessTensionAsksForMore) {
  const double infinite = std::numeric_limits<double>::infinity();
  ClothSpec spec = square_spec(8, 4e6);
  const auto count = [&](double limit) {
    const Cloth cloth = make_grid(spec);
    return count_substeps(cloth, Vector3(0, 0, -9.8), cloth.rest_positions, limit, 0.1);
  };
  EXPECT_EQ(count(infinite), 1);
  spec.material.ks = 0;
  spec.material.strain_limit = 0.1;
  EXPECT_GT(count(infinite), 5);
  EXPECT_EQ(count(infinite), count(2)) << "tension is the same for all methods";
}

}  // namespace
}  // namespace clothsim
