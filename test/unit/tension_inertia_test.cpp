#include "clothsim/constraints/tension_inertia.h"

#include <gtest/gtest.h>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/model/grid.h"
#include "verification/testing.h"

namespace clothsim::tension_inertia_test {
namespace {

using namespace test;

const Vector3 no_gravity(0, 0, 0);

ClothSpec limited(ClothSpec spec) {
  spec.material.strain_limit = 0.1;
  return spec;
}

/// One step of a cloth at its strain limit, as in the simulator.
struct Stepper {
  explicit Stepper(const Cloth& of) : cloth(of), cloth_with_tension_mass(of), limit(of) {}

  void step(const Vector3& gravity, double h, State& state) {
    const double displacement_factor = VelocityVerlet::displacement_factor(cloth.damping, h);
    limit.inertia().add_tension_mass(cloth, h, state, cloth_with_tension_mass.inv_mass);
    method.step(cloth_with_tension_mass, Loads{gravity}, h, state);
    limit.warm_start(h, displacement_factor, state);
    limit.solve(cloth_with_tension_mass, displacement_factor, 1e-9, 4, 400, state);
    limit.inertia().give_back(cloth, h, displacement_factor, state);
    limit.learn_tension();
  }

  const Cloth& cloth;
  Cloth cloth_with_tension_mass;
  StrainLimit limit;
  VelocityVerlet method;
};

TEST(TensionInertia, IsThatOfTheWeightOnAString) {
  // It is 0.4 h^2 sum(T / l). A spring carries m g: T / l = m g / (1.1 L0). Two masses: 2 m g
  // above, m g below the upper one.
  const double h = 1e-3;
  for (const int masses : {1, 2}) {
    ClothSpec spec = limited(chain_spec(masses + 1, 1, 0, Orientation::vertical));
    spec.pinned = {{0, masses, ""}};
    const Cloth cloth = make_grid(spec);
    State state{cloth.rest_positions, Points::Zero(masses + 1, 3), 0};
    const double top = cloth.rest_positions(masses, 2);
    for (int i = 0; i <= masses; ++i) {
      state.positions(i, 2) = top - 1.1 * (top - cloth.rest_positions(i, 2));
    }
    Stepper stepper(cloth);
    EXPECT_EQ(stepper.limit.inertia().mass_ratio(h), 0);
    for (int step = 0; step < 1000; ++step) stepper.step(Vector3(0, 0, -9.8), h, state);
    const double length = 1.1;
    const double sum = (masses == 1 ? 1 : 2 + 1 + 1) * cloth.mass[0] * 9.8 / length;
    EXPECT_NEAR(stepper.limit.inertia().mass_ratio(h), 0.4 * h * h * sum / cloth.mass.sum(), 1e-9);
    EXPECT_NEAR(stepper.cloth_with_tension_mass.inv_mass[0],
                1 / (cloth.mass[0] * (1 + 0.4 * h * h * 9.8 / length)), 1e-6 * cloth.inv_mass[0])
        << "the lowest point";
  }
}

/// Largest velocity of a heavy string that hangs from its upper end, plucked, after many steps of h
/// omega for its upper springs.
double speed_of_string(double h_omega, bool adds_mass) {
  constexpr int n = 40;
  ClothSpec spec = limited(chain_spec(n, 1, 0, Orientation::vertical));
  spec.material.damping = 1;
  spec.pinned = {{0, n - 1, ""}};
  const Cloth cloth = make_grid(spec);
  // Two springs meet at a point, T = n m g: omega^2 = 4 T / (m l) of neighbours against each other.
  const double length = 1.1;
  const double h = h_omega / std::sqrt(4 * n * 9.8 / length);
  State state{cloth.rest_positions, Points::Zero(n, 3), 0};
  const double top = cloth.rest_positions(n - 1, 2);
  for (int i = 0; i < n; ++i) {
    state.positions(i, 2) = top - 1.1 * (top - cloth.rest_positions(i, 2));
    state.velocities(i, 0) = i + 1 < n ? 1e-3 * (i % 2 == 0 ? 1 : -1) : 0;
  }
  Stepper stepper(cloth);
  for (int step = 0; step < 3000; ++step) {
    if (!adds_mass) stepper.limit.inertia().reset();
    stepper.step(Vector3(0, 0, -9.8), h, state);
  }
  return max_speed(state);
}

TEST(TensionInertia, MakesStepsStableThatTensionWouldBreak) {
  EXPECT_LT(speed_of_string(1.6, false), 0.01) << "a step that follows";
  EXPECT_GT(speed_of_string(4, false), 0.1) << "a step that does not, without";
  for (const double h_omega : {1.6, 3.0, 4.4}) {  // h^2 sum(T / l) / m = (h omega)^2 / 2 < 10
    EXPECT_LT(speed_of_string(h_omega, true), 0.01) << h_omega;
  }
}

TEST(TensionInertia, LeavesMomentumAndAngularMomentumOfAFreeClothAlone) {
  ClothSpec spec = limited(square_spec(10, 5));
  spec.material.damping = 0;
  const Cloth cloth = make_grid(spec);
  State state{1.1 * cloth.rest_positions, random_points(cloth.num_points(), 0.5, 2), 0};
  const Vector3 centre = state.positions.colwise().mean().transpose();
  for (int i = 0; i < cloth.num_points(); ++i) {
    state.velocities.row(i) +=
        20 * Vector3(0.3, 0.2, 1).cross(row(state.positions, i) - centre).transpose();
  }
  const Vector3 p = momentum(cloth, state), l = angular_momentum(cloth, state);
  Stepper stepper(cloth);
  double most = 0;
  const double h = 4e-3;
  for (int step = 0; step < 200; ++step) {
    stepper.step(no_gravity, h, state);
    most = std::max(most, stepper.limit.inertia().mass_ratio(h));
    ASSERT_LT((momentum(cloth, state) - p).norm(), 1e-12 * cloth.mass.sum() * max_speed(state));
    ASSERT_LT((angular_momentum(cloth, state) - l).norm(), 1e-12 * l.norm()) << step;
  }
  EXPECT_GT(most, 0.01) << "it has no part in this";
}

TEST(TensionInertia, AFreeClothFallsAsEver) {
  // Taut from a stretch in the fall: its centre of mass falls by g t^2 / 2.
  ClothSpec spec = limited(square_spec(10, 5));
  spec.material.damping = 0;
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, 4 * cloth.rest_positions, 0};
  const double start = state.positions.col(2).mean(), speed = state.velocities.col(2).mean();
  Stepper stepper(cloth);
  const double h = 4e-3;
  for (int step = 0; step < 100; ++step) stepper.step(Vector3(0, 0, -9.8), h, state);
  EXPECT_NEAR(state.positions.col(2).mean(), start + speed * 0.4 - 9.8 * 0.4 * 0.4 / 2, 1e-11);
}

}  // namespace
}  // namespace clothsim::tension_inertia_test
