// Friction, thickness and self collision that change while the cloth moves.

#include <cmath>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/errors.h"
#include "clothsim/run/motion_player.h"
#include "says.h"
#include "verification/testing.h"

namespace clothsim::live_contact_test {
namespace {

using namespace test;

/// Changes values as a user writes them.
void set(Simulator& simulator, const std::string& yaml) {
  LiveSpec live = live_values(simulator.scene());
  read_live_values(YAML::Load(yaml), live);
  simulator.set(live);
}

/// A cloth of 5 kg on an incline of 30 degrees.
Scene on_a_slope(double friction) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 8;
  scene.cloth.origin = {0, 0, 2e-4};
  scene.cloth.material.density = 5;
  scene.cloth.material.damping = 0;
  scene.colliders.resize(1);
  scene.colliders[0].name = "slope";
  scene.colliders[0].shape = Plane{};
  scene.colliders[0].friction = friction;
  scene.simulation.gravity = 9.8 * Vector3(0.5, 0, -std::sqrt(0.75));
  return scene;
}

TEST(LiveContact, FrictionOfAColliderHoldsWhatSlipped) {
  // Without friction v = g t sin; with 2 > tan it loses g (2 cos - sin) t.
  Simulator simulator(on_a_slope(0));
  run(simulator, 0.5);
  EXPECT_NEAR(simulator.state().velocities.col(0).mean(), 0.5 * 4.9, 0.02);
  set(simulator, "{collider_friction: {slope: 2}}");
  EXPECT_EQ(simulator.scene().colliders[0].friction, 2);
  run(simulator, 0.1);
  EXPECT_NEAR(simulator.state().velocities.col(0).mean(),
              2.45 - 0.1 * 9.8 * (2 * std::sqrt(0.75) - 0.5), 0.03);
  run(simulator, 0.4);
  EXPECT_LT(longest_row(simulator.state().velocities), 1e-3);
}

TEST(LiveContact, ValuesThatChangeAtTheStartAreThoseOfAScene) {
  const Scene scene = shipped_scene("self_collision");
  Scene other = scene;
  other.cloth.self_collision = SelfCollision::off;
  other.cloth.thickness = 0.5 * scene.cloth.thickness;
  other.cloth.friction = 0;
  for (ColliderSpec& collider : other.colliders) collider.friction = 0;
  Simulator expected(scene), changed(other);
  changed.set(live_values(scene));
  run(expected, 0.5);
  run(changed, 0.5);
  EXPECT_EQ(expected.state().positions, changed.state().positions);
}

TEST(LiveContact, AThickerClothPartsWithoutAJump) {
  // In a pile: each layer must rise, without a leap.
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 20;
  scene.cloth.self_collision = SelfCollision::surface;
  scene.cloth.thickness = 0.008;
  Simulator simulator(scene);
  run(simulator, 3);
  ASSERT_LT(longest_row(simulator.state().velocities), 0.1);
  ASSERT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  set(simulator, "{thickness: 0.012}");
  double max_speed = 0;
  for (int frame = 0; frame < 45; ++frame) {
    simulator.step();
    max_speed = std::max(max_speed, longest_row(simulator.state().velocities));
  }
  EXPECT_LT(max_speed, 0.5);
  EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  set(simulator, "{self_collision: false}");
  EXPECT_EQ(simulator.cloth().self_collision, SelfCollision::off);
  run(simulator, 0.5);
  EXPECT_GT(count_intersections(simulator.cloth(), simulator.state().positions), 0)
      << "it does not fall through itself";
}

TEST(LiveContact, RestoreKeepsThePresentValues) {
  Simulator simulator(on_a_slope(0.1));
  run(simulator, 0.1);
  const auto saved = simulator.save();
  set(simulator, "{collider_friction: {slope: 2}, thickness: 0.02, friction: 0.7}");
  run(simulator, 0.1);
  simulator.restore(*saved);
  EXPECT_EQ(simulator.scene().colliders[0].friction, 2);
  EXPECT_EQ(simulator.cloth().thickness, 0.02);
  EXPECT_EQ(simulator.cloth().friction, 0.7);
  run(simulator, 0.5);
  EXPECT_LT(longest_row(simulator.state().velocities), 1e-3) << "the friction of before";
}

TEST(LiveContact, MistakesAreRefusedAndNothingChanges) {
  Simulator simulator(on_a_slope(0.1));
  const auto message = [&](const std::string& yaml) -> std::string {
    try {
      set(simulator, yaml);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(says(message("{thickness: 0}"), "thickness: got 0"));
  EXPECT_TRUE(says(message("{friction: -1}"), "friction: got -1"));
  EXPECT_TRUE(says(message("{self_collision: 2}"), "self_collision: got 2"));
  EXPECT_TRUE(
      says(message("{ks: 1, collider_friction: {slope: -1}}"), "collider_friction.slope: got -1"));
  EXPECT_TRUE(says(message("{collider_friction: {ball: 1}}"),
                   "collider_friction.ball: got ... unknown ... slope"));
  EXPECT_EQ(simulator.cloth().thickness, 0.0095);
  EXPECT_EQ(simulator.scene().cloth.material.ks, 5000);
}

TEST(LiveContact, MotionsChangeAllLiveValuesButTheRateOfFrames) {
  const auto with = [](const std::string& set) {
    return read_scene(
        YAML::Load("{cloth: {columns: 5, rows: 5}, colliders: [{shape: plane}],"
                   " motions: [{time: 0.05, set: " +
                   set + "}]}"));
  };
  Simulator simulator(
      with("{collider_friction: {plane: 0.8}, thickness: 0.004, drag: 2, method: rk4}"));
  MotionPlayer player(simulator, ".");
  for (int frame = 0; frame < 6; ++frame) {
    EXPECT_EQ(simulator.scene().colliders[0].friction, frame < 6 ? 0 : 0.8) << frame;
    player.play(simulator);
    simulator.step();
  }
  EXPECT_EQ(simulator.scene().colliders[0].friction, 0.8);
  EXPECT_EQ(simulator.scene().cloth.material.drag[1], 2);
  EXPECT_EQ(simulator.choice().method, "rk4");
  for (const auto& [values, why] :
       {std::pair("{frames_per_second: 60}", "motions.0.set.frames_per_second: got 60"),
        {"{collider_friction: {ball: 1}}", "motions.0.set.collider_friction.ball: got ... unknown"},
        {"{stretch_stiffness: 5}", "motions.0.set.stretch_stiffness: got ... unknown"}}) {
    try {
      with(values);
      ADD_FAILURE() << values;
    } catch (const InvalidValue& error) {
      EXPECT_TRUE(says(error.what(), why));
    }
  }
}

}  // namespace
}  // namespace clothsim::live_contact_test
