// What the images of the surfaces hold beside depth and mask (pixels_test.cpp), against the ray
// through each pixel's centre.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "clothsim/model/grid.h"
#include "clothsim/render/visible_points.h"
#include "stage.h"

namespace clothsim {
namespace {

WantedImages everything() {
  WantedImages wanted;
  wanted.uv = wanted.normals = wanted.flow = true;
  return wanted;
}

Images draw_all(const Snapshot& snapshot, const Camera& camera) {
  Images images;
  shared_renderer().render(snapshot, camera, everything(), images);
  return images;
}

/// The values of pixel (u, v) of an image with two or three a pixel.
template <int channels>
Eigen::Matrix<double, channels, 1> pixel(const Images& images, const std::vector<float>& image,
                                         int u, int v) {
  Eigen::Matrix<double, channels, 1> values;
  for (int c = 0; c < channels; ++c)
    values[c] = double(image[static_cast<std::size_t>(channels * (v * images.width + u) + c)]);
  return values;
}

int id(const Images& images, int u, int v) {
  return images.mask[static_cast<std::size_t>(v * images.width + u)];
}

/// Calls visit(u, v) for each pixel.
template <class Visit>
void for_each_pixel(const Camera& camera, const Visit& visit) {
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) visit(u, v);
}

// ---- uv ----

TEST(Truth, UvIsThatOfTheClothWhereTheRayMeetsIt) {
  Stage stage;  // 0.1 of uv are some 10 pixels
  const Images images = draw_all(stage.snapshot, stage.camera);
  int on_cloth = 0;
  for_each_pixel(stage.camera, [&](int u, int v) {
    const Eigen::Vector2d uv = pixel<2>(images, images.uv, u, v);
    if (id(images, u, v) != 1) {
      EXPECT_TRUE(std::isnan(uv.x()) && std::isnan(uv.y())) << u << " " << v;
      return;
    }
    const auto hit = trace(stage.cloth, stage.camera.pose.position, pixel_ray(stage.camera, u, v));
    if (!hit) return;  // the rim runs through the pixel
    const auto depth = images.depth[static_cast<std::size_t>(v * images.width + u)];
    if (std::abs(hit->distance - double(depth)) > 1e-4) return;  // as does the rim of a fold
    EXPECT_LT((uv - hit->uv).norm(), 1e-5) << u << " " << v;
    ++on_cloth;
  });
  EXPECT_GT(on_cloth, 2000);
}

TEST(Truth, UvOfAPointIsItsColumnAndRow) {
  Snapshot snapshot = flat_cloth(4, 3);
  Camera camera = camera_with_fov(101, 101, 1);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images images = draw_all(snapshot, camera);
  for (int i = 0; i < 12; ++i) {
    const Vector3 inside = 0.98 * (snapshot.positions->row(i).transpose() - Vector3(0.5, 0.5, 0));
    const Vector3 seen = camera.pose.orientation.conjugate() *
                         (inside + Vector3(0.5, 0.5, 0) - camera.pose.position);
    const int u = static_cast<int>(std::lround(camera.fx * seen.x() / seen.z() + camera.cx));
    const int v = static_cast<int>(std::lround(camera.fy * seen.y() / seen.z() + camera.cy));
    const Eigen::Vector2d expected(i % 4 / 3.0, i / 4 / 2.0);
    EXPECT_LT((pixel<2>(images, images.uv, u, v) - expected).norm(), 0.03) << i;
  }
}

TEST(Truth, UvOfARopeGoesAlongIt) {
  Snapshot snapshot = flat_cloth(30, 1);
  Camera camera = camera_with_fov(200, 60, 1);
  camera.pose = look_at({0.5, -0.4, 0}, {0.5, 0, 0});
  const Images images = draw_all(snapshot, camera);
  int on_rope = 0;
  for_each_pixel(camera, [&](int u, int v) {
    if (id(images, u, v) != 1) return;
    const double along = 0.5 + 0.4 * (u - camera.cx) / camera.fx;
    const double given = pixel<2>(images, images.uv, u, v).x();
    EXPECT_NEAR(given, along, snapshot.cloth->thickness + 0.01) << u << " " << v;
    ++on_rope;
  });
  EXPECT_GT(on_rope, 100);
}

// ---- Normals ----

/// In the optical frame, bent back where a smooth normal leans away from the camera.
Vector3 expected_normal(const Camera& camera, const Vector3& normal, const Vector3& ray) {
  const Vector3 along = ray.normalized();
  const Vector3 facing = normal - std::max(0.0, normal.dot(along)) * along;
  return camera.pose.orientation.conjugate() * facing.normalized();
}

TEST(Truth, NormalsAreThoseOfTheClothAndOfTheExactSphere) {
  Stage stage;
  stage.snapshot.colliders[0].segments = 8;  // of a mesh that does not show
  const Images images = draw_all(stage.snapshot, stage.camera);
  const Vector3 eye = stage.camera.pose.position;
  const Vector3 centre = stage.snapshot.colliders[0].pose.position;
  int on_cloth = 0, on_sphere = 0;
  for_each_pixel(stage.camera, [&](int u, int v) {
    const Vector3 normal = pixel<3>(images, images.normals, u, v);
    const Vector3 ray = pixel_ray(stage.camera, u, v);
    const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
    if (id(images, u, v) == 0) {
      EXPECT_TRUE(std::isnan(normal.x()) && std::isnan(normal.y()) && std::isnan(normal.z()));
      return;
    }
    EXPECT_NEAR(normal.norm(), 1, 1e-5);
    EXPECT_LT((stage.camera.pose.orientation * normal).dot(ray.normalized()), 1e-5);
    if (id(images, u, v) == 2) {
      const Vector3 radius = (eye + depth * ray - centre) / 0.3;
      EXPECT_LT((stage.camera.pose.orientation * normal - radius).norm(), 1e-5) << u << " " << v;
      ++on_sphere;
      return;
    }
    const auto hit = trace(stage.cloth, eye, ray);
    if (!hit || std::abs(hit->distance - depth) > 1e-4) return;  // a rim runs through the pixel
    const Vector3 expected = expected_normal(stage.camera, hit->normal, ray);
    EXPECT_LT((normal - expected).norm(), 1e-4) << u << " " << v;
    ++on_cloth;
  });
  EXPECT_GT(on_cloth, 2000);
  EXPECT_GT(on_sphere, 300);
}

/// Whether the shape has about this normal at a point of its surface, on the side that the ray
/// comes from. On an edge either face's will do.
bool is_normal(const Shape& shape, const Vector3& at, const Vector3& normal, const Vector3& ray) {
  constexpr double aside = 2e-3;  // [m]
  for (int i = 0; i < 8; ++i) {
    const Vector3 near = at + aside * Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    const Vector3 outward = signed_distance(shape, near, near).normal;
    if (normal.dot(outward.dot(ray) < 0 ? outward : Vector3(-outward)) > 0.98) return true;
  }
  return false;
}

TEST(Truth, NormalsOfEachShapeFaceTheCamera) {
  // From outside, and from within: planes and boxes exactly, round ones as finely as they are
  // meshed.
  for (const Shape& shape :
       {Shape(Plane{}), Shape(Cuboid{{0.3, 0.2, 0.4}}), Shape(Capsule{0.5, 0.2}),
        Shape(Cylinder{0.5, 0.2}), Shape(Sphere{0.3})}) {
    Snapshot snapshot;
    snapshot.colliders.resize(1);
    snapshot.colliders[0].shape = shape;
    for (const Vector3& eye : {Vector3(1, -1.5, 1.1), Vector3(0.01, 0.02, 0.03)}) {
      Camera camera = camera_with_fov(80, 60, 1);
      camera.pose = look_at(eye, {-0.3, 0.5, -0.2});
      const Images images = draw_all(snapshot, camera);
      int seen = 0;
      for_each_pixel(camera, [&](int u, int v) {
        if (id(images, u, v) == 0) return;
        ++seen;
        const Vector3 ray = pixel_ray(camera, u, v);
        const Vector3 normal = camera.pose.orientation * pixel<3>(images, images.normals, u, v);
        const auto depth = double(images.depth[static_cast<std::size_t>(v * images.width + u)]);
        EXPECT_TRUE(is_normal(shape, eye + depth * ray, normal, ray)) << u << " " << v;
        EXPECT_LT(normal.dot(ray), 1e-5);
      });
      EXPECT_GT(seen, 100);
    }
  }
}

TEST(Truth, NormalsOfADisplacedSurfaceAreThoseOfItsTriangles) {
  // Height grows with u: a plane that is tilted.
  Snapshot snapshot = flat_cloth(6, 6);
  Displacement displacement;
  const auto slope = std::make_shared<HeightMap>();
  slope->width = slope->height = 64;
  for (int i = 0; i < 64 * 64; ++i) slope->heights.push_back(static_cast<float>(i % 64) / 63);
  displacement.height_map = slope;
  displacement.height_scaling = 0.3;
  snapshot.cloth_shading = displacement;
  Camera camera = camera_with_fov(80, 60, 0.5);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images images = draw_all(snapshot, camera);
  const Vector3 normal = camera.pose.orientation * pixel<3>(images, images.normals, 40, 30);
  EXPECT_LT((normal - Vector3(-0.3, 0, 1).normalized()).norm(), 0.02);
}

// ---- Flow ----

/// Where a camera has a point [pixel].
Eigen::Vector2d project(const Camera& c, const Vector3& point) {
  const Vector3 p = c.pose.orientation.conjugate() * (point - c.pose.position);
  return {c.fx * p.x() / p.z() + c.cx, c.fy * p.y() / p.z() + c.cy};
}

Images draw_flow(const Snapshot& snapshot, const Camera& camera) {
  WantedImages wanted;
  wanted.flow = true;
  Images images;
  shared_renderer().render(snapshot, camera, wanted, images);
  return images;
}

/// So that the next picture has nothing to have come from.
void forget_last_picture() { draw(flat_cloth(2, 2), camera_with_fov(8, 8, 1)); }

/// A cloth that bends, a ball that rolls, and a box and a camera that move and turn.
struct Moving {
  Stage stage;
  Snapshot now;
  Camera camera_now;

