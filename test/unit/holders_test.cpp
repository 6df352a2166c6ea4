// Pins and grips that are stronger than the cloth stick; weaker ones slip with a constant force and
// come back.

#include "clothsim/constraints/holders.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "clothsim/model/errors.h"
#include "verification/testing.h"

namespace clothsim::holders_test {
namespace {

using namespace test;

constexpr double g = 9.8;  // [m/s^2]

/// Nine points of 1 kg each without springs, drag or strain limit.
Scene loose_points() {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 3;
  scene.cloth.material.density = 9;
  scene.cloth.material.damping = 0;
  scene.cloth.material.springs = {false, false, false};
  scene.cloth.material.strain_limit.reset();
  return scene;
}

/// A hand at the world's origin that holds all points, with a strength in units of their weight.
void hold_all(Simulator& simulator, double strength) {
  std::vector<int> all(9);
  std::iota(all.begin(), all.end(), 0);
  simulator.attach("hand", {}, all, {{}, strength * 9 * g});
}

TEST(Holders, StickWithinTheirStrength) {
  Simulator simulator(loose_points());
  hold_all(simulator, 1.001);
  const Points start = simulator.state().positions;
  const StepReport report = run(simulator, 1);
  EXPECT_EQ(report.lagging, 0);
  EXPECT_TRUE(simulator.state().positions == start);
  EXPECT_NEAR(simulator.holders()[0].force, 9 * g, 1e-9);
  EXPECT_EQ(simulator.holders()[0].lag, 0);
}

TEST(Holders, SlipWithAConstantForce) {
  // m a = m g - S / 9 for each point.
  Simulator simulator(loose_points());
  hold_all(simulator, 0.75);
  run(simulator, 0.2);
  const State before = simulator.state();
  const StepReport report = run(simulator, 0.5);
  const State& after = simulator.state();
  EXPECT_EQ(report.lagging, 9);
  for (int i = 0; i < 9; ++i) {
    const Vector3 change = row(after.velocities, i) - row(before.velocities, i);
    EXPECT_NEAR(change.z(), -0.25 * g * (after.time - before.time), 1e-9) << i;
    EXPECT_NEAR(change.head<2>().norm(), 0, 1e-9) << i;
  }
  const HolderReport hand = simulator.holders()[0];
  EXPECT_NEAR(hand.force, 0.75 * 9 * g, 1e-9);
  EXPECT_NEAR(hand.lag, simulator.cloth().rest_positions(0, 2) - after.positions(0, 2), 1e-12);
  // The wrench is the load of the hand: the same force, downwards.
  const Vector3 force = simulator.grips().at("hand").wrench.force;
  EXPECT_NEAR((force - Vector3(0, 0, -0.75 * 9 * g)).norm(), 0, 1e-9);
}

TEST(Holders, ComeBackAndStickAgain) {
  Scene scene = loose_points();
  scene.simulation.gravity.z() = -4 * g;
  Simulator simulator(scene);
  hold_all(simulator, 3);
  run(simulator, 0.3);
  SimulationSpec floating = simulator.scene().simulation;
  floating.gravity = Vector3::Zero();
  simulator.set_simulation(floating);
  double last = 1;
  for (int frame = 0; frame < 3 * 90 && last > 0; ++frame) {
    simulator.step();
    const double lag = simulator.holders()[0].lag;
    if (frame > 45) {
      EXPECT_LE(lag, last) << frame;
      EXPECT_LT(max_speed(simulator.state()), 2.01) << frame;
    }
    last = lag;
  }
  EXPECT_EQ(last, 0) << "all stick";
  run(simulator, 0.1);
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(simulator.state().positions.row(i), simulator.cloth().rest_positions.row(i)) << i;
  }
}

TEST(Holders, FrictionKeepsWhatLagsWhereItIs) {
  // A pull between 0.9 and 1 of the strength moves a point neither on nor back.
  Simulator simulator(loose_points());
  hold_all(simulator, 0.75);
  run(simulator, 0.2);
  SimulationSpec less = simulator.scene().simulation;
  less.gravity.z() = -0.7 * g;
  simulator.set_simulation(less);
  run(simulator, 2);
  const Points stays = simulator.state().positions;
  run(simulator, 1);
  EXPECT_NEAR((simulator.state().positions - stays).norm(), 0, 1e-12);
  EXPECT_NEAR(simulator.holders()[0].force, 0.7 * 9 * g, 1e-9);
  EXPECT_GT(simulator.holders()[0].lag, 0.01);
}

TEST(Holders, ShareTheirStrengthByLoad) {
  // Half of the points carry nothing, so that the others may use the whole strength.
  Scene scene = loose_points();
  scene.cloth.columns = 2;
  scene.cloth.rows = 1;
  scene.cloth.width = 0.1;
  scene.cloth.height = 20;  // density 9: 9 kg each
  Simulator simulator(scene);
  const double weight = simulator.cloth().mass[0] * g;
  simulator.attach("hand", {}, {0, 1}, {{}, 1.9 * weight});
  EXPECT_EQ(run(simulator, 0.2).lagging, 2) << "each bears 0.95 of its weight";
  EXPECT_NEAR(simulator.holders()[0].force, 1.9 * weight, 1e-9);
}

TEST(Holders, GoOnToTheSameBits) {
  const auto slipping = [] {
    Simulator simulator(loose_points());
    hold_all(simulator, 0.75);
    return simulator;
  };
  Simulator one = slipping(), other = slipping();
  run(one, 0.3);
  other.set_state(one.state(), one.memory());
  run(one, 0.5);
  run(other, 0.5);
  EXPECT_TRUE(one.state().positions == other.state().positions);
  const auto saved = one.save();
  run(one, 0.3);
  const Points there = one.state().positions;
  one.restore(*saved);
  run(one, 0.3);
  EXPECT_TRUE(one.state().positions == there);
}

TEST(Holders, BringBackAPatchThatWasTakenStretched) {
  // Its springs are a little over their limit, and the frame jumps.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 50;
  scene.cloth.pinned = {{0, 0, ""}, {49, 0, ""}};
  Simulator simulator(scene);
  for (int frame = 0; frame < 60; ++frame) simulator.step();
  const Vector3 start = simulator.state().positions.row(1275).transpose();
  for (const Vector3& way : {Vector3(0.15, 0, 0.2), Vector3(0.2, 0, 0.3)}) {
    Simulator copy(scene);
    copy.restore(*simulator.save());
    const auto pose = [&](double share) {
      return Pose{start + share * way, Eigen::Quaterniond::Identity()};
    };
    copy.attach("hand", pose(0), copy.free_points_near(start, 0.03));
    for (const double share : {0.5, 1.0}) {
      copy.move_grip("hand", pose(share));
      copy.step();
    }
    EXPECT_GT(copy.holders().back().lag, 0.01);
    for (int frame = 0; frame < 270; ++frame) copy.step();
    EXPECT_EQ(copy.holders().back().lag, 0);
  }
}

TEST(Holders, HaveAStrengthThatASceneNeedNotName) {
  // Ten weights, plus the force that stretches the springs of a point to their limit: at a corner
  // of the grid three structural and shear springs, and two of bending a fifth as stiff and twice
  // as long.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 11;
  scene.cloth.pinned = {{0, 0, ""}};
  Simulator simulator(scene);
  const double weight = 150 * 9.81;
  const double springs = 0.1 * 5000 * 0.1 * (2 + std::sqrt(2) + 2 * 0.2 * 2);
  EXPECT_NEAR(simulator.holders()[0].strength, 10 * weight + springs, 1e-6);
  EXPECT_EQ(simulator.holders()[0].name, "pin [0, 0]");
}

TEST(Holders, ReadTheirStrengthFromAScene) {
  const auto strengths = [](const std::string& text) {
    std::vector<double> all;
    for (const HolderReport& pin : Simulator(read_scene(YAML::Load(text))).holders()) {
      all.push_back(pin.strength);
    }
    return all;
  };
  const std::string pins = "pinned: [[0, 0], {point: [1, 0], strength: 7}]";
  EXPECT_EQ(strengths("cloth: {columns: 3, rows: 3, pin_strength: 5, " + pins + "}"),
            (std::vector<double>{5, 7}));
  const auto refused = [&](const std::string& cloth, const std::string& message) {
    try {
      strengths("cloth: {columns: 3, rows: 3, " + cloth + "}");
      ADD_FAILURE() << "accepted: " << cloth;
    } catch (const InvalidValue& error) {
      EXPECT_EQ(std::string(error.what()).find(message), 0u) << error.what();
    }
  };
  refused("pin_strength: 0", "cloth.pin_strength: got 0");
  refused("pin_strength: .nan", "cloth.pin_strength: got .nan");
  refused("pinned: [{point: [1, 0], strength: -1}]", "cloth.pinned.0.strength: got -1");
  Simulator simulator(loose_points());
  for (const double strength : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(simulator.attach("hand", {}, {0}, {{}, strength}), InvalidValue);
  }
  EXPECT_TRUE(simulator.grips().empty());
}

}  // namespace
}  // namespace clothsim::holders_test
