#include "clothsim/scene/points_yaml.h"

#include <gtest/gtest.h>

#include "clothsim/model/grid.h"
#include "clothsim/scene/scene_yaml.h"

namespace clothsim::points_yaml_test {
namespace {

using GridPoints = std::vector<std::array<int, 2>>;

/// A vertical cloth of 0.6 m x 0.4 m above (1, 2, 3) with cells of 0.1 m.
ClothSpec spec() {
  ClothSpec cloth;
  cloth.width = 0.6;
  cloth.height = 0.4;
  cloth.columns = 7;
  cloth.rows = 5;
  cloth.orientation = Orientation::vertical;
  cloth.origin = {1, 2, 3};
  return cloth;
}

GridPoints points(const std::string& text) {
  const ClothSpec cloth = spec();
  return PointReader(cloth).read(YAML::Load(text));
}

TEST(PointsByPlace, AreTheNearest) {
  EXPECT_EQ(points("{near: [1.21, 2, 3.29]}"), (GridPoints{{2, 3}}));
  EXPECT_EQ(points("{near: [-9, 2, 9]}"), (GridPoints{{0, 4}}));
  EXPECT_EQ(points("{uv: [0, 1]}"), (GridPoints{{0, 4}}));
  EXPECT_EQ(points("{uv: [0.52, 0.24]}"), (GridPoints{{3, 1}}));
  EXPECT_EQ(points("{uv: [0.5, 0.125]}"), (GridPoints{{3, 0}})) << "between two: the first";
  EXPECT_EQ(points("[2, 4]"), (GridPoints{{2, 4}}));
}

TEST(PointsByPlace, AreAllWithinADistance) {
  EXPECT_EQ(points("{within: 0.105, of: [1, 2, 3]}"), (GridPoints{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(points("{within: 0.2, of: [1.3, 2, 3]}").size(), 9u) << "on the rim";
  EXPECT_EQ(points("{within: 10, of: [1, 2, 3]}").size(), 35u);
  const ClothSpec cloth = spec();
  const Cloth grid = make_grid(cloth);
  const Vector3 middle(1.3, 2.05, 3.2);
  const GridPoints found =
      PointReader(cloth).read(YAML::Load("{within: 0.2, of: [1.3, 2.05, 3.2]}"));
  int expected = 0;
  for (int i = 0; i < grid.num_points(); ++i) {
    expected += (grid.rest_positions.row(i).transpose() - middle).norm() <= 0.2;
  }
  EXPECT_EQ(found.size(), static_cast<std::size_t>(expected));
}

TEST(PointsByPlace, DoNotDependOnTheOrderOfKeys) {
  const Scene scene = read_scene(YAML::Load(
      "{motions: [{attach: hand, points: [3, [1, 0], {uv: [1, 1]}]},"
      " {detach: hand, points: [{near: [0, 0, 1]}]}],"
      " cloth: {pinned: [{uv: [1, 0], frame: ring, strength: 5}, {within: 0.3, of: [0, 1, 1]}],"
      " columns: 5, rows: 9}}"));
  ASSERT_EQ(scene.cloth.pinned.size(), 6u);
  EXPECT_EQ(scene.cloth.pinned[0].column, 4);
  EXPECT_EQ(scene.cloth.pinned[0].row, 0);
  EXPECT_EQ(scene.cloth.pinned[0].frame, "ring");
  EXPECT_EQ(scene.cloth.pinned[0].strength, 5);
  EXPECT_EQ(scene.cloth.pinned[1].row, 6);
  EXPECT_EQ(std::get<AttachPoints>(scene.motions[0].action).points, (std::vector<int>{3, 1, 44}));
  EXPECT_EQ(std::get<DetachPoints>(scene.motions[1].action).points, (std::vector<int>{0}));
}

TEST(PointsByPlace, AreThoseOfAttachedBodies) {
  const Scene scene = read_scene(YAML::Load(
      "{cloth: {attached: [{body: ball, points: [{uv: [0.5, 0.5]}, [0, 0]]}], columns: 3, rows: 3},"
      " colliders: [{name: ball, shape: sphere, mass: 1}]}"));
  EXPECT_EQ(scene.cloth.attached[0].points, (GridPoints{{1, 1}, {0, 0}}));
}

TEST(PointsByPlace, AreRefusedWithTheCloth) {
  const auto refusal = [](const std::string& cloth) -> std::string {
    try {
      read_scene(YAML::Load("{cloth: " + cloth + "}"));
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal("{columns: 0, pinned: [{uv: [0, 0]}]}").rfind("cloth.columns: got 0", 0), 0u);
  EXPECT_EQ(refusal("{columns: 100000}, motions: [{attach: a, points: [[9, 9]]}]")
                .rfind("cloth.columns: got 100000", 0),
            0u);
  EXPECT_EQ(refusal("{pinned: [{within: 0.1, of: [0, 0, 1]}, [99, 0]]}")
                .rfind("cloth.pinned.1: got [99, 0]", 0),
            0u);
  EXPECT_NE(refusal("{pinned: [{uv: [0, 0]}, [0, 0]]}").find("again"), std::string::npos);
  EXPECT_EQ(refusal("{pinned: [{within: 0, of: [0, 0, 1]}]}"), "accepted");
}

}  // namespace
}  // namespace clothsim::points_yaml_test
