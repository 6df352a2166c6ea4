// Impossible starts, with `auto`: the cloth must recover its shape.

#include "hanging.h"

namespace clothsim::wild_starts_test {
namespace {

using namespace test;

/// The hanging cloth at rest, then with its free points moved by `put`, at rest there; checked 8 s
/// later.
template <typename Put>
State after_start_from(Put&& put) {
  Simulator simulator(hanging());
  run(simulator, 4);
  const State rest = simulator.state();
  State start = rest;
  start.velocities.setZero();
  for (int i = 0; i < start.positions.rows(); ++i) {
    if (simulator.cloth().inv_mass[i] > 0) start.positions.row(i) = put(rest, i).transpose();
  }
  simulator.set_state(start);
  run_undriven(simulator, 8);
  expect_rest(simulator, 0.02);
  return simulator.state();
}

Vector3 point(const State& state, int i) { return state.positions.row(i).transpose(); }

TEST(WildStart, ScrambledInABox) {
  const Points random = random_points(400, 0.2, 7);
  after_start_from([&](const State&, int i) {
    return Vector3(Vector3(0.5, 0, 0.6) + random.row(i).transpose());
  });
}

TEST(WildStart, FlattenedToAPlane) {
  after_start_from(
      [](const State& rest, int i) { return Vector3(point(rest, i).x(), 0, point(rest, i).z()); });
}

TEST(WildStart, FlattenedToALine) {
  after_start_from([](const State& rest, int i) { return Vector3(point(rest, i).x(), 0, 0.9); });
}

TEST(WildStart, AllInOnePoint) {
  // No spring has a direction except those at the pins, which pull out as much as they can.
  Simulator simulator(hanging());
  State start = simulator.state();
  for (int i = 0; i < start.positions.rows(); ++i) {
    if (simulator.cloth().inv_mass[i] > 0) start.positions.row(i) << 0.5, 0, 0.8;
  }
  simulator.set_state(start);
  run_undriven(simulator, 8);
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105);
}

TEST(WildStart, PairsInOnePlace) {
  // Every second point at the place of its neighbour.
  after_start_from(
      [](const State& rest, int i) { return point(rest, i % 20 == 0 ? i : i - i % 2); });
}

}  // namespace
}  // namespace clothsim::wild_starts_test
