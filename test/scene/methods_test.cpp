// The shipped scenes with every method of the list.

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "verification/testing.h"

namespace clothsim::methods_test {
namespace {

using namespace test;

struct Run {
  std::string scene;
  std::string method;
};

std::ostream& operator<<(std::ostream& out, const Run& r) {
  return out << r.scene << ", " << r.method;
}

std::vector<Run> runs() {
  std::vector<Run> all;
  for (const char* scene : {"pinned2", "sphere", "self_collision"}) {
    for (const std::string& method : method_names()) all.push_back({scene, method});
  }
  return all;
}

/// On a cloth of few points, which keeps the test short.
Scene small(const Run& r, int side = 16) {
  Scene scene = shipped_scene(r.scene);
  for (Pin& pin : scene.cloth.pinned) {
    pin.column = pin.column * (side - 1) / (scene.cloth.columns - 1);
    pin.row = pin.row * (side - 1) / (scene.cloth.rows - 1);
  }
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.thickness *= 3;
  scene.simulation.method = r.method;
  return scene;
}

class EveryMethodOn : public ::testing::TestWithParam<Run> {};

TEST_P(EveryMethodOn, RunsAndKeepsItsConstraints) {
  Simulator simulator(small(GetParam()));
  const double tolerance = simulator.scene().simulation.strain_tolerance;
  StepReport report;
  for (int frame = 0; frame < 60; ++frame) {
    report = simulator.step();
    ASSERT_TRUE(simulator.state().positions.allFinite()) << frame;
    ASSERT_TRUE(simulator.state().velocities.allFinite()) << frame;
    ASSERT_LT(max_speed(simulator.state()), 50) << frame;
  }
  EXPECT_EQ(report.method, GetParam().method);
  // Repairs of contact come last and may stretch springs a little.
  EXPECT_LT(report.worst_stretch, 0.1 + 5 * tolerance);
  EXPECT_GE(simulator.state().positions.col(2).minCoeff(), -1e-3);
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryMethodOn, ::testing::ValuesIn(runs()));

TEST(ChosenMethod, ComesToRestOnASphereWhateverTheTolerance) {
  // Without strain limit, where faces touch and springs alone hold the cloth. There classical
  // Runge-Kutta creeps for ever; XPBD and BDF2 with one substep tremble. In the sixth second a
  // wrinkle may still slip, by millimetres.
  for (const double tolerance : {0.1, 1e-2, 1e-3, 1e-8}) {
    Scene scene = small({"sphere", "auto"});
    scene.cloth.material.strain_limit.reset();
    scene.simulation.tolerance = tolerance;
    Simulator simulator(scene);
    run(simulator, 6);
    EXPECT_LT(rms_velocity(simulator.state()), 1e-3) << tolerance;
    run(simulator, 2);
    const Points before = simulator.state().positions;
    const StepReport report = run(simulator, 1);
    EXPECT_LT(rms_velocity(simulator.state()), 1e-4) << report.method << ", " << tolerance;
    EXPECT_LT(farthest(simulator.state().positions, before), 1e-4) << tolerance;
    EXPECT_GT(report.contacts, 0) << tolerance;  // and has not slid off
  }
}

TEST(ChosenMethod, BringsClothFarStifferThanHeavyToRest) {
  // `auto` takes xpbd, whose passes would feed fast waves if they all went in one direction.
  for (const bool lies : {true, false}) {
    SCOPED_TRACE(lies ? "on a ball" : "hanging");
    Scene scene = small({lies ? "sphere" : "pinned2", "auto"}, 9);
    scene.cloth.material.ks = 3.3e8;
    scene.cloth.material.density = 0.0017;
    Simulator simulator(scene);
    EXPECT_EQ(run(simulator, 3).method, "xpbd");
    EXPECT_LT(rms_velocity(simulator.state()), 3e-3);
  }
}

TEST(ManyMethods, GiveOneRestShape) {
  // The rest shape does not depend on the scheme: with the strain limit, which works by impulses.
  const auto rest = [](const std::string& method) {
    Simulator simulator(small({"pinned2", method}, 10));
    run(simulator, 6);
    return simulator.state().positions;
  };
  const Points expected = rest("verlet");
  for (const std::string& method : method_names()) {
    if (method == Xpbd::name) continue;  // one iteration a step has a rest shape of its own
    EXPECT_LT(farthest(rest(method), expected), 5e-3) << method;
  }
}

}  // namespace
}  // namespace clothsim::methods_test
