// Cases in which the method must fail, and the failure is caught.

#include <cmath>

#include "clothsim/dynamics/stretch.h"
#include "clothsim/model/errors.h"
#include "verification/testing.h"

namespace clothsim::stability_test {
namespace {

using namespace test;

/// An upright cloth of 5 x 5 points, free, without gravity, whose start is uneven by up to 1 mm.
Scene floating() {
  Scene scene;
  scene.cloth = square_spec(5);
  scene.cloth.orientation = Orientation::vertical;
  scene.simulation.gravity = Vector3::Zero();
  return scene;
}

/// Largest frequency of the flat 5 x 5 grid with all springs [rad/s]: by power iteration on the
/// forces themselves, f(x + e) - f(x) = -K e.
double omega_max(const Cloth& cloth) {
  const Loads none{Vector3::Zero()};
  const double small = 1e-6;
  Points e = random_points(cloth.num_points(), 1, 1);
  Points forces;
  double omega2 = 0;
  for (int i = 0; i < 3000; ++i) {
    e *= small / e.norm();
    compute_forces(cloth, none, cloth.rest_positions + e, forces);
    e = cloth.inv_mass.asDiagonal() * forces;
    omega2 = e.norm() / small;
  }
  return std::sqrt(omega2);
}

/// The scene with one substep a frame, and frames of `share` of Verlet's limit.
Scene at_share_of_limit(double share) {
  Scene scene = floating();
  const double omega = omega_max(make_grid(scene.cloth));
  scene.simulation.substeps = 1;
  scene.simulation.method = VelocityVerlet::name;
  scene.simulation.frames_per_second = omega / (share * VelocityVerlet::stability_limit);
  return scene;
}

TEST(StabilityLimit, StableJustBelow) {
  Simulator simulator(at_share_of_limit(0.98));
  double farthest_off = 0;
  for (int frame = 0; frame < 20000; ++frame) {
    simulator.step();
    farthest_off = std::max(
        farthest_off, farthest(simulator.state().positions, simulator.cloth().rest_positions));
  }
  // The start is up to 1 mm off.
  EXPECT_LT(farthest_off, 5e-3);
}

TEST(StabilityLimit, BlowsUpJustAboveAndKeepsTheLastGoodFrame) {
  Simulator simulator(at_share_of_limit(1.02));
  State last = simulator.state();
  bool diverged = false;
  for (int frame = 0; frame < 200000 && !diverged; ++frame) {
    try {
      simulator.step();
      ASSERT_TRUE(simulator.state().positions.allFinite());
      ASSERT_TRUE(simulator.state().velocities.allFinite());
      last = simulator.state();
    } catch (const Diverged& error) {
      diverged = true;
      EXPECT_NE(std::string(error.what()).find("verlet"), std::string::npos) << error.what();
    }
  }
  ASSERT_TRUE(diverged);
  // Before it shows: the start is uneven by 1 mm, which stretches springs by a hundredth of that.
  EXPECT_LT(worst_stretch(simulator.cloth(), last.positions), 0.02);
  EXPECT_EQ(simulator.state().positions, last.positions);
  EXPECT_EQ(simulator.state().velocities, last.velocities);
  EXPECT_EQ(simulator.state().time, last.time);

  // The step is refused again, and a reset with a smaller step runs.
  EXPECT_THROW(simulator.step(), Diverged);
  simulator.reset();
  SimulationSpec simulation = simulator.scene().simulation;
  simulation.substeps = 2;
  simulator.set_simulation(simulation);
  run(simulator, 2);
  EXPECT_LT(farthest(simulator.state().positions, simulator.cloth().rest_positions), 5e-3);
}

TEST(StabilityLimit, AStrainLimitHidesNoBlowUp) {
  Scene scene = shipped_scene("pinned2");
  scene.simulation.method = VelocityVerlet::name;
  scene.simulation.substeps = 1;
  Simulator simulator(scene);
  double worst = 0;
  EXPECT_THROW(
      for (int frame = 0; frame < 90;
           ++frame) { worst = std::max(worst, simulator.step().worst_stretch); },
      Diverged);
  EXPECT_LT(worst, 0.5);
}

TEST(StabilityLimit, AutomaticSubstepsAreStableWhereverTheMaterialIs) {
  for (const double ks : {5.0, 5e4, 5e7}) {
    for (const double density : {0.15, 1500.0}) {
      Scene scene = floating();
      scene.cloth.material.ks = ks;
      scene.cloth.material.density = density;
      Simulator simulator(scene);
      const int frames = ks / density > 1e7 ? 9 : 90;
      for (int frame = 0; frame < frames; ++frame) simulator.step();
      EXPECT_LT(farthest(simulator.state().positions, simulator.cloth().rest_positions), 5e-3)
          << "ks " << ks << ", density " << density;
    }
  }
}

TEST(Stability, SurvivesDegenerateStarts) {
  // Set to rest lengths that do not fit: pins 3 times as far apart, or in one place.
  for (const double scale : {3.0, 0.0}) {
    Scene scene;
    scene.cloth.columns = scene.cloth.rows = 12;
    scene.cloth.pinned = {{0, 0, ""}, {11, 0, ""}};
    Simulator simulator(scene);
    simulator.move_pin(1, scale * Vector3(1, 0, 0) + Vector3(0, 0, 1));
    for (int frame = 0; frame < 180; ++frame) {
      simulator.step();
      ASSERT_TRUE(simulator.state().positions.allFinite()) << scale;
      ASSERT_LT(max_speed(simulator.state()), 1e3) << scale;
    }
    // Moved back to rest lengths that fit, it rests within its limit.
    simulator.move_pin(1, Vector3(1, 0, 1));
    run(simulator, 5);
    EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105) << scale;
  }
}

TEST(Stability, MaterialChangedEveryFrame) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.pinned = {{0, 0, ""}, {11, 0, ""}};
  Simulator simulator(scene);
  for (int frame = 0; frame < 270; ++frame) {
    Material material;
    material.ks = frame % 2 == 0 ? 50 : 50000;
    material.density = frame % 3 == 0 ? 15 : 1500;
    material.damping = frame % 5 == 0 ? 0 : 27;
    simulator.set_material(material);
    simulator.step();
    ASSERT_TRUE(simulator.state().positions.allFinite()) << frame;
    ASSERT_LT(max_speed(simulator.state()), 100) << frame;
  }
}

}  // namespace
}  // namespace clothsim::stability_test
