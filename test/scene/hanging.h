#pragma once

#include <cmath>
#include <string>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "verification/energy_account.h"
#include "verification/testing.h"

namespace clothsim::test {

/// A cloth held by two corners.
inline Scene hanging(int side = 20) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.pinned = {{0, 0, ""}, {side - 1, 0, ""}};
  return scene;
}

/// Runs and checks every frame; returns the number of times that a frame was taken back. Records
/// the time from which on the cloth moves by less than 10 mm/s rms.
inline int run_checked(Simulator& simulator, double seconds, double speed_limit) {
  int recoveries = 0;
  int moving = 0;
  const int frames = static_cast<int>(std::lround(seconds * 90));
  for (int frame = 0; frame < frames; ++frame) {
    recoveries += simulator.step().recoveries;
    const State& s = simulator.state();
    EXPECT_TRUE(s.positions.allFinite()) << frame;
    EXPECT_LT(max_speed(s), speed_limit) << frame;
    if (::testing::Test::HasFailure()) return recoveries;
    if (rms_velocity(s) > 0.01) moving = frame + 1;
  }
  ::testing::Test::RecordProperty("rest_after_s", std::to_string(moving / 90.0));
  return recoveries;
}

/// Runs until every holder has its points at their targets.
inline void run_until_held(Simulator& simulator, double max_seconds) {
  const int frames = static_cast<int>(std::lround(max_seconds * 90));
  for (int frame = 0; frame < frames && simulator.step().lagging > 0; ++frame) {
  }
  for (const HolderReport& holder : simulator.holders()) EXPECT_EQ(holder.lag, 0) << holder.name;
}

/// Runs without drive: no frame may gain energy from nothing, as a cloth that trembles or blows up
/// does.
inline StepReport run_undriven(Simulator& simulator, double seconds) {
  constexpr double max_made = 0.01;  // of the energy that could move; measured: a tenth of that
  EnergyAccount account;
  account.begin(simulator);
  StepReport report;
  const int frames = static_cast<int>(std::lround(seconds * 90));
  for (int frame = 0; frame < frames && !::testing::Test::HasFailure(); ++frame) {
    report = simulator.step();
    EXPECT_TRUE(simulator.state().positions.allFinite()) << frame;
    EXPECT_LT(account.share_made(simulator), max_made) << frame;
  }
  return report;
}

inline void expect_rest(const Simulator& simulator, double rms) {
  EXPECT_LT(rms_velocity(simulator.state()), rms);
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.105);
}

}  // namespace clothsim::test
