// Flow of moving surfaces, against the places of their points in the last picture.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "moving.h"

namespace clothsim::flow_test {
namespace {

Images draw_flow(const Snapshot& snapshot, const Camera& camera) {
  WantedImages wanted;
  wanted.flow = true;
  Images images;
  shared_renderer().render(snapshot, camera, wanted, images);
  return images;
}

/// Makes the next picture one without a predecessor.
void forget_last_picture() { draw(flat_cloth(2, 2), camera_with_fov(8, 8, 1)); }

/// The current mesh with the former positions of its points as tangents, which trace()
/// interpolates.
Mesh with_positions_before(Mesh now, const Mesh& before) {
  now.tangents = before.positions;
  return now;
}

TEST(Flow, FlowLeadsFromWhereTheLastPictureHadTheSurface) {
  Moving moving;
  const Stage& stage = moving.stage;
  forget_last_picture();
  draw_flow(stage.snapshot, stage.camera);
  const Images images = draw_flow(moving.now, moving.camera_now);
  const Mesh cloth = with_positions_before(cloth_mesh(moving.now), cloth_mesh(stage.snapshot));
  const Mesh box = with_positions_before(collider_mesh(moving.now.colliders[1]),
                                         collider_mesh(stage.snapshot.colliders[1]));
  std::array<int, 4> compared{};
  double longest = 0;
  for_each_pixel(moving.camera_now, [&](int u, int v) {
    const Eigen::Vector2d flow = pixel<2>(images, images.flow, u, v);
    const int seen = id(images, u, v);
    if (seen == 0) {
      EXPECT_TRUE(std::isnan(flow.x()) && std::isnan(flow.y()));
      return;
    }
    const Vector3 ray = pixel_ray(moving.camera_now, u, v), eye = moving.camera_now.pose.position;
    const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
    Vector3 before;
    if (seen == 2) {
      const Pose& last = stage.snapshot.colliders[0].pose;
      const Pose& present = moving.now.colliders[0].pose;
      before = last.orientation *
                   (present.orientation.conjugate() * (eye + depth * ray - present.position)) +
               last.position;
    } else {
      const auto hit = trace(seen == 1 ? cloth : box, eye, ray);
      if (!hit || std::abs(hit->distance - depth) > 1e-4) return;  // a rim runs through the pixel
      before = hit->tangent;
    }
    const Eigen::Vector2d expected = Eigen::Vector2d(u, v) - project(stage.camera, before);
    EXPECT_LT((flow - expected).norm(), 1e-3) << u << " " << v << " of " << seen;
    longest = std::max(longest, expected.norm());
    ++compared[static_cast<std::size_t>(seen)];
  });
  EXPECT_GT(compared[1], 2000);
  EXPECT_GT(compared[2], 300);
  EXPECT_GT(compared[3], 200);
  EXPECT_GT(longest, 5);
}

TEST(Flow, FlowOfAKnownMoveAcrossTheView) {
  // All at depth 2, moved by 0.1 to the right before a camera at rest: fx 0.1 / 2 pixels. Then the
  // camera follows, and nothing moves; then it goes on alone.
  Snapshot snapshot = flat_cloth(5, 5);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Vector3 right = camera.pose.orientation * Vector3::UnitX();
  const auto flow_in_the_middle = [&] {
    const Images images = draw_flow(snapshot, camera);
    return pixel<2>(images, images.flow, 40, 30);
  };
  forget_last_picture();
  flow_in_the_middle();
  move_cloth(snapshot, snapshot.positions->rowwise() + 0.1 * right.transpose());
  EXPECT_LT((flow_in_the_middle() - Eigen::Vector2d(0.05 * camera.fx, 0)).norm(), 1e-4);
  EXPECT_LT(flow_in_the_middle().norm(), 1e-4);  // nothing moves
  move_cloth(snapshot, snapshot.positions->rowwise() + 0.1 * right.transpose());
  camera.pose.position += 0.1 * right;
  EXPECT_LT(flow_in_the_middle().norm(), 1e-4);
  camera.pose.position += 0.1 * right;
  EXPECT_LT((flow_in_the_middle() + Eigen::Vector2d(0.05 * camera.fx, 0)).norm(), 1e-4);
}

TEST(Flow, FlowOfADisplacedSurfaceAndOfARope) {
  Snapshot displaced = flat_cloth(6, 6);
  Displacement displacement;
  displacement.height_map = small_heights();
  displaced.cloth_shading = displacement;
  Snapshot rope = flat_cloth(12, 1);
  Camera camera = camera_with_fov(320, 120, 0.6);
  camera.pose = look_at({0.5, -0.5, 2}, {0.5, 0.1, 0});
  const Vector3 way(0.02, 0.03, -0.01);
  for (Snapshot* snapshot : {&displaced, &rope}) {
    forget_last_picture();
    draw_flow(*snapshot, camera);
    move_cloth(*snapshot, snapshot->positions->rowwise() + way.transpose());
    const Images images = draw_flow(*snapshot, camera);
    int seen = 0;
    for_each_pixel(camera, [&](int u, int v) {
      if (id(images, u, v) == 0) return;
      const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
      const Vector3 at = camera.pose.position + depth * pixel_ray(camera, u, v);
      const Eigen::Vector2d expected = Eigen::Vector2d(u, v) - project(camera, at - way);
      EXPECT_LT((pixel<2>(images, images.flow, u, v) - expected).norm(), 1e-3) << u << " " << v;
      ++seen;
    });
    EXPECT_GT(seen, 20);
  }
}

/// Numbers of pixels of an object with a flow, and without one.
std::pair<int, int> with_and_without_flow(const Images& images, int object) {
  std::pair<int, int> counts;
  for (std::size_t i = 0; i < images.mask.size(); ++i) {
    if (images.mask[i] != object) continue;
    ++(std::isnan(images.flow[2 * i]) ? counts.second : counts.first);
  }
  return counts;
}

TEST(Flow, WhatWasNotThereHasNoFlow) {
  Moving moving;
  const auto none = [](const std::pair<int, int>& c) { return c.first == 0 && c.second > 100; };
  const auto all = [](const std::pair<int, int>& c) { return c.first > 100 && c.second == 0; };
  const auto take = [&] { return draw_flow(moving.now, moving.camera_now); };
  const auto expect = [&](const Images& images, bool cloth, bool sphere, bool box) {
    const std::array<bool, 3> there{cloth, sphere, box};
    for (std::size_t i = 0; i < there.size(); ++i) {
      const auto counts = with_and_without_flow(images, static_cast<int>(i) + 1);
      EXPECT_TRUE(there[i] ? all(counts) : none(counts)) << i << " " << counts.first;
    }
  };
  forget_last_picture();
  expect(take(), false, false, false);
  expect(take(), true, true, true);
  draw(moving.now, moving.camera_now);  // without flow
  expect(take(), false, false, false);

  moving.now.colliders[0].visible = false;
  take();
  moving.now.colliders[0].visible = true;
  expect(take(), true, false, true);
  moving.now.colliders[1].shape = Cuboid{{0.31, 0.2, 0.25}};
  expect(take(), true, true, false);
  moving.now.cloth = std::make_shared<const Cloth>(*moving.now.cloth);
  expect(take(), false, true, true);
  Snapshot other = flat_cloth(40, 40);  // of another size, and back
  moving.now.cloth.swap(other.cloth);
  moving.now.positions.swap(other.positions);
  expect(take(), false, true, true);
  moving.now.cloth.swap(other.cloth);
  moving.now.positions.swap(other.positions);
  expect(take(), false, true, true);
  moving.now.colliders.pop_back();
  take();
  moving.now.colliders.push_back(moving.stage.snapshot.colliders[1]);
  expect(take(), true, true, false);
}

TEST(Flow, WhatWasBehindTheCameraHasNoFlow) {
  Snapshot snapshot = flat_cloth(5, 5);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  forget_last_picture();
  move_cloth(snapshot, snapshot.positions->rowwise() + Vector3(0, 0, 2.5).transpose());
  draw_flow(snapshot, camera);
  move_cloth(snapshot, snapshot.positions->rowwise() - Vector3(0, 0, 2.5).transpose());
  EXPECT_EQ(with_and_without_flow(draw_flow(snapshot, camera), 1).first, 0);
  EXPECT_EQ(with_and_without_flow(draw_flow(snapshot, camera), 1).second, 0);
}

}  // namespace
}  // namespace clothsim::flow_test
