// Valid but doubtful values, with the values that may have been meant.

#include "clothsim/scene/doubts.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "says.h"
#include "scene_text.h"

namespace clothsim::doubts_test {
namespace {

using Lines = std::vector<std::string>;

Lines doubts_of(const std::string& text) {
  const YAML::Node yaml = YAML::Load(text);
  return doubts(yaml, read_scene(yaml));
}

/// The only one.
std::string doubt_of(const std::string& text) {
  const Lines lines = doubts_of(text);
  EXPECT_EQ(lines.size(), 1u) << text;
  return lines.empty() ? "" : lines[0];
}

TEST(Doubts, NoShippedSceneHasAny) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(CLOTHSIM_SCENES_DIR)) {
    if (file.path().extension() != ".yaml") continue;
    const YAML::Node yaml = load_scene_file(file.path());
    YAML::Node without_robots = YAML::Clone(yaml);
    without_robots.remove("robots");  // their URDF comes from a parameter
    EXPECT_EQ(doubts(yaml, read_scene(without_robots, {file.path().parent_path()})), Lines())
        << file.path();
    ++count;
  }
  EXPECT_GT(count, 10);
}

TEST(Doubts, AnglesInDegrees) {
  const std::string before =
      "{cloth: {}, colliders: [{shape: plane, point: [0, 0, 0]}, "
      "{shape: box, center: [5, 5, 5], rpy: [0, 0, ";
  EXPECT_EQ(doubts_of(before + "6.28]}]}"), Lines());
  EXPECT_EQ(doubts_of(before + "-90]}]}"),
            Lines{"colliders.1.rpy: got -90 [rad]; did you mean -1.5708, -90 degrees?"})
      << "an example of a whole message";
  EXPECT_TRUE(says(doubt_of("{cloth: {}, colliders: [{shape: sphere, center: [5, 5, 5], "
                            "radius: 0.1, pose: {rpy: [180, 0, 0]}}]}"),
                   "colliders.0.pose.rpy: got 180 [rad] ... 3.1416 ... degrees"));
  EXPECT_TRUE(
      says(doubt_of("{cloth: {}, motions: [{frame: a, position: [0, 0, 0], rpy: [0, 45, 0]}]}"),
           "motions.0.rpy: got 45 [rad] ... 0.7854 ... degrees"));
}

TEST(Doubts, SizesInCentimetres) {
  EXPECT_TRUE(says(doubt_of("cloth: {width: 40, height: 0.4, columns: 26}"),
                   "cloth.width: got 40 [m] ... 1.6 m ... 0.4 ... 40 cm"));
  EXPECT_EQ(doubts_of("cloth: {width: 20, height: 20, columns: 100, rows: 100}"), Lines());
  const std::string one = "{fabric: felt, columns: 5, rows: 5, name: ";
  const Lines of_cloths =
      doubts_of("cloths: [" + one + "a}, " + one + "b, width: 20, height: 20, origin: [0, 0, 2]}]");
  ASSERT_EQ(of_cloths.size(), 2u);
  EXPECT_TRUE(says(of_cloths[0], "cloths.1.width: got 20 ... 0.2"));
  EXPECT_TRUE(says(of_cloths[1], "cloths.1.height: got 20 ... 0.2"));
}

TEST(Doubts, ClothThatStartsInACollider) {
  const std::string before = "{cloth: {columns: 11, rows: 11}, colliders: [";
  const std::string after = "]}";
  EXPECT_TRUE(says(
      doubt_of(before + "{shape: sphere, name: ball, center: [0.5, 0.5, 1], radius: 0.15}" + after),
      "9 of 121 points ... collider ball ... cloth.origin"));
  EXPECT_EQ(doubts_of(before + "{shape: plane, point: [0, 0, 2]}" + after).size(), 1u);
  EXPECT_TRUE(says(
      doubt_of(before +
               "{shape: cylinder, name: rod, center: [0.55, 0.52, 1], radius: 0.01, length: 1}" +
               after),
      "1 of 200 triangles ... collider rod ... cloth.origin"));
  EXPECT_TRUE(says(doubt_of(before +
                            "{shape: plane, name: sheet, point: [0.25, 0, 0], normal: [1, 0, 0], "
                            "two_sided: true}" +
                            after),
                   "20 of 200 triangles ... collider sheet ... cloth.origin"));
  for (const char* apart :
       {"{shape: plane, point: [0, 0, 1]}", "{shape: plane, point: [0, 0, 2], two_sided: true}",
        "{shape: sphere, center: [0.5, 0.5, 1], radius: 0.15, enabled: false}",
        "{shape: box, center: [0.5, 0.5, 0.8], size: [1, 1, 0.4]}",
        "{shape: cylinder, center: [0.55, 0.52, 0.4], radius: 0.01, length: 1}"}) {
    EXPECT_EQ(doubts_of(before + apart + after), Lines()) << apart;
  }
}

}  // namespace
}  // namespace clothsim::doubts_test
