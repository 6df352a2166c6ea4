// Cases in which methods fail: they do fail, and the failure is caught.

#include <cmath>

#include "clothsim/dynamics/energy.h"
#include "clothsim/model/errors.h"
#include "verification/testing.h"

namespace clothsim::stability_suite_test {
namespace {

using namespace test;

// ---- Step ladder: half to fifty times Verlet's limit, by every method

class StepLadder : public ::testing::TestWithParam<std::string> {};

/// An upright, free cloth of 5 x 5 points, uneven by 1 mm, that takes one step of `share` of
/// Verlet's limit 2 / omega_max a frame.
Scene ladder_scene(const std::string& method, double share) {
  Scene scene;
  scene.cloth = square_spec(5);
  scene.cloth.orientation = Orientation::vertical;
  scene.simulation.gravity = Vector3::Zero();
  scene.simulation.method = method;
  scene.simulation.substeps = 1;
  // omega_max^2 = 8 k / m is exact for an endless grid only: by power iteration on the forces.
  const Cloth cloth = make_grid(scene.cloth);
  const Loads none{Vector3::Zero()};
  Points e = random_points(cloth.num_points(), 1, 1);
  Points forces;
  double omega2 = 0;
  for (int i = 0; i < 3000; ++i) {
    e *= 1e-6 / e.norm();
    compute_forces(cloth, none, cloth.rest_positions + e, forces);
    e = cloth.inv_mass.asDiagonal() * forces;
    omega2 = e.norm() / 1e-6;
  }
  scene.simulation.frames_per_second = std::sqrt(omega2) / (2 * share);
  return scene;
}

/// Whether 3000 frames pass without Diverged, with every state finite and near its rest.
bool survives(const Scene& scene) {
  Simulator simulator(scene);
  try {
    for (int frame = 0; frame < 3000; ++frame) {
      simulator.step();
      EXPECT_TRUE(simulator.state().positions.allFinite());
      EXPECT_TRUE(simulator.state().velocities.allFinite());
    }
  } catch (const Diverged& error) {
    EXPECT_NE(std::string(error.what()).find(scene.simulation.method), std::string::npos);
    EXPECT_TRUE(simulator.state().positions.allFinite());
    EXPECT_TRUE(simulator.state().velocities.allFinite());
    return false;
  }
  EXPECT_LT(farthest(simulator.state().positions, simulator.cloth().rest_positions), 5e-3);
  return true;
}

TEST_P(StepLadder, FailsWhereTheorySaysAndIsCaught) {
  const double limit =
      std::visit([](const auto& m) { return m.stability_limit; }, make_integrator(GetParam()));
  if (std::isinf(limit)) {
    for (const double share : {0.5, 1.0, 2.0, 50.0}) {
      EXPECT_TRUE(survives(ladder_scene(GetParam(), share))) << share;
    }
  } else {
    for (const double share : {0.5, 0.95}) {
      EXPECT_TRUE(survives(ladder_scene(GetParam(), share * limit / 2))) << share;
    }
    for (const double share : {1.05, 2.0}) {
      EXPECT_FALSE(survives(ladder_scene(GetParam(), share * limit / 2))) << share;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, StepLadder, ::testing::ValuesIn(method_names()),
                         [](const auto& test) { return test.param; });

// ---- Recovery: `auto` where the same method would end in Diverged

/// A sheet held along all its edges, with as few substeps as are stable while it is flat.
Scene taut(const std::string& method) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 12;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      const bool edge = row == 0 || column == 0 || row == 11 || column == 11;
      if (edge) scene.cloth.pinned.push_back({column, row, ""});
    }
  }
  scene.cloth.material.strain_limit.reset();
  scene.cloth.material.ks = 3700;
  scene.cloth.material.damping = 20;
  scene.simulation.substeps = 1;
  scene.simulation.method = method;
  return scene;
}

/// Pulls the edges to `stretch` times their size within a frame: springs become as stiff across as
/// along, the whole half as stiff again.
void pull(Simulator& simulator, double stretch) {
  const std::vector<Pin>& pins = simulator.scene().cloth.pinned;
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const Points& rest = simulator.cloth().rest_positions;
    const Vector3 p = rest.row(pins[i].row * 12 + pins[i].column).transpose();
    simulator.move_pin(static_cast<int>(i), {stretch * p.x(), stretch * p.y(), p.z()});
  }
}

