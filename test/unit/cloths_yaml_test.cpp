// Several cloths in a scene.

#include <gtest/gtest.h>

#include "clothsim/scene/motion.h"
#include "clothsim/simulation/simulator.h"
#include "says.h"
#include "scene_text.h"

namespace clothsim::cloths_yaml_test {
namespace {

constexpr const char* a_grid = "fabric: felt, width: 0.2, height: 0.2, columns: 5, rows: 5";

/// A scene of two cloths of 5 x 5 points: `one` at z = 1, `other` above; and what follows.
std::string scene_with(const std::string& of_other, const std::string& more = "") {
  return std::string("cloths: [{name: one, ") + a_grid + "}, {name: other, " + a_grid +
         ", origin: [0, 0, 1.1]" + of_other + "}]\n" + more;
}

Scene read(const std::string& text) { return read_scene(YAML::Load(text)); }

TEST(Cloths, AreReadByTheirNames) {
  const Scene scene = read(scene_with(", density: 0.5, pinned: [[4, 1], {near: [0, 0.2, 1.1]}]"));
  ASSERT_EQ(scene.cloth.parts.size(), 2u);
  EXPECT_EQ(scene.cloth.parts[0].name, "one");
  EXPECT_EQ(scene.cloth.parts[1].name, "other");
  EXPECT_EQ(scene.cloth.parts[1].first_point, 25);
  EXPECT_EQ(scene.cloth.parts[1].material.density, 0.5);
  EXPECT_EQ(scene.cloth.columns, 50);
  ASSERT_EQ(scene.cloth.pinned.size(), 2u);
  EXPECT_EQ(scene.cloth.pinned[0].column, 25 + 9);
  EXPECT_EQ(scene.cloth.pinned[1].column, 25 + 20);
}

std::vector<int> attached(const std::string& entry) {
  const Scene scene = read(scene_with("", "motions: [{time: 0, attach: hand, " + entry + "}]"));
  return std::get<AttachPoints>(scene.motions.at(0).action).points;
}

TEST(Cloths, MotionsNameTheirPoints) {
  EXPECT_EQ(attached("cloth: other, points: [[1, 2], 3]"), (std::vector<int>{25 + 11, 25 + 3}));
  EXPECT_EQ(attached("points: [3, {uv: [1, 1]}], cloth: one"), (std::vector<int>{3, 24}));
  EXPECT_EQ(attached("points: [30]"), std::vector<int>{30});
  EXPECT_EQ(attached("cloth: other, points: [{uv: [1, 0]}]"), std::vector<int>{29});
  EXPECT_EQ(attached("points: [{near: [0, 0, 1.1]}]"), std::vector<int>{25});
  EXPECT_EQ(attached("cloth: one, points: [{near: [0, 0, 1.1]}]"), std::vector<int>{0});
  EXPECT_EQ(attached("points: [{within: 0.101, of: [0, 0, 1.05]}]").size(), 8u);
  EXPECT_EQ(attached("cloth: other, points: [{within: 0.101, of: [0, 0, 1.05]}]").size(), 4u);
}

TEST(Cloths, MistakesSayWhere) {
  const auto motion = [](const std::string& entry) {
    return refusal(scene_with("", "motions: [{time: 0, attach: hand, " + entry + "}]"));
  };
  EXPECT_TRUE(
      says(motion("cloth: third, points: [0]"), "motions.0.cloth ... third ... one, other"));
  EXPECT_TRUE(says(motion("cloth: one, points: [[5, 0]]"), "motions.0.points.0 ... [5, 0]"));
  EXPECT_TRUE(says(motion("cloth: one, points: [25]"), "motions.0.points.0 ... 25 ... 0 to 24"));
  EXPECT_TRUE(says(motion("cloth: one, radius: 0.1"), "motions.0.cloth: got ... without points"));
  EXPECT_TRUE(says(refusal(scene_with("", "motions: [{time: 0, detach: hand, cloth: one}]")),
                   "motions.0.cloth: got ... without points"));
  EXPECT_TRUE(says(motion("points: [50]"), "motions.0.points.0 ... 50 ... 0 to 49"));
  const std::string single = std::string("cloth: {") + a_grid + "}\n";
  EXPECT_TRUE(says(refusal(single + "motions: [{time: 0, attach: h, cloth: one, points: [0]}]"),
                   "motions.0.cloth ... one cloth"));
  EXPECT_TRUE(says(refusal(single + "cloths: []"), "cloths ... again"));
  EXPECT_TRUE(says(refusal("cloths: []"), "cloths ... empty"));
  EXPECT_TRUE(says(refusal("cloths: {}"), "cloths ... a list"));
  EXPECT_TRUE(says(refusal(scene_with(", untangle: true")), "cloths.1.untangle ... true ... one"));
  EXPECT_TRUE(says(refusal(scene_with(", thickness: -0.3")), "cloths.1.thickness: got -0.3"));
  EXPECT_TRUE(says(refusal(scene_with(", nme: x")), "cloths.1.nme ... unknown"));
  EXPECT_TRUE(says(refusal(scene_with(", pinned: [[5, 5]]")), "cloths.1.pinned.0 ... [5, 5]"));
  EXPECT_TRUE(says(refusal("cloth: {name: one}"), "cloth.name ... unknown"));
  const std::string box = "colliders: [{shape: box, name: box, mass: 1, center: [0, 0, 5]}]";
  EXPECT_TRUE(says(refusal(scene_with(", attached: [{body: box, points: [[1, 1], [1, 1]]}]", box)),
                   "cloths.1.attached.0.points.1: got other [1, 1]"));
  EXPECT_TRUE(says(refusal(scene_with(", attached: [{body: box, points: [[0, 0]]}]")),
                   "cloths.1.attached.0.body ... box"));
}

TEST(Cloths, StartApart) {
  const auto upright = [](const std::string& more) {  // through the first
    return refusal(std::string("cloths: [{name: one, ") + a_grid + more + "}, {name: other, " +
                   a_grid + ", orientation: vertical, origin: [0.01, 0.11, 0.92]" + more + "}]");
  };
  EXPECT_TRUE(says(upright(""), "cloths: got triangle ... through triangle"));
  EXPECT_EQ(upright(", self_collision: false"), "accepted");
  // At the same place, as with the default origin.
  EXPECT_TRUE(says(
      refusal(std::string("cloths: [{name: one, ") + a_grid + "}, {name: other, " + a_grid + "}]"),
      "cloths: got point ... on triangle"));
}

TEST(Cloths, TouchEachOtherUnlessSwitchedOff) {
  EXPECT_EQ(read(scene_with("")).cloth.self_collision, SelfCollision::automatic);
  EXPECT_TRUE(
      says(refusal(scene_with(", self_collision: false")), "cloths.1.self_collision ... off"));
}

TEST(Cloths, MayBeOfTwoFabrics) {
  YAML::Node root = YAML::Load(scene_with(""));
  root["cloths"][1]["fabric"] = "cotton_towel";
  const Scene scene = read_scene(root);
  const ClothPart &felt = scene.cloth.parts[0], &towel = scene.cloth.parts[1];
  EXPECT_EQ(felt.thickness, 0.0005);
  EXPECT_EQ(towel.thickness, 0.001);
  EXPECT_NE(felt.friction, 0);
  EXPECT_EQ(felt.material.fabric->internal_damping, (std::array{1e-5, 5e-3}));
  EXPECT_EQ(towel.material.fabric->internal_damping, (std::array{1e-5, 4e-3}));
}

TEST(Cloths, ALiveValueIsSetInEach) {
  const Scene scene = read(scene_with(", density: 0.5"));
  LiveSpec live = live_values(scene);
  const double first = live.material.density;
  ASSERT_NE(first, 0.5);
  read_live_values(YAML::Load("{density: " + to_text(first) +
                              ", strain_limit: 0.2, friction: 0.7, thickness: 2.0e-4}"),
                   live);
  EXPECT_EQ(live.friction, 0.7);
  EXPECT_EQ(live.thickness, 2e-4);
  for (const LiveSpec::OfCloth& cloth : live.cloths) {
    EXPECT_EQ(cloth.material.density, first);
    EXPECT_EQ(cloth.material.strain_limit, 0.2);
    EXPECT_EQ(cloth.friction, 0.7);
    EXPECT_EQ(cloth.thickness, 2e-4);
  }
}

TEST(Cloths, ALiveValueOfOneLeavesTheOthers) {
  const Scene scene = read(scene_with(", density: 0.5"));
  const LiveSpec start = live_values(scene);
  // A cloth's own value prevails over that of all, in any order.
  const std::string own = "cloths: {one: {friction: 0.1, thickness: 2.0e-4}}";
  for (const std::string& text : {"{friction: 0.7, " + own + "}", "{" + own + ", friction: 0.7}"}) {
    LiveSpec live = start;
    read_live_values(YAML::Load(text), live);
    Simulator simulator(scene);
    simulator.set(live);
    const ClothSpec& now = simulator.scene().cloth;
    EXPECT_EQ(now.friction, 0.1);
    EXPECT_EQ(now.parts[0].friction, 0.1);
    EXPECT_EQ(now.parts[1].friction, 0.7);
    EXPECT_EQ(now.parts[0].thickness, 2e-4);
    EXPECT_EQ(now.parts[1].thickness, start.cloths[1].thickness);
  }
  LiveSpec live = start;
  read_live_values(YAML::Load("{cloths: {other: {density: 0.3, stretch_stiffness: [900, 800]}}}"),
                   live);
  EXPECT_EQ(live.material.density, start.material.density);
  EXPECT_EQ(live.cloths[0].material.density, start.cloths[0].material.density);
  EXPECT_EQ(live.cloths[1].material.density, 0.3);
  EXPECT_EQ(live.cloths[1].material.fabric->stretch_stiffness, (std::array{900.0, 800.0}));
}

TEST(Cloths, AWrongLiveValueOfOneIsRefusedByItsName) {
  const auto change = [](const std::string& values) {
    return refusal(scene_with("", "motions: [{time: 0, set: " + values + "}]"));
  };
  EXPECT_TRUE(says(change("{cloths: {other: {friction: -1}}}"),
                   "motions.0.set.cloths.other.friction ... -1"));
  EXPECT_TRUE(
      says(change("{cloths: {one: {density: 0}}}"), "motions.0.set.cloths.one.density ... 0"));
  EXPECT_TRUE(says(change("{cloths: {other: {damping: -2}}}"),
                   "motions.0.set.cloths.other.damping ... -2"));
  EXPECT_TRUE(says(change("{cloths: {other: {untangle: true}}}"),
                   "motions.0.set.cloths.other.untangle ... unknown key ... density"));
  EXPECT_TRUE(says(change("{cloths: {nobody: {}}}"), "motions.0.set.cloths.nobody ... one, other"));
  EXPECT_TRUE(says(change("{cloths: 3}"), "motions.0.set.cloths ... 3 ... a map"));
  EXPECT_TRUE(says(change("{friction: -1}"), "motions.0.set.friction ... -1"));
  EXPECT_TRUE(says(refusal("cloth: {}\nmotions: [{time: 0, set: {cloths: {}}}]"),
                   "motions.0.set.cloths ... unknown key"));
}

}  // namespace
}  // namespace clothsim::cloths_yaml_test
