// The same scene gives the same bits: again, after a reset, and after values were changed and
// restored.

#include "verification/testing.h"

namespace clothsim::determinism_test {
namespace {

using namespace test;

class Bits : public ::testing::TestWithParam<const char*> {};

void expect_same(const State& a, const State& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.velocities, b.velocities);
  EXPECT_EQ(a.time, b.time);
}

TEST_P(Bits, AreTheSameEveryTime) {
  const Scene scene = shipped_scene(GetParam());
  const double seconds = 1;
  Simulator first(scene);
  run(first, seconds);
  const State expected = first.state();

  Simulator second(scene);
  run(second, seconds);
  expect_same(second.state(), expected);

  // With other values for a while, which leave no trace.
  second.reset();
  Material material = scene.cloth.material;
  material.ks = 700;
  material.density = 40;
  material.damping = 1;
  material.strain_limit.reset();
  material.springs = {true, false, false};
  second.set_material(material);
  SimulationSpec simulation = scene.simulation;
  simulation.gravity = Vector3(1, 2, -3);
  simulation.frames_per_second = 60;
  second.set_simulation(simulation);
  run(second, 0.2);
  second.set_material(scene.cloth.material);
  second.set_simulation(scene.simulation);
  second.reset();
  run(second, seconds);
  expect_same(second.state(), expected);
}

INSTANTIATE_TEST_SUITE_P(Shipped, Bits,
                         ::testing::Values("pinned2", "pinned4", "sphere", "plane",
                                           "self_collision"));

}  // namespace
}  // namespace clothsim::determinism_test