TEST(Recovery, AnUnstableMethodIsTakenBackAndChanged) {
  Simulator simulator(taut("auto"));
  pull(simulator, 2);
  int recovered_at = -1;
  for (int frame = 0; frame < 300; ++frame) {
    const StepReport report = simulator.step();
    ASSERT_LT(max_speed(simulator.state()), 500) << frame;
    if (report.recoveries == 0) continue;
    EXPECT_EQ(recovered_at, -1) << "twice";
    recovered_at = frame;
    EXPECT_EQ(report.method, "implicit_euler");
    EXPECT_EQ(report.reasons.text(), "a frame failed with verlet");
    EXPECT_TRUE(report.reasons.has(Reason::method_failed));
  }
  RecordProperty("recovered_at_frame", recovered_at);
  EXPECT_GT(recovered_at, 0);
  EXPECT_LT(recovered_at, 30);
  EXPECT_LT(rms_velocity(simulator.state()), 1e-6) << "it rests";

  // A reset starts over with the method that fits the start.
  simulator.reset();
  EXPECT_EQ(simulator.step().method, "verlet");
}

TEST(Recovery, ReportsWhatTheLastAttemptDid) {
  // On a floor, so that there are passes over contacts: the report leaves out those of the attempt
  // that was taken back.
  Scene scene = taut("auto");
  scene.cloth.pin_strength = strength_range.max;  // no pin slips in a frame that is repeated
  ColliderSpec floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.pose.position = Vector3(0, 0, 0.999);
  scene.colliders = {floor};
  Simulator simulator(scene);
  pull(simulator, 2);
  for (int frame = 0; frame < 300; ++frame) {
    const State before = simulator.state();
    const StepReport report = simulator.step();
    if (report.recoveries == 0) continue;
    ASSERT_EQ(report.method, "implicit_euler");
    Scene by_fallback = scene;
    by_fallback.simulation.method = report.method;
    Simulator other(by_fallback);
    pull(other, 2);
    other.step();
    other.set_state(before);
    const StepReport alone = other.step();
    EXPECT_GT(alone.sweeps, 0);
    EXPECT_EQ(report.sweeps, alone.sweeps);
    EXPECT_EQ(simulator.state().positions, other.state().positions);
    return;
  }
  FAIL() << "no frame failed";
}

TEST(Recovery, ANamedMethodEndsWithATypedError) {
  Simulator simulator(taut("verlet"));
  pull(simulator, 2);
  State last = simulator.state();
  const auto run_on = [&] {
    for (int frame = 0; frame < 300; ++frame) {
      simulator.step();
      last = simulator.state();
    }
  };
  EXPECT_THROW(run_on(), Diverged);
  EXPECT_EQ(simulator.state().positions, last.positions);
  EXPECT_LT(max_speed(last), 500);
}

TEST(Recovery, WhereNothingHelpsItEndsWithATypedError) {
  // The cloth falls beyond the range of its numbers, for any substeps and method.
  Scene scene;
  scene.cloth = square_spec(5, 5);
  scene.simulation.gravity = Vector3(0, 0, -1e6);
  scene.simulation.frames_per_second = 1e-3;
  Simulator simulator(scene);
  try {
    for (int frame = 0; frame < 3; ++frame) simulator.step();
    FAIL() << "no error";
  } catch (const Diverged& error) {
    EXPECT_NE(std::string(error.what()).find("implicit_euler"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(simulator.state().positions.allFinite());
}

}  // namespace
}  // namespace clothsim::stability_suite_test
