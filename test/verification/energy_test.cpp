// Energy without damping, and the scaling laws that follow from the equation of motion.

#include "clothsim/dynamics/energy.h"

#include <cmath>
#include <string>
#include <tuple>

#include "verification/testing.h"

namespace clothsim::energy_test {
namespace {

using namespace test;

TEST(Verlet, EnergyStaysBoundedAndItsErrorGoesWithTheSquareOfTheStep) {
  // A symplectic method keeps a nearby energy: the error swings, by C h^2, and does not drift. The
  // cloth swings between four corners: its motion stays regular. From two it crumples, and then the
  // last bit decides how much energy changes by a spring that passes through zero length.
  ClothSpec spec = square_spec(5, 2000);
  spec.pinned = {{0, 0, ""}, {4, 0, ""}, {0, 4, ""}, {4, 4, ""}};
  const Cloth cloth = make_grid(spec);
  const Loads loads;
  struct Error {
    double early = 0;  // largest error in the first quarter [J]
    double late = 0;   // and in the last
  };
  const auto energy_error = [&](double h) {
    State state = start_state(spec, cloth, 1);
    const double before = total_energy(cloth, loads, state);
    VelocityVerlet method;
    const int steps = static_cast<int>(std::lround(20 / h));
    Error error;
    for (int n = 0; n < steps; ++n) {
      method.step(cloth, loads, h, state);
      const double now = std::abs(total_energy(cloth, loads, state) - before);
      if (n < steps / 4) error.early = std::max(error.early, now);
      if (n >= steps - steps / 4) error.late = std::max(error.late, now);
    }
    return error;
  };
  const double weight = cloth.mass.sum() * 9.8;
  const Error coarse = energy_error(2e-3);
  const Error fine = energy_error(1e-3);
  RecordProperty("error_2ms", std::to_string(coarse.early));
  RecordProperty("error_1ms", std::to_string(fine.early));
  EXPECT_LT(fine.early, 1e-3 * weight);
  EXPECT_LT(coarse.late, 2 * coarse.early);
  EXPECT_LT(fine.late, 2 * fine.early);
  EXPECT_NEAR(std::log2(coarse.early / fine.early), 2, 0.2);
}

TEST(Verlet, EnergyDoesNotDriftOverALongTime) {
  // 200,000 steps at a tenth of the stability limit: the error stays within (omega_max h)^2 / 8 of
  // the energy that swings, at most the weight times 1 m, and its mean does not drift.
  ClothSpec spec = square_spec(4, 2000);
  spec.material.density = 15;
  spec.pinned = {{0, 0, ""}, {3, 0, ""}};
  const Cloth cloth = make_grid(spec);
  const Loads loads;
  State state = start_state(spec, cloth, 1);
  const double before = total_energy(cloth, loads, state);
  const double omega_h = 0.1 * VelocityVerlet::stability_limit;
  const double h = omega_h / std::sqrt(8 * spec.material.ks / cloth.mass[0]);
  const int steps = 200000;
  const int window = steps / 4;
  VelocityVerlet method;
  double worst = 0;
  double first = 0;  // mean error in the first quarter
  double last = 0;   // and in the last
  for (int n = 0; n < steps; ++n) {
    method.step(cloth, loads, h, state);
    const double error = total_energy(cloth, loads, state) - before;
    worst = std::max(worst, std::abs(error));
    if (n < window) first += error / window;
    if (n >= steps - window) last += error / window;
  }
  const double bound = omega_h * omega_h / 8 * cloth.mass.sum() * 9.8;
  RecordProperty("worst_of_bound", std::to_string(worst / bound));
  RecordProperty("drift_of_bound", std::to_string((last - first) / bound));
  EXPECT_LT(worst, bound);
  EXPECT_LT(std::abs(last - first), 0.1 * bound);
}

/// Shape below the falling cloth, points along its side and method.
using Fall = std::tuple<const char*, int, const char*>;

class StiffLightFall : public ::testing::TestWithParam<Fall> {};

TEST_P(StiffLightFall, GainsNoEnergyWhereItLands) {
  // 0.3 m deep, without drag: it may lose energy and never exceed that of the start.
  const auto& [name, side, method] = GetParam();
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.material.ks = 50000;
  scene.cloth.material.density = 1;
  scene.cloth.material.damping = 0;
  scene.simulation.method = method;
  Shape shape = Sphere{0.2};
  if (std::string(name) == "box") shape = Cuboid{{0.4, 0.4, 0.4}};
  ColliderSpec below;
  below.name = name;
  below.shape = shape;
  below.pose.position = Vector3(0.5, 0.5, 0.5);
  scene.colliders = {below};
  Simulator simulator(scene);
  const Loads loads{scene.simulation.gravity};
  const auto energy = [&] { return total_energy(simulator.cloth(), loads, simulator.state()); };
  const double before = energy();
  const double of_impact = simulator.cloth().mass.sum() * loads.gravity.norm() * 0.3;
  double gained = -before;
  for (int frame = 0; frame < 90; ++frame) {
    simulator.step();
    gained = std::max(gained, energy() - before);
  }
  EXPECT_LT(gained, 0.01 * of_impact);
  EXPECT_LT(energy(), before - 0.1 * of_impact) << "it has not landed";
}

INSTANTIATE_TEST_SUITE_P(Shapes, StiffLightFall,
                         ::testing::Values(Fall{"sphere", 13, "auto"}, Fall{"box", 13, "auto"},
                                           Fall{"sphere", 25, "auto"}, Fall{"box", 25, "auto"},
                                           Fall{"sphere", 31, "verlet"},
                                           Fall{"box", 21, "verlet"}));

TEST(Scaling, TwiceTheDensityIsHalfTheStiffness) {
  // m x'' = F - c m x': only k / m counts, so (2 rho, k) moves, and rests, as (rho, k / 2). Powers
  // of two scale without rounding, so the bits are the same.
  const auto shape = [](double density, double ks) {
    Scene scene;
    scene.cloth = square_spec(12, ks);
    scene.cloth.material.density = density;
    scene.cloth.material.damping = 8;
    scene.cloth.pinned = {{0, 0, ""}, {11, 0, ""}};
    Simulator simulator(scene);
    run(simulator, 8);
    EXPECT_LT(rms_velocity(simulator.state()), 1e-4);
    return simulator.state().positions;
  };
  const Points heavy = shape(20, 500);
  const Points soft = shape(10, 250);
  const Points other = shape(10, 500);
  EXPECT_EQ(heavy, soft);
  EXPECT_GT(farthest(heavy, other), 0.02) << "the shape does not depend on k / m at all";
}

}  // namespace
}  // namespace clothsim::energy_test
