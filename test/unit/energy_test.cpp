#include "clothsim/dynamics/energy.h"

#include <cmath>

#include "verification/testing.h"

namespace clothsim::energy_test {
namespace {

using namespace test;

/// Three masses of 1 kg in a row along y, 1 m apart, k = 8 N/m, the first pinned.
Cloth three_masses() {
  ClothSpec spec = chain_spec(3, 1, 8);
  spec.pinned = {{0, 0, ""}};
  return make_grid(spec);
}

TEST(Energy, KineticCountsFreePoints) {
  const Cloth cloth = three_masses();
  State state{cloth.rest_positions, Points::Zero(3, 3), 0};
  state.velocities.row(0) << 100, 0, 0;  // a pin that moves
  state.velocities.row(1) << 1, 2, 2;
  state.velocities.row(2) << 0, 0, 1;
  EXPECT_NEAR(kinetic_energy(cloth, state), (9 + 1) / 2.0, 1e-12);
}

TEST(Energy, ElasticIsHalfKStretchSquared) {
  const Cloth cloth = three_masses();
  Points x = cloth.rest_positions;
  EXPECT_NEAR(elastic_energy(cloth, x), 0, 1e-15);
  x(2, 1) += 0.5;
  EXPECT_NEAR(elastic_energy(cloth, x), 8 * 0.25 / 2, 1e-12);
  x.row(1) = x.row(0);  // a spring of no length is shorter by its whole rest length
  EXPECT_NEAR(elastic_energy(cloth, x), 8 * 1 / 2.0 + 8 * 1.5 * 1.5 / 2, 1e-12);
}

TEST(Energy, GravitationalIsTheWorkAgainstGravity) {
  const Cloth cloth = three_masses();
  Points x = cloth.rest_positions;
  x.row(0) << 0, 0, 50;  // pinned: not counted
  x.row(1) << 3, 1, 2;
  x.row(2) << 0, 2, -1;
  EXPECT_NEAR(gravitational_energy(cloth, Vector3(0, 0, -9.8), x), 9.8 * (2 - 1), 1e-12);
  EXPECT_NEAR(gravitational_energy(cloth, Vector3(2, -1, 0), x), -(2 * 3) + (1 + 2), 1e-12);
}

TEST(Energy, RmsVelocityIsOverAllPoints) {
  State state{Points::Zero(4, 3), Points::Zero(4, 3), 0};
  state.velocities.row(2) << 1, 2, 2;
  EXPECT_DOUBLE_EQ(rms_velocity(state), std::sqrt(9 / 4.0));
}

}  // namespace
}  // namespace clothsim::energy_test
