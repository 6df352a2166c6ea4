// A scene's cloth from a sewing pattern.

#include <gtest/gtest.h>

#include "clothsim/model/make_cloth.h"
#include "clothsim/scene/motion.h"
#include "says.h"
#include "scene_text.h"

namespace clothsim::pattern_yaml_test {
namespace {

constexpr const char* square = "outline: [[0, 0], [0.2, 0], [0.2, 0.2], [0, 0.2]]";

/// A cloth of two squares, 10 mm apart, sewn at their right sides; and other keys.
std::string bag(const std::string& others = "", const std::string& seams = "[[front.1, back.1]]") {
  return std::string("cloth: {fabric: felt, pattern: {cell: 0.05, panels: [{name: front, ") +
         square + ", pose: {xyz: [0, 0, 0.01]}}, {name: back, " + square + "}], seams: " + seams +
         "}" + others + "}";
}

Scene read(const std::string& text) { return read_scene(YAML::Load(text)); }

TEST(PatternYaml, PanelsAreSewn) {
  const Scene scene = read(bag());
  ASSERT_TRUE(scene.cloth.mesh);
  const Cloth cloth = make_cloth(scene.cloth);
  EXPECT_NEAR(cloth.mass.sum(), 2 * 0.04 * scene.cloth.material.density, 1e-9);
  EXPECT_EQ(scene.cloth.pattern->sides.at("front.1"), scene.cloth.pattern->sides.at("back.1"));
  EXPECT_EQ(scene.cloth.pattern->sides.at("front.1").size(), 5u);
}

TEST(PatternYaml, PointsHaveNamesOfCornersAndSides) {
  const Scene scene = read(bag(", pinned: [{corner: front.0}, {side: back.3, frame: hand}]"));
  const Points& x = scene.cloth.mesh->positions;
  ASSERT_EQ(scene.cloth.pinned.size(), 6u);
  EXPECT_LT((row(x, scene.cloth.pinned[0].column) - Vector3(0, 0, 0.01)).norm(), 1e-12);
  for (std::size_t i = 1; i < 6; ++i) {
    const Vector3 at = row(x, scene.cloth.pinned[i].column);
    EXPECT_LT((at - Vector3(0, 0.2 - 0.05 * double(i - 1), 0)).norm(), 1e-12);
    EXPECT_EQ(scene.cloth.pinned[i].frame, "hand");
  }
}

TEST(PatternYaml, OneOfSeveralClothsHasItsNames) {
  const Scene scene = read(
      std::string(
          "cloths: [{name: sheet, fabric: felt, width: 0.1, height: 0.1, columns: 3, rows: 3}, "
          "{name: patch, fabric: felt, pattern: {cell: 0.1, panels: [{name: p, ") +
      square + "}]}}]\nmotions: [{attach: hand, cloth: patch, points: [{side: p.0}]}]");
  const auto& attach = std::get<AttachPoints>(scene.motions.at(0).action);
  ASSERT_EQ(attach.points.size(), 3u);
  for (const int i : attach.points) {
    EXPECT_GE(i, 9);
    EXPECT_EQ(scene.cloth.mesh->positions(i, 1), 0);
  }
}

TEST(PatternYaml, SidesOfAWaistShareTheirEnds) {
  const std::string tube =
      bag(", pinned: [{side: front.2}, {side: back.2}]", "[[front.1, back.1], [front.3, back.3]]");
  EXPECT_EQ(read(tube).cloth.pinned.size(), 8u);  // 5 of each side, two of them of both
  const Scene scene =
      read(bag("", "[[front.1, back.1], [front.3, back.3]]") +
           "\nmotions: [{attach: hand, points: [{side: front.2}, {side: back.2}]}]");
  EXPECT_EQ(std::get<AttachPoints>(scene.motions.at(0).action).points.size(), 8u);
  const Scene loaded =
      read("colliders: [{shape: box, name: box, mass: 1, center: [0, 0, 5]}]\n" +
           bag(", attached: [{body: box, points: [{side: front.2}, {side: back.2}]}]",
               "[[front.1, back.1], [front.3, back.3]]"));
  EXPECT_EQ(loaded.cloth.attached.at(0).points.size(), 8u);
  // A skirt: one ring, sewn to itself.
  const Scene skirt = read(
      "cloth: {fabric: felt, pattern: {cell: 0.05, panels: [{name: a, outline: [[0.3, 0.01], "
      "{arc: [-0.3, 0]}, [0.3, -0.01], [0.1, -0.01], {arc: [-0.1, 0]}, [0.1, 0.01]]}], "
      "seams: [[a.1, a.3]]}, pinned: [{side: a.2}]}");
  EXPECT_GT(skirt.cloth.pinned.size(), 10u);
}

TEST(PatternYaml, ArcsAndCurves) {
  const auto area = [](const std::string& outline) {
    const Scene scene =
        read("cloth: {fabric: felt, pattern: {cell: 0.02, panels: [{name: a, outline: " + outline +
             "}]}}");
    return make_cloth(scene.cloth).mass.sum() / scene.cloth.material.density;
  };
  EXPECT_NEAR(area("[[0.2, 0], {arc: [0, 0.2]}, [-0.2, 0], {arc: [0, -0.2]}]"), M_PI * 0.04, 1e-3);
  EXPECT_NEAR(area("[[0, 0], [0.3, 0], {curve: [[0.3, 0.1], [0.3, 0.2]]}, [0.3, 0.3], [0, 0.3]]"),
              0.09, 1e-9);
}

TEST(PatternYaml, MistakesSayWhere) {
  const auto panel = [](const std::string& keys, const std::string& cell = "0.05") {
    return refusal("cloth: {fabric: felt, pattern: {cell: " + cell + ", panels: [{" + keys +
                   "}]}}");
  };
  const std::string at = "cloth.pattern.panels.0";
  EXPECT_TRUE(says(panel("name: a"), at + ".outline: got nothing"));
  EXPECT_TRUE(says(panel(square), at + ".name: got nothing"));
  EXPECT_TRUE(says(panel("name: a, outline: [[0, 0]]"), at + ".outline: got 1 corners ... two"));
  EXPECT_TRUE(says(panel("name: a, outline: [[0, 0], [1]]"), at + ".outline.1: got ... [x, y]"));
  EXPECT_TRUE(
      says(panel("name: a, outline: [[0, 0], [1e3, 0], [0, 1]]"), at + ".outline.1 ... 1000"));
  EXPECT_TRUE(says(panel("name: a, outline: [{arc: [0, 0]}, [1, 0], [0, 1]]"),
                   at + ".outline.0: got ... a corner"));
  EXPECT_TRUE(says(panel("name: a, outline: [[0, 0], {arc: [1, 0]}, [2, 0], [0, 1]]"),
                   at + ".outline.1: got [1, 0], on the line"));
  EXPECT_TRUE(says(panel("name: a, outline: [[0, 0], {arc: [0, 1], curve: [[1, 1]]}, [2, 0]]"),
                   at + ".outline.1: got ... arc"));
  EXPECT_TRUE(says(panel("name: a, outline: [[0, 0], [0, 0], [1, 0]]"),
                   at + ".outline: got corner 0 again"));
  EXPECT_TRUE(
      says(panel("name: a, outline: [[0, 0], [1, 1], [1, 0], [0, 1]]"), at + ": got an outline"));
  EXPECT_TRUE(says(panel(std::string("name: a, warp: [0, 0], ") + square), at + ".warp"));
  EXPECT_TRUE(says(panel(std::string("name: a, ") + square, "0"), "cloth.pattern.cell: got 0"));
  EXPECT_TRUE(says(panel(std::string("name: a, ") + square, "0.0001"),
                   "cloth.pattern.cell: got 1e-04 ... 0.001 or more, as panel a"));
  EXPECT_TRUE(
      says(refusal("cloth: {fabric: felt, pattern: {}}"), "cloth.pattern.panels: got none"));
  EXPECT_TRUE(says(refusal(bag("", "[[front.1, back.9]]")),
                   "cloth.pattern.seams.0.1: got \"back.9\" ... front.0"));
  EXPECT_TRUE(says(refusal(bag("", "[[front.1]]")), "cloth.pattern.seams.0: got ... two sides"));
  EXPECT_TRUE(
      says(refusal(bag("", "[[front.1, front.1]]")), "cloth.pattern.seams.0: got ... different"));
  EXPECT_TRUE(says(refusal(bag(", width: 1")), "cloth.width: got 1 ... with a pattern"));
  EXPECT_TRUE(says(refusal(bag(", pinned: [{corner: front.7}]")),
                   "cloth.pinned.0.corner: got \"front.7\""));
  EXPECT_TRUE(says(refusal("cloth: {pinned: [{side: a.0}]}"),
                   "cloth.pinned.0.side: got \"a.0\" ... no pattern"));
}

}  // namespace
}  // namespace clothsim::pattern_yaml_test
