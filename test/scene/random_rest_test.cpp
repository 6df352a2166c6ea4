// Random scenes with constraints that cannot be met: pins too far apart, colliders that stop
// between them. Once nothing is driven, the cloth comes to rest.

#include <iostream>
#include <optional>

#include "clothsim/model/errors.h"
#include "fuzz/random_scene.h"
#include "verification/testing.h"

namespace clothsim::random_rest_test {
namespace {

using namespace test;

/// Plays a random scene until nothing has been driven for ten seconds.
void play(const RandomScene& random, Simulator& simulator) {
  const Points start = simulator.state().positions;
  const auto pin_at = [&](std::size_t i, double time) {
    const Pin& pin = random.scene.cloth.pinned[i];
    const int point = pin.row * random.scene.cloth.columns + pin.column;
    return random.pins[i].at(time, {row(start, point), Eigen::Quaterniond::Identity()}).position;
  };
  while (simulator.state().time < driven_for + 10) {
    const double time = std::min(simulator.state().time + simulator.frame_duration(), driven_for);
    for (std::size_t i = 0; i < random.colliders.size(); ++i) {
      const Pose& from = random.scene.colliders[i].pose;
      simulator.move_collider(static_cast<int>(i), random.colliders[i].at(time, from));
    }
    for (std::size_t i = 0; i < random.pins.size(); ++i) {
      simulator.move_pin(static_cast<int>(i), pin_at(i, time));
    }
    simulator.step();
  }
}

/// Numbers of random scenes with pins that do not rest.
struct Rates {
  int scenes = 0;
  int moving = 0;   // by over 1 mm/s
  int fast = 0;     // by over 0.1 m/s
  int refused = 0;  // no method solves a frame

  /// Adds the scene of a seed, with a cloth of at most `most` points along a side and, if given,
  /// another damping [1/s].
  void add(std::uint64_t seed, int most, std::optional<double> damping) {
    RandomScene random = random_scene(seed, most);
    if (random.scene.cloth.pinned.empty()) return;
    if (damping) random.scene.cloth.material.damping = *damping;
    ++scenes;
    Simulator simulator(random.scene);
    try {
      play(random, simulator);
    } catch (const Diverged&) {
      ++refused;
      return;
    }
    const double speed = rms_velocity(simulator.state());
    moving += speed > 1e-3;
    fast += speed > 0.1;
    if (speed > 1e-3) std::cout << "seed " << seed << ": " << speed << " m/s" << std::endl;
  }

  /// At most a tenth moves, at most a fiftieth fast.
  void expect_rest() const {
    for (const auto& [name, count] : {std::pair("scenes", scenes), std::pair("moving", moving),
                                      std::pair("fast", fast), std::pair("refused", refused)}) {
      ::testing::Test::RecordProperty(name, count);
    }
    EXPECT_LE(moving, scenes / 10);
    EXPECT_LE(fast, scenes / 50);
    EXPECT_EQ(refused, 0);
  }
};

/// Plays the scenes of `seeds` seeds.
Rates play(int seeds, int most, std::optional<double> damping) {
  Rates rates;
  for (int seed = 0; seed < seeds; ++seed) {
    rates.add(30000 + static_cast<std::uint64_t>(seed), most, damping);
  }
  return rates;
}

TEST(RandomRest, ComesInMostScenes) { play(60, 25, 3).expect_rest(); }

TEST(DISABLED_Survey, RandomScenesComeToRest) { play(620, 25, 3).expect_rest(); }

TEST(RandomRest, ComesInMostScenesWithTheirOwnDamping) {
  const Rates rates = play(60, 12, {});
  EXPECT_LE(rates.fast, rates.scenes / 5);  // some scenes have no damping at all
  EXPECT_EQ(rates.refused, 0);
}

}  // namespace
}  // namespace clothsim::random_rest_test
