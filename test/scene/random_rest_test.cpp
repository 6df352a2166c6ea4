// Random scenes that ask for what cannot be had: pins too far apart, colliders that stop between
// them. Once all stands still, so does the cloth; it shook at 1 to 220 m/s for ever.

#include "fuzz/random_scene.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

class RandomScenes : public ::testing::TestWithParam<int> {};

TEST_P(RandomScenes, ComeToRest) {
  const RandomScene random = random_scene(static_cast<std::uint64_t>(GetParam()));
  SCOPED_TRACE(random.text());
  Simulator simulator(random.scene);
  const Points start = simulator.state().positions;
  const auto pin_at = [&](std::size_t i, double time) {
    const Pin& pin = random.scene.cloth.pinned[i];
    const int point = pin.row * random.scene.cloth.columns + pin.column;
    return random.pins[i].at(time, {row(start, point), Eigen::Quaterniond::Identity()}).position;
  };
  constexpr double seconds = 11;
  while (simulator.state().time < seconds) {
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
  EXPECT_LT(rms_velocity(simulator.state()), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomScenes,
                         ::testing::Values(20452,    // a pin is moved to four times as far
                                           20486,    // a capsule pulls a taut, inextensible strip
                                           20662,    // a ball pushes a strip aside
                                           20900,    // a capsule stays in a stiff, light cloth
                                           21049,    // and in a strip, between its pins
                                           22192));  // and in a strip below a row of pins

}  // namespace
}  // namespace clothsim
