#include <gtest/gtest.h>

#include <cmath>

#include "stage.h"

// Each shader against its formula, computed in double at the surface points of the pixels.

namespace clothsim::shading_test {
namespace {

TEST(Shading, Normal) {
  // Not sRGB: the test compares the byte itself.
  Stage stage;
  stage.snapshot.cloth_shading = NormalColor{};
  const Images images = draw(stage.snapshot, stage.camera);
  int compared = 0;
  for (int v = 1; v < stage.camera.height - 1; v += 2)
    for (int u = 1; u < stage.camera.width - 1; u += 3) {
      if (!surrounded_by(images, u, v, 1)) continue;
      const auto hit =
          trace(stage.cloth, stage.camera.pose.position, pixel_ray(stage.camera, u, v));
      ASSERT_TRUE(hit);
      ++compared;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(channel(images, u, v, c), 255 * 0.5 * (1 + hit->normal[c]), byte_tolerance);
    }
  EXPECT_GT(compared, 300);
}

TEST(Shading, Diffuse) {
  Stage stage;
  Diffuse diffuse;
  diffuse.kd = 0.7;
  stage.expect(diffuse, [&](const Hit& hit, const Vector3&) {
    return Vector3(0.7 * linear(diffuse.color) *
                   lambert(stage.snapshot.light, hit.position, hit.normal));
  });
}

TEST(Shading, BlinnPhongByComponent) {
  Stage stage;
  for (const int which : {0, 1, 2, 3}) {
    BlinnPhong shading;
    shading.phong = {0.15,
                     0.6,
                     0.4,
                     30,
                     which == 0 || which == 3,
                     which == 1 || which == 3,
                     which == 2 || which == 3};
    stage.expect(shading, [&](const Hit& hit, const Vector3& view) {
      return blinn_phong(shading.phong, stage.snapshot.light, linear(shading.color), hit.position,
                         hit.normal, view);
    });
  }
}

TEST(Shading, Texture) {
  Stage stage;
  const auto image = small_image();
  stage.expect(
      Textured{image},
      [&](const Hit& hit, const Vector3&) {
        return Vector3(sample(*image, 0, hit.uv), sample(*image, 1, hit.uv),
                       sample(*image, 2, hit.uv));
      },
      filtered_tolerance);
}

TEST(Shading, PhongTexture) {
  Stage stage;
  PhongTexture shading{small_image(), {0.1, 0.8, 0.3, 20}};
  stage.expect(
      shading,
      [&](const Hit& hit, const Vector3& view) {
        const Vector3 albedo(sample(*shading.image, 0, hit.uv), sample(*shading.image, 1, hit.uv),
                             sample(*shading.image, 2, hit.uv));
        return blinn_phong(shading.phong, stage.snapshot.light, albedo, hit.position, hit.normal,
                           view);
      },
      filtered_tolerance);
}

/// The normal of a height map at a hit, on the visible side.
Vector3 bumped(const Bump& bump, const Hit& hit) {
  const HeightMap& map = *bump.height_map;
  const double here = sample(map, hit.uv);
  const double scale = bump.height_scaling * bump.normal_scaling;
  const double du = scale * (sample(map, hit.uv + Eigen::Vector2d(1.0 / map.width, 0)) - here);
  const double dv = scale * (sample(map, hit.uv + Eigen::Vector2d(0, 1.0 / map.height)) - here);
  const double side = hit.front ? 1 : -1;
  const Vector3 n = side * hit.normal;
  const Vector3 t = (hit.tangent - n * n.dot(hit.tangent)).normalized();
  return side * (-du * t - dv * n.cross(t) + n).normalized();
}

TEST(Shading, Bump) {
  Stage stage;
  Bump bump;
  bump.height_map = small_heights();
  bump.height_scaling = 0.05;
  bump.normal_scaling = 60;
  bump.phong.power = 20;
  stage.expect(bump, [&](const Hit& hit, const Vector3& view) {
    return blinn_phong(bump.phong, stage.snapshot.light, linear(bump.color), hit.position,
                       bumped(bump, hit), view);
  });
}

/// The mesh with its vertices moved along their normals.
Mesh displaced(Mesh mesh, const Bump& bump) {
  for (Eigen::Index i = 0; i < mesh.positions.rows(); ++i)
    mesh.positions.row(i) += bump.height_scaling *
                             sample(*bump.height_map, mesh.uv.row(i).transpose()) *
                             mesh.normals.row(i);
  return mesh;
}

TEST(Shading, DisplacementMovesColourAndDepth) {
  Stage stage;
  Displacement shading;
  shading.height_map = small_heights();
  shading.height_scaling = 0.08;
  shading.normal_scaling = 30;
  shading.phong.power = 20;
  stage.snapshot.cloth_shading = shading;
  stage.snapshot.colliders[0].shading = shading;
  const std::array<Mesh, 2> meshes{displaced(stage.cloth, shading),
                                   displaced(stage.sphere, shading)};
  const Formula formula = [&](const Hit& hit, const Vector3& view) {
    return blinn_phong(shading.phong, stage.snapshot.light, linear(shading.color), hit.position,
                       bumped(shading, hit), view);
  };
  const Images images = draw(stage.snapshot, stage.camera);
  for (const int id : {1, 2}) {
    const Mesh& mesh = meshes[static_cast<std::size_t>(id - 1)];
    EXPECT_GT(compare(stage.snapshot, stage.camera, id, mesh, formula), 60);
    for (int v = 1; v < stage.camera.height - 1; v += 2)
      for (int u = 1; u < stage.camera.width - 1; u += 3) {
        if (!surrounded_by(images, u, v, id)) continue;
        const auto hit = trace(mesh, stage.camera.pose.position, pixel_ray(stage.camera, u, v));
        ASSERT_TRUE(hit);
        EXPECT_NEAR(images.depth[static_cast<std::size_t>(v * images.width + u)], hit->distance,
                    1e-4);
      }
  }
}

/// The colour of that cube in a direction of the world, or nothing near the border of two faces.
std::optional<Vector3> cube_color(const Vector3& world) {
  const Vector3 d(world.x(), world.z(), world.y());  // +y of the cube is up
  int axis = 0;
  const double largest = d.cwiseAbs().maxCoeff(&axis);
  for (int other = 0; other < 3; ++other)
    if (other != axis && std::abs(d[other]) > 0.7 * largest) return std::nullopt;
  const Vector3 face = Vector3::Unit(axis);
  return d[axis] > 0 ? face : Vector3(Vector3::Ones() - face);
}

TEST(Shading, MirrorShowsTheFaceThatTheReflectionMeets) {
  Stage stage;
  stage.expect(Mirror{colored_cube()}, [&](const Hit& hit, const Vector3& view) {
    return cube_color(2 * hit.normal.dot(view) * hit.normal - view);
  });
}

TEST(Shading, TheSkyStandsBehindEverything) {
  Snapshot snapshot;
  snapshot.background.sky = colored_cube();
  for (const Vector3& target : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0),
                                Vector3(0, -1, 0), Vector3(0, 0, 1), Vector3(0.2, 0.7, -1)}) {
    Camera camera = camera_with_fov(40, 30, 1.2);
    camera.cx += 4;
    camera.fy *= 1.3;
    camera.pose = look_at({0, 0, 0}, target);
    const Images images = draw(snapshot, camera);
    int compared = 0;
    for (int v = 0; v < 30; v += 3)
      for (int u = 0; u < 40; u += 3) {
        const auto expected = cube_color(pixel_ray(camera, u, v));
        if (!expected) continue;
        ++compared;
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(channel(images, u, v, c), srgb_byte((*expected)[c]), 0.5) << u << " " << v;
      }
    EXPECT_GT(compared, 20);
  }
}

