// States read from a simulator and set again: the same bits, or a refusal that changes nothing.

#include <cmath>
#include <limits>
#include <vector>

#include "clothsim/model/errors.h"
#include "says.h"
#include "state_testing.h"
#include "verification/testing.h"

namespace clothsim::simulator_state_test {
namespace {

using namespace test;

class States : public ::testing::TestWithParam<std::string> {};

TEST_P(States, GoOnToTheSameBits) {
  Simulator simulator(busy(GetParam()));
  const StepReport report = run(simulator, once);
  ASSERT_GT(report.contacts, 3);
  const State state = simulator.state();
  const std::vector<double> memory = simulator.memory();
  run(simulator, more);
  const State expected = simulator.state();

  simulator.set_state(state, memory);
  expect_same(simulator.state(), state);
  EXPECT_EQ(simulator.memory(), memory);
  run(simulator, more);
  expect_same(simulator.state(), expected);

  // In a simulator that has never run, too.
  Simulator other(busy(GetParam()));
  other.set_state(state, memory);
  run(other, more);
  expect_same(other.state(), expected);

  // The positions and velocities alone do not give it.
  other.set_state(state);
  run(other, more);
  EXPECT_NE(other.state().positions, expected.positions);
}

TEST_P(States, WithoutMemoryGoOnAsAfterAReset) {
  Simulator simulator(busy(GetParam()));
  run(simulator, once);
  const State state = simulator.state();
  simulator.set_state(state);
  run(simulator, more);
  Simulator fresh(busy(GetParam()));
  fresh.set_state(state);
  run(fresh, more);
  EXPECT_TRUE(fresh.state().positions.allFinite());
  expect_same(simulator.state(), fresh.state());
}

TEST_P(States, StayWhereTheyAreInMemory) {
  Simulator simulator(busy(GetParam()));
  const State& state = simulator.state();
  const double* positions = state.positions.data();
  const double* velocities = state.velocities.data();
  const auto expect_in_place = [&] {
    EXPECT_EQ(&simulator.state(), &state);
    EXPECT_EQ(state.positions.data(), positions);
    EXPECT_EQ(state.velocities.data(), velocities);
  };
  const auto saved = simulator.save();
  simulator.step();
  expect_in_place();
  const State first = state;
  simulator.step();
  simulator.set_state(first);
  expect_in_place();
  Material material = simulator.scene().cloth.material;
  material.springs[2] = false;
  simulator.set_material(material);
  simulator.step();
  simulator.restore(*saved);
  expect_in_place();
  simulator.reset();
  expect_in_place();
  simulator.set_interrupt([] { return true; });
  EXPECT_THROW(simulator.step(), Interrupted);
  expect_in_place();
}

std::vector<std::string> methods() {
  std::vector<std::string> all = method_names();
  all.push_back("auto");
  return all;
}

INSTANTIATE_TEST_SUITE_P(Methods, States, ::testing::ValuesIn(methods()),
                         [](const auto& test) { return test.param; });

TEST(Memories, KeepWhatARecoveryChanged) {
  // In a memory, the method stands after nine numbers of the scene.
  constexpr std::size_t method = 9;
  Simulator simulator(busy("auto"));
  const int substeps = simulator.step().substeps;
  const State state = simulator.state();
  std::vector<double> memory = simulator.memory();

  memory[method] = 3;
  simulator.set_state(state, memory);
  EXPECT_EQ(simulator.memory(), memory);
  EXPECT_EQ(simulator.step().method, method_names()[3]);
  simulator.reset();
  EXPECT_EQ(simulator.step().substeps, substeps);
}

/// Continues from `simulator` and from its memory, set in itself and in another one.
void expect_going_on(Simulator& simulator, Simulator& other) {
  const State state = simulator.state();
  const std::vector<double> memory = simulator.memory();
  run(simulator, more);
  const State expected = simulator.state();
  for (Simulator* from : {&simulator, &other}) {
    from->set_state(state, memory);
    run(*from, more);
    expect_same(from->state(), expected);
  }
}

TEST(Memories, GoOnAfterAChangeOfMaterial) {
  // A method with history drops its history then.
  const auto change = [](Simulator& simulator) {
    Material material = simulator.scene().cloth.material;
    material.damping += 1;
    simulator.set_material(material);
  };
  Simulator simulator(swinging());
  run(simulator, once);
  change(simulator);
  Simulator other(swinging());
  change(other);
  expect_going_on(simulator, other);
}

TEST(Memories, GoOnWithAttachedPointsWhateverTheMethodWasChosenFor) {
  // Free fall is exact at any step, so few substeps suffice; hung up they would not.
  Scene scene = busy("auto");
  scene.cloth.pinned.clear();
  scene.cloth.self_collision = SelfCollision::off;
  scene.colliders.clear();
  scene.cloth.material.strain_limit.reset();
  scene.simulation.tolerance = 1e-5;
  Simulator simulator(scene), other(scene);
  for (Simulator* s : {&simulator, &other}) s->attach("hand", {}, {0, 9});
  run(simulator, once);
  expect_going_on(simulator, other);
}

TEST(Memories, GoOnWithAPinThatMovedFast) {
  Scene scene = busy("bdf2");
  scene.simulation.substeps = 1;
  scene.cloth.pin_strength = strength_range.max;
  Simulator simulator(scene);
  run(simulator, 0.1);
  simulator.move_pin(0, Vector3(0, 0, 1 + 12));  // within a frame
  simulator.step();
  simulator.set_state(simulator.state(), simulator.memory());
}

TEST(Memories, HoldEnergiesOfAnySize) {
  Scene scene = busy("auto");
  scene.cloth.width = scene.cloth.height = 100;
  scene.cloth.origin.z() = 1e6;
  scene.cloth.material.density = 1e5;
  Simulator simulator(scene);
  simulator.step();
  simulator.step();
  simulator.set_state(simulator.state(), simulator.memory());
}

TEST(Memories, KeepWhatTheWatchdogHasCounted) {
  // Slightly above the limit of a cloth under load, energy grows slowly from nothing.
  Scene scene = busy("verlet");
  scene.colliders.clear();
  scene.cloth.self_collision = SelfCollision::off;
  scene.cloth.material.strain_limit.reset();
  scene.cloth.material.damping = 0;
  Simulator probe(scene);
  const double omega = std::sqrt(8 * scene.cloth.material.ks / probe.cloth().mass[0]);
  scene.simulation.substeps = 2;
  scene.simulation.frames_per_second = omega / (2 * 1.8);
  const auto frames_to_the_end = [](Simulator& simulator) {
    int frames = 0;
    try {
      while (frames < 2000) {
        simulator.step();
        ++frames;
      }
    } catch (const Diverged&) {
    }
    return frames;
  };
  Simulator simulator(scene);
  const int all = frames_to_the_end(simulator);
  ASSERT_GT(all, 20);
  ASSERT_LT(all, 2000);
  Simulator again(scene);
  int frames = 0;
  for (; frames < all - 5; ++frames) again.step();
  again.set_state(again.state(), again.memory());
  EXPECT_EQ(frames + frames_to_the_end(again), all);
}

class Refused : public ::testing::Test {
 protected:
  Refused() : simulator_(busy("bdf2")) {
    run(simulator_, once);
    state_ = simulator_.state();
    memory_ = simulator_.memory();
  }