  Moving() {
    ColliderView box;
    box.shape = Cuboid{{0.3, 0.2, 0.25}};
    box.pose.position = {0.15, 0.8, 0.3};
    stage.snapshot.colliders.push_back(box);
    now = stage.snapshot;
    Points moved = *now.positions;
    for (Eigen::Index i = 0; i < moved.rows(); ++i)
      moved.row(i) +=
          0.05 * Vector3(std::sin(3 * moved(i, 1)), moved(i, 0), moved(i, 1)).transpose();
    move_cloth(now, moved);
    for (ColliderView& collider : now.colliders) {
      collider.pose.position += Vector3(0.03, -0.02, 0.04);
      collider.pose.orientation =
          Eigen::AngleAxisd(0.2, Vector3(1, 2, -1).normalized()) * collider.pose.orientation;
    }
    camera_now = stage.camera;
    camera_now.pose = look_at({-0.25, -0.55, 1.25}, {0.62, 0.43, 0.12});
    camera_now.fx *= 1.1;
    camera_now.cy -= 2;
  }
};

/// A mesh of now whose tangents are the positions that its points had before: what trace() blends.
Mesh with_positions_before(Mesh now, const Mesh& before) {
  now.tangents = before.positions;
  return now;
}

TEST(Truth, FlowLeadsFromWhereTheLastPictureHadTheSurface) {
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

TEST(Truth, FlowOfAKnownMoveAcrossTheView) {
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

TEST(Truth, FlowOfADisplacedSurfaceAndOfARope) {
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

/// How many pixels of an object have a flow, and how many do not.
std::pair<int, int> with_and_without_flow(const Images& images, int object) {
  std::pair<int, int> counts;
  for (std::size_t i = 0; i < images.mask.size(); ++i) {
    if (images.mask[i] != object) continue;
    ++(std::isnan(images.flow[2 * i]) ? counts.second : counts.first);
  }
  return counts;
}

TEST(Truth, WhatWasNotThereHasNoFlow) {
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

TEST(Truth, WhatWasBehindTheCameraHasNoFlow) {
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

// ---- Visible points ----

std::vector<std::uint32_t> draw_visible(const Snapshot& snapshot, const Camera& camera) {
  WantedImages wanted{false, false, false};
  wanted.visible_points = true;
  Images images;
  shared_renderer().render(snapshot, camera, wanted, images);
  EXPECT_TRUE(images.visible_points.has_value());
  return images.visible_points.value_or(std::vector<std::uint32_t>());
}

/// A mesh without the triangles at a point.
Mesh without_point(Mesh mesh, int point) {
  auto& all = mesh.triangles;
  all.erase(
      std::remove_if(all.begin(), all.end(),
                     [&](const auto& t) { return std::count(t.begin(), t.end(), point) > 0; }),
      all.end());
  return mesh;
}

/// By every triangle, and the sphere's equation.
bool is_visible(const Moving& moving, int i) {
  const Camera& camera = moving.camera_now;
  const Vector3 point = moving.now.positions->row(i), eye = camera.pose.position;
  const Eigen::Vector2d at = project(camera, point);
  if ((at.array() < -0.5).any() || at.x() >= camera.width - 0.5 || at.y() >= camera.height - 0.5)
    return false;
  const double length = (point - eye).norm(), most = length - on_surface;
  const Vector3 ray = (point - eye) / length;
  for (const Mesh& mesh :
       {without_point(cloth_mesh(moving.now), i), collider_mesh(moving.now.colliders[1])}) {
    const auto hit = trace(mesh, eye, ray);
    if (hit && hit->distance < most) return false;
  }
  const Vector3 center = moving.now.colliders[0].pose.position - eye;
  const double middle = center.dot(ray), aside = (center - middle * ray).norm();
  return aside > 0.3 || middle - std::sqrt(0.09 - aside * aside) > most;
}

TEST(VisiblePoints, AreThoseThatEveryTriangleLeavesFree) {
  Moving moving;  // box and ball stand before a part of the cloth
  Points folded = *moving.now.positions;
  for (Eigen::Index i = 0; i < folded.rows(); ++i)  // and it hides some of itself
    if (folded(i, 1) < 0.3) folded.row(i) = Vector3(folded(i, 0), 0.6 - folded(i, 1), 0.15);
  move_cloth(moving.now, folded);
  for (const double zoom : {1.0, 3.0}) {
    moving.camera_now.fx *= zoom;
    moving.camera_now.fy *= zoom;
    std::vector<std::uint32_t> expected;
    for (int i = 0; i < moving.now.cloth->num_points(); ++i)
      if (is_visible(moving, i)) expected.push_back(static_cast<std::uint32_t>(i));
    EXPECT_EQ(draw_visible(moving.now, moving.camera_now), expected);
    EXPECT_GT(expected.size(), 20u);
    EXPECT_LT(expected.size(), 210u);  // of 256
  }
}

TEST(VisiblePoints, WithNothingElseAreAllAndBehindAWallNone) {
  Snapshot snapshot = flat_cloth(7, 9);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 0});
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.near = 3.01;
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.near = 0.05;
  camera.far = 2.99;
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.far = 100;
  ColliderView wall;
  wall.shape = Plane{};
  wall.pose.position.z() = 1;
  snapshot.colliders = {wall};
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
  camera.near = 2.01;  // cuts the wall away
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.near = 0.05;
  snapshot.colliders[0].visible = false;
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  snapshot.colliders[0].visible = true;
  snapshot.colliders[0].pose.position.z() = -0.5 * on_surface;  // the cloth lies on it
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  snapshot.colliders[0].pose.position.z() = 0.5 * on_surface;  // as it does a little inside
  EXPECT_EQ(draw_visible(snapshot, camera).size(), 63u);
  camera.pose = look_at({0.5, 0.5, 3}, {0.5, 0.5, 6});  // looks away
  EXPECT_TRUE(draw_visible(snapshot, camera).empty());
}

TEST(VisiblePoints, OfARopeAreNotHiddenByItsTube) {
  Snapshot rope = flat_cloth(30, 1);
  Camera camera = camera_with_fov(80, 60, 1);
  camera.pose = look_at({0.5, -2, 0}, {0.5, 0, 0});
  EXPECT_EQ(draw_visible(rope, camera).size(), 30u);
  rope.colliders.resize(1);
  rope.colliders[0].pose.position = {0.5, -0.5, 0};
  const std::size_t seen = draw_visible(rope, camera).size();
  EXPECT_GT(seen, 5u);
  EXPECT_LT(seen, 25u);
}

// ---- Together ----

TEST(Truth, EachImageIsTheSameAloneAndWithOthers) {
  Stage stage;
  const Images all = draw_all(stage.snapshot, stage.camera);
  const auto same = [](const std::vector<float>& one, const std::vector<float>& other) {
    return one.size() == other.size() && !one.empty() &&
           std::memcmp(one.data(), other.data(), one.size() * sizeof(float)) == 0;
  };
  const auto draw_one = [&](bool WantedImages::*image) {
    WantedImages wanted{false, false, false};
    wanted.*image = true;
    Images images;
    shared_renderer().render(stage.snapshot, stage.camera, wanted, images);
    EXPECT_TRUE(images.color.empty() && images.depth.empty() && images.mask.empty());
    return images;
  };
  EXPECT_TRUE(same(draw_one(&WantedImages::uv).uv, all.uv));
  EXPECT_TRUE(same(draw_one(&WantedImages::normals).normals, all.normals));

  const Images usual = draw(stage.snapshot, stage.camera);
  EXPECT_EQ(usual.color, all.color);
  EXPECT_EQ(usual.depth, all.depth);
  EXPECT_EQ(usual.mask, all.mask);
  EXPECT_TRUE(usual.uv.empty() && usual.normals.empty() && usual.flow.empty());
}

}  // namespace
}  // namespace clothsim