TEST(Shading, CartoonHasLevels) {
  Stage stage;
  Cartoon cartoon;
  cartoon.levels = 5;
  stage.expect(cartoon, [&](const Hit& hit, const Vector3&) -> std::optional<Vector3> {
    const double diffuse =
        std::min(1.0, lambert(stage.snapshot.light, hit.position, hit.normal)) * cartoon.levels;
    if (std::abs(diffuse - std::round(diffuse)) < 0.05) return std::nullopt;  // on a step
    return Vector3(linear(cartoon.color) * (std::floor(diffuse) / cartoon.levels + 0.1));
  });
}

TEST(Shading, WireframeDrawsTheFamiliesAskedForInTheirColours) {
  Stage stage;
  stage.snapshot.colliders.clear();
  stage.snapshot.background.color = {0, 0, 0};
  Wireframe wireframe;
  wireframe.colors = {Color{1, 0, 0}, Color{0, 1, 0}, Color{0, 0, 1}};
  const auto seen = [&](bool structural, bool shear, bool bending) {
    wireframe.families = {structural, shear, bending};
    stage.snapshot.cloth_shading = wireframe;
    const Images images = draw(stage.snapshot, stage.camera);
    std::array<int, 3> strong{};
    for (std::size_t i = 0; i < images.color.size(); ++i) strong[i % 3] += images.color[i] > 100;
    return strong;
  };
  const auto shear = seen(false, true, false);
  EXPECT_EQ(shear[0], 0);
  EXPECT_GT(shear[1], 500);
  EXPECT_EQ(shear[2], 0);
  const auto without_shear = seen(true, false, true);
  EXPECT_GT(without_shear[0], 500);
  EXPECT_EQ(without_shear[1], 0);
  const auto none = seen(false, false, false);
  EXPECT_EQ(none[0] + none[1] + none[2], 0);
  const auto all = seen(true, true, true);
  EXPECT_GT(all[0], 500);
  EXPECT_GT(all[1], 500);
}

}  // namespace
}  // namespace clothsim::shading_test
