// A cloth of one row or column, which has no surface, is drawn as a tube.

#include "clothsim/render/tube.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/model/grid.h"
#include "render_fixture.h"

namespace clothsim::tube_test {
namespace {

constexpr double thickness = 0.05;  // [m]
constexpr double height = 2;        // [m] of the camera

/// A line of 11 points, 1 m long, along x or y.
Snapshot rope(int columns, int rows) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.origin.setZero();
  spec.thickness = thickness;
  Snapshot snapshot;
  snapshot.cloth = std::make_shared<Cloth>(make_grid(spec));
  move_cloth(snapshot, snapshot.cloth->rest_positions);
  return snapshot;
}

/// From above, so that x goes to the right and y upwards in the picture.
Camera above(double x, double y) {
  Camera camera = camera_with_fov(121, 121, 0.8);
  camera.pose.position = {x, y, height};
  camera.pose.orientation = Eigen::AngleAxisd(M_PI, Vector3::UnitX());
  return camera;
}

TEST(Tube, IsSeenInColourDepthAndMask) {
  for (const bool row : {true, false}) {
    const Camera camera = row ? above(0.5, 0) : above(0, 0.5);
    for (const Shading& shading :
         {Shading(BlinnPhong{}), Shading(Translucent{}), Shading(Bump{})}) {
      Snapshot snapshot = row ? rope(11, 1) : rope(1, 11);
      const std::shared_ptr<const Image> white(new Image{1, 1, {255, 255, 255}});
      const std::shared_ptr<const HeightMap> flat(new HeightMap{1, 1, {0}});
      snapshot.cloth_shading = shading;
      if (auto* s = std::get_if<Translucent>(&snapshot.cloth_shading)) s->image = white;
      if (auto* s = std::get_if<Bump>(&snapshot.cloth_shading)) s->height_map = flat;
      const Images images = draw(snapshot, camera);
      int across = 0, along = 0;
      for (int i = 0; i < 121; ++i) {
        const int u = row ? 60 : i, v = row ? i : 60;
        across += images.mask[static_cast<std::size_t>(v * 121 + u)] == 1;
        along += images.mask[static_cast<std::size_t>(u * 121 + v)] == 1;
      }
      // In pixels: its outline is that of a cylinder, its ends are round.
      EXPECT_NEAR(across, 2 * thickness * camera.fx / height, 1.5) << row;
      EXPECT_NEAR(along, (1 + 2 * thickness) * camera.fx / height, 1.5) << row;
      const auto middle = static_cast<std::size_t>(60 * 121 + 60);
      EXPECT_NEAR(images.depth[middle], height - thickness, 0.05 * thickness) << row;
      EXPECT_GT(channel(images, 60, 60, 0), 1.5 * channel(images, 2, 2, 0)) << row;
    }
  }
}

TEST(Tube, FollowsItsPoints) {
  Snapshot snapshot = rope(11, 1);
  const Camera camera = above(0.5, 0);
  draw(snapshot, camera);
  Points moved = *snapshot.positions;
  moved.col(1).array() += 0.3;
  move_cloth(snapshot, moved);
  const Images images = draw(snapshot, camera);
  const int v = 60 - static_cast<int>(std::lround(0.3 * camera.fx / height));
  EXPECT_EQ(images.mask[static_cast<std::size_t>(v * 121 + 60)], 1);
  EXPECT_EQ(images.mask[static_cast<std::size_t>(60 * 121 + 60)], 0);
}

TEST(Tube, NormalsPointOutAndTangentsAlongU) {
  Points line(5, 3);
  line << 0, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1, 1, 0, 0.5, 1;
  for (const TubeAlong along : {TubeAlong::u, TubeAlong::v}) {
    const Mesh mesh = tube_mesh(line, 0.1, along);
    for (Eigen::Index i = 5; i < mesh.normals.rows(); ++i) {
      EXPECT_NEAR(mesh.normals.row(i).norm(), 1, 1e-12);
      EXPECT_NEAR(mesh.tangents.row(i).norm(), 1, 1e-12);
      EXPECT_NEAR(mesh.tangents.row(i).dot(mesh.normals.row(i)), 0, 1e-12);
    }
    Points straight(2, 3);
    straight << 0, 0, 0, 0.3, 0.4, 0.5;
    const Mesh simple = tube_mesh(straight, 0.1, along);
    for (const auto& t : simple.triangles) {
      const Vector3 a = simple.positions.row(t[0]), b = simple.positions.row(t[1]),
                    c = simple.positions.row(t[2]);
      const Vector3 area = (b - a).cross(c - a), n = simple.normals.row(t[0]);
      if (area.norm() < 1e-6) continue;  // at the tips
      EXPECT_GT(area.dot(n), 0);
      const double du_b = simple.uv(t[1], 0) - simple.uv(t[0], 0);
      const Vector3 tangent = simple.tangents.row(t[0]);
      if (std::abs(du_b) > 1e-9) {
        EXPECT_GT(du_b * (b - a).dot(tangent), 0);
      }
    }
  }
}

TEST(Tube, IsFiniteWherePointsMeetOrTurnBack) {
  Points line(6, 3);
  line << 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1e-300, 0, 0, -1;
  const Mesh mesh = tube_mesh(line, 0.1, TubeAlong::u);
  EXPECT_TRUE(mesh.positions.allFinite());
  EXPECT_TRUE(mesh.normals.allFinite());
  EXPECT_TRUE(mesh.tangents.allFinite());
  EXPECT_LT(mesh.positions.rowwise().norm().maxCoeff(), 1.2);
}

}  // namespace
}  // namespace clothsim::tube_test
