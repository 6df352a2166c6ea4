#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/model/errors.h"
#include "stage.h"

// Back sides, grazing angles, degenerate triangles, meshes too coarse, values out of range.

namespace clothsim::shading_limits_test {
namespace {

TEST(Shading, TheBackOfTheClothIsLitFromItsOwnSide) {
  Stage stage;
  stage.camera.pose = look_at({-0.2, -0.5, -1.1}, {0.5, 0.5, 0});
  stage.snapshot.light.position = {0.8, -0.3, -1.2};
  BlinnPhong shading;
  stage.snapshot.cloth_shading = shading;
  int lit = 0;
  EXPECT_GT(compare(stage.snapshot, stage.camera, 1, stage.cloth,
                    [&](const Hit& hit, const Vector3& view) {
                      EXPECT_FALSE(hit.front);
                      lit += lambert(stage.snapshot.light, hit.position, hit.normal) > 0.1;
                      return blinn_phong(shading.phong, stage.snapshot.light, linear(shading.color),
                                         hit.position, hit.normal, view);
                    }),
            300);
  EXPECT_GT(lit, 300);
}

TEST(Shading, GrazingAnglesAndFoldsFollowTheFormulaToo) {
  // A cloth folded over along its middle, seen almost edge on.
  Stage stage;
  Points positions = *stage.snapshot.positions;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    if (positions(i, 0) > 0.5) {
      positions(i, 2) += 0.02 + 0.1 * (positions(i, 0) - 0.5);
      positions(i, 0) = 1 - positions(i, 0);
    }
  move_cloth(stage.snapshot, positions);
  stage.snapshot.colliders.clear();
  stage.camera.pose = look_at({0.2, -0.8, 0.09}, {0.25, 0.5, 0.03});
  BlinnPhong shading;
  stage.snapshot.cloth_shading = shading;
  // Each pixel covers several triangles; without antialiasing it shows the one at its centre.
  Renderer single({CLOTHSIM_SHADERS_DIR, {}, 1});
  EXPECT_GT(compare(
                stage.snapshot, stage.camera, 1, cloth_mesh(stage.snapshot),
                [&](const Hit& hit, const Vector3& view) {
                  return blinn_phong(shading.phong, stage.snapshot.light, linear(shading.color),
                                     hit.position, hit.normal, view);
                },
                single),
            50);
  for (const float depth : draw(stage.snapshot, stage.camera).depth)
    EXPECT_FALSE(std::isnan(depth));
}

TEST(Shading, CollapsedClothsLeaveNoTrace) {
  // Triangles without area in every shader: nothing is drawn, nothing is NaN, nothing throws.
  Stage stage;
  const Points spread = *stage.snapshot.positions;
  stage.snapshot.background.color = {0, 0, 0};
  for (const std::string& name : shading_names()) {
    Shading shading = make_shading(name);
    if (auto* s = std::get_if<Textured>(&shading)) s->image = small_image();
    if (auto* s = std::get_if<PhongTexture>(&shading)) s->image = small_image();
    if (auto* s = std::get_if<Translucent>(&shading)) s->image = small_image();
    if (auto* s = std::get_if<Bump>(&shading)) s->height_map = small_heights();
    if (auto* s = std::get_if<Mirror>(&shading)) s->environment = colored_cube();
    if (auto* s = std::get_if<Displacement>(&shading)) {
      s->height_map = small_heights();
      s->height_scaling = 0;
    }
    validate(shading);
    stage.snapshot.cloth_shading = shading;
    stage.snapshot.colliders.clear();
    for (const Vector3& scale : {Vector3(0, 0, 0), Vector3(1, 0, 0)}) {
      move_cloth(stage.snapshot, spread * scale.asDiagonal());
      const Images images = draw(stage.snapshot, stage.camera);
      for (const float depth : images.depth) EXPECT_EQ(depth, INFINITY) << name;
      if (name == "wireframe") continue;  // lines have no area and are visible
      for (const std::uint8_t value : images.color) EXPECT_EQ(value, 0) << name;
    }
  }
}

/// Heights with ten waves around and along: more than a mesh of 16 x 16 can carry.
std::shared_ptr<const HeightMap> fine_heights() {
  auto map = std::make_shared<HeightMap>();
  map->width = map->height = 120;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 120; ++x)
      map->heights.push_back(static_cast<float>(0.5 + 0.5 * std::sin(2 * M_PI * x / 12) *
                                                          std::sin(2 * M_PI * y / 12)));
  return map;
}

TEST(Shading, BumpHardlyChangesWithTheMeshDisplacementDoes) {
  Snapshot snapshot;
  snapshot.colliders.resize(1);
  ColliderView& sphere = snapshot.colliders[0];
  sphere.shape = Sphere{0.3};
  Camera camera = camera_with_fov(96, 72, 0.6);
  camera.pose = look_at({1, -1, 0.5}, {0, 0, 0});
  const auto picture = [&](auto shading, int segments, double height_scaling) {
    shading.height_map = fine_heights();
    shading.height_scaling = height_scaling;
    shading.normal_scaling = 0.5 / height_scaling;
    sphere.shading = shading;
    sphere.segments = segments;
    return draw(snapshot, camera);
  };
  // Root mean square difference of the colours well on the sphere, 0 to 255.
  const auto difference = [&](const Images& a, const Images& b) {
    double sum = 0;
    int count = 0;
    for (int v = 0; v < a.height; ++v)
      for (int u = 0; u < a.width; ++u) {
        if (!surrounded_by(a, u, v, 2) || !surrounded_by(b, u, v, 2)) continue;
        sum += std::pow(channel(a, u, v, 0) - channel(b, u, v, 0), 2);
        ++count;
      }
    return std::sqrt(sum / count);
  };
  for (const double height_scaling : {0.01, 0.1}) {
    const double bump =
        difference(picture(Bump{}, 16, height_scaling), picture(Bump{}, 128, height_scaling));
    const double displacement = difference(picture(Displacement{}, 16, height_scaling),
                                           picture(Displacement{}, 128, height_scaling));
    std::printf(
        "16 x 16 against 128 x 128, heights %.2f m, rms of 255: bump %.1f, displacement %.1f\n",
        height_scaling, bump, displacement);
    EXPECT_LT(bump, 6);
    if (height_scaling == 0.1) {
      EXPECT_GT(displacement, 4 * bump);
    }
  }
}

TEST(Shading, BadValuesAreRefusedByName) {
  const auto refused = [](const Shading& shading) {
    try {
      validate(shading);
    } catch (const InvalidValue& error) {
      return error.key().front();
    }
    return std::string("nothing");
  };
  BlinnPhong phong;
  EXPECT_EQ(refused(phong), "nothing");
  phong.phong.power = 0;
  EXPECT_EQ(refused(phong), "power");
  phong.phong = {};
  phong.phong.ks = NAN;
  EXPECT_EQ(refused(phong), "ks");
  phong.phong = {};
  phong.color[1] = 1.5;
  EXPECT_EQ(refused(phong), "color");
  EXPECT_EQ(refused(Textured{}), "texture");
  EXPECT_EQ(refused(Bump{}), "height_map");
  EXPECT_EQ(refused(Mirror{}), "environment");
  Cartoon cartoon;
  cartoon.levels = 0;
  EXPECT_EQ(refused(cartoon), "levels");
  Translucent translucent{small_image(), {}, 2};
  EXPECT_EQ(refused(translucent), "alpha");
  EXPECT_THROW(make_shading("shiny"), InvalidValue);
}

}  // namespace
}  // namespace clothsim::shading_limits_test
