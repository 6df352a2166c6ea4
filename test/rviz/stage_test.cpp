#include "rviz/stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "clothsim/scene/scene_yaml.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_rviz::stage_test {
namespace {

using clothsim::Vector3;
using Box = Eigen::AlignedBox3d;

// RViz's camera as in config/rviz/clothsim.rviz, in a window a little wider than high.
const Vector3 out(std::cos(0.9) * std::cos(0.5), std::sin(0.9) * std::cos(0.5), std::sin(0.5));
const Lens lens{1.2 * std::tan(M_PI / 8), std::tan(M_PI / 8)};

/// Image coordinates of a point, from -1 to 1 across the picture and up.
Eigen::Vector2d seen(const Vector3& point, const Vector3& focus, double distance) {
  const Vector3 across = Vector3::UnitZ().cross(out).normalized();
  const Vector3 up = out.cross(across);
  const Vector3 way = point - focus;
  const double ahead = distance - out.dot(way);
  return {across.dot(way) / ahead / lens.across, up.dot(way) / ahead / lens.up};
}

/// The part of the picture in which the cloth is seen during the first seconds.
Eigen::AlignedBox2d seen_in(clothsim::Simulator& simulator, const Vector3& focus, double distance) {
  Eigen::AlignedBox2d part;
  for (int frame = 0; frame < 200; ++frame) {
    if (frame > 0) simulator.step();
    const auto& positions = simulator.state().positions;
    for (Eigen::Index i = 0; i < positions.rows(); ++i) {
      part.extend(seen(positions.row(i).transpose(), focus, distance));
    }
  }
  return part;
}

class Scenes : public testing::TestWithParam<std::string> {};

TEST_P(Scenes, ClothIsSeenWholeAndLarge) {
  const clothsim::Scene scene = clothsim::read_scene(
      clothsim::load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/" + GetParam() + ".yaml"));
  const Box stage = stage_of(scene);
  clothsim::Simulator simulator(scene);
  const Eigen::AlignedBox2d part =
      seen_in(simulator, stage.center(), viewing_distance(stage, out, lens));
  EXPECT_GT(part.min().minCoeff(), -1);
  EXPECT_LT(part.max().maxCoeff(), 1);
  EXPECT_GT(part.sizes().maxCoeff(), 0.7) << part.sizes().transpose();  // of 2
}

INSTANTIATE_TEST_SUITE_P(Of, Scenes,
                         testing::Values("arm", "curtain", "flag", "grasp", "napkins", "pinned2",
                                         "pinned4", "plane", "rod", "self_collision", "sphere",
                                         "table", "tablecloth", "three_spheres", "towel"),
                         [](const auto& scene) { return scene.param; });

TEST(Stage, IsWhereRVizHasTheWorld) {
  clothsim::Scene scene;
  const clothsim::Pose moved{{1, 2, 3}, Eigen::Quaterniond(std::sqrt(0.5), 0, 0, std::sqrt(0.5))};
  const Box here = stage_of(scene), there = stage_of(scene, moved);
  EXPECT_TRUE(there.center().isApprox(clothsim::to_world(moved, here.center())));
  EXPECT_TRUE(there.sizes().isApprox(here.sizes()));  // of a square, turned by a right angle
}

TEST(Stage, AFarColliderDoesNotMakeTheClothSmall) {
  clothsim::Scene scene;
  scene.cloth.pinned = {{0, 0, ""}};
  const Box alone = stage_of(scene);
  clothsim::ColliderSpec far;
  far.pose.position = {100, 0, 0};
  scene.colliders = {far};
  EXPECT_TRUE(stage_of(scene).isApprox(alone));
}

TEST(Stage, ABoxFillsThePicture) {
  const Box box(Vector3(-1, -2, 0), Vector3(3, 1, 2));
  const double distance = viewing_distance(box, out, lens);
  double most = 0;
  for (int i = 0; i < 8; ++i) {
    const Vector3 corner = box.corner(static_cast<Box::CornerType>(i));
    most = std::max(most, seen(corner, box.center(), distance).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(most, 1);
  EXPECT_GT(most, 0.85);
}

}  // namespace
}  // namespace clothsim_rviz::stage_test