  void expect_refused(const State& state, const std::vector<double>& memory,
                      const std::string& message) {
    try {
      simulator_.set_state(state, memory);
      ADD_FAILURE() << "accepted";
    } catch (const InvalidValue& error) {
      EXPECT_TRUE(says(error.what(), message));
    }
    expect_same(simulator_.state(), state_);
    EXPECT_EQ(simulator_.memory(), memory_);
  }

  Simulator simulator_;
  State state_;
  std::vector<double> memory_;
};

TEST_F(Refused, StatesThatCannotBe) {
  State bad = state_;
  bad.positions.conservativeResize(99, 3);
  expect_refused(bad, {}, "positions: got 99 ... 100");
  bad = state_;
  bad.velocities.resize(0, 3);
  expect_refused(bad, {}, "velocities: got 0 ... 100");
  bad = state_;
  bad.positions(7, 1) = std::numeric_limits<double>::quiet_NaN();
  expect_refused(bad, memory_, "positions.7: got [");
  bad = state_;
  bad.velocities(99, 2) = -std::numeric_limits<double>::infinity();
  expect_refused(bad, memory_, "velocities.99: got [");
  bad = state_;
  bad.velocities(3, 0) = 1000;
  expect_refused(bad, memory_, "velocities.3: got [1000, ... 1000 [m/s]");
  bad = state_;
  bad.positions(3, 0) = -1e12;
  expect_refused(bad, memory_, "positions.3: got [-1e+12, ... 1e+12 [m]");
  bad = state_;
  bad.time = -1;
  expect_refused(bad, memory_, "time: got -1");
  bad = state_;
  bad.positions(0, 2) += 0.01;
  expect_refused(bad, memory_, "positions.0: got [0, 0, 1.01] ... [0, 0, 1]");
}

TEST_F(Refused, MemoriesOfSomethingElse) {
  std::vector<double> bad = memory_;
  bad.pop_back();
  expect_refused(state_, bad, "memory: got");
  bad = memory_;
  bad.push_back(0);
  expect_refused(state_, bad, "memory: got");
  expect_refused(state_, {1}, "memory: got ... another cloth");
  expect_refused(state_, Simulator(busy("xpbd")).memory(), "memory: got ... another cloth");
}

TEST(Memories, GoOnSoonOrNotAtAll) {
  // A history of large numbers, where nothing has touched the cloth: contact would take minutes to
  // follow points thrown far.
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.self_collision = SelfCollision::surface;
  scene.simulation.method = "bdf2";
  Simulator simulator(scene);
  run(simulator, 0.1);
  const State state = simulator.state();
  const std::vector<double> memory = simulator.memory();
  int refused = 0;
  constexpr std::size_t first = 17;
  for (std::size_t place = first; place < first + 2 * 432; place += 97) {  // before the last step
    for (const double value : {1e4, 1e6, 1e9}) {
      std::vector<double> bad = memory;
      bad[place] = value;
      try {
        simulator.set_state(state, bad);
      } catch (const InvalidValue& error) {
        EXPECT_NE(std::string(error.what()).find("m/s in the "), std::string::npos) << error.what();
        ++refused;
      }
    }
  }
  EXPECT_EQ(refused, 27);
  simulator.set_state(state, memory);
}

TEST_F(Refused, GarbageInAMemory) {
  // For any replacement of a number, the memory is refused or simulated: no read out of bounds.
  int refused = 0;
  for (std::size_t i = 0; i < memory_.size(); i += 1 + i / 20) {
    for (const double value : {-1.0, 0.5, 1e9, 1e300, std::nan("")}) {
      std::vector<double> bad = memory_;
      bad[i] = value;
      Simulator other(busy("bdf2"));
      try {
        other.set_state(state_, bad);
        other.step();
      } catch (const InvalidValue&) {
        ++refused;
      } catch (const Diverged&) {
      }
      EXPECT_TRUE(other.state().positions.allFinite());
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace clothsim::simulator_state_test
