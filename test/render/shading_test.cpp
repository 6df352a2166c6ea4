#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "clothsim/model/errors.h"
#include "reference.h"
#include "render_fixture.h"

namespace clothsim {
namespace {

constexpr double byte_tolerance = 2;  // of 255

/// Linear colour by a formula, or nothing where the pixel is not to be compared.
using Formula = std::function<std::optional<Vector3>(const Hit&, const Vector3& view)>;

/// Draws and compares a grid of pixels that lie well on object `id` with the formula at the point
/// that the reference tracer finds. Returns the number of pixels compared.
int compare(const Snapshot& snapshot, const Camera& camera, int id, const Mesh& mesh,
            const Formula& formula, Renderer& renderer = shared_renderer()) {
  Images images;
  renderer.render(snapshot, camera, {}, images);
  int compared = 0;
  for (int v = 1; v < camera.height - 1; v += 2)
    for (int u = 1; u < camera.width - 1; u += 3) {
      if (!surrounded_by(images, u, v, id)) continue;
      const Vector3 ray = pixel_ray(camera, u, v);
      const std::optional<Hit> hit = trace(mesh, camera.pose.position, ray);
      if (!hit) continue;
      const std::optional<Vector3> expected = formula(*hit, -ray.normalized());
      if (!expected) continue;
      ++compared;
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(channel(images, u, v, c), srgb_byte((*expected)[c]), byte_tolerance)
            << "pixel " << u << " " << v << " channel " << c;
    }
  return compared;
}

Vector3 linear(const Color& color) {
  return {linear_of_srgb(color[0]), linear_of_srgb(color[1]), linear_of_srgb(color[2])};
}

/// (I / r^2) max(0, n.l)
double lambert(const Light& light, const Vector3& at, const Vector3& n) {
  const Vector3 to_light = light.position - at;
  return light.intensity / to_light.squaredNorm() * std::max(0.0, n.dot(to_light.normalized()));
}

/// ka Ia + kd (I / r^2) max(0, n.l) + ks (I / r^2) max(0, n.h)^p, ka and kd times the colour
Vector3 blinn_phong(const Phong& p, const Light& light, const Vector3& albedo, const Vector3& at,
                    const Vector3& n, const Vector3& view) {
  const Vector3 to_light = light.position - at;
  const Vector3 h = (to_light.normalized() + view).normalized();
  Vector3 sum = Vector3::Zero();
  if (p.ambient) sum += p.ka * light.ambient * albedo;
  if (p.diffuse) sum += p.kd * albedo * lambert(light, at, n);
  if (p.specular)
    sum += Vector3::Constant(p.ks * light.intensity / to_light.squaredNorm() *
                             std::pow(std::max(0.0, n.dot(h)), p.power));
  return sum;
}

/// A smooth image of a few pixels, so that a pixel of the picture is smaller than one of its own.
std::shared_ptr<const Image> small_image() {
  auto image = std::make_shared<Image>();
  image->width = 6;
  image->height = 5;
  for (int y = 0; y < image->height; ++y)
    for (int x = 0; x < image->width; ++x)
      for (const double level :
           {0.5 + 0.4 * std::sin(1.1 * x), 0.5 + 0.4 * std::cos(1.3 * y), 0.2 + 0.1 * x})
        image->rgb.push_back(static_cast<std::uint8_t>(255 * level));
  return image;
}

std::shared_ptr<const HeightMap> small_heights(int size = 8) {
  auto map = std::make_shared<HeightMap>();
  map->width = size;
  map->height = size + 1;
  for (int y = 0; y < map->height; ++y)
    for (int x = 0; x < map->width; ++x)
      map->heights.push_back(static_cast<float>(0.5 + 0.25 * std::sin(2 * M_PI * x / map->width) +
                                                0.25 * std::cos(2 * M_PI * y / map->height)));
  return map;
}

/// A waved cloth above which a camera and a light stand, and a sphere; each shaded in turn.
struct Stage {
  Snapshot snapshot = flat_cloth(16, 16);
  Camera camera = camera_with_fov(120, 90, 0.9);
  Mesh cloth, sphere;

  Stage() {
    Points positions = *snapshot.positions;
    for (Eigen::Index i = 0; i < positions.rows(); ++i)
      positions(i, 2) = 0.06 * std::sin(5 * positions(i, 0)) * std::cos(4 * positions(i, 1));
    move_cloth(snapshot, positions);
    camera.pose = look_at({-0.3, -0.6, 1.2}, {0.6, 0.4, 0.1});
    snapshot.light = {{1.2, -0.4, 1.5}, 2, 0.8};
    snapshot.colliders.resize(1);
    snapshot.colliders[0].shape = Sphere{0.3};
    snapshot.colliders[0].segments = 48;
    snapshot.colliders[0].pose = {
        {0.9, 0.9, 0.45},
        Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Vector3(0.3, 1, 0.2).normalized()))};
    cloth = cloth_mesh(snapshot);
    sphere = collider_mesh(snapshot.colliders[0]);
  }

  /// Compares cloth and sphere with this shading.
  void expect(const Shading& shading, const Formula& formula) {
    validate(shading);
    snapshot.cloth_shading = shading;
    snapshot.colliders[0].shading = shading;
    EXPECT_GT(compare(snapshot, camera, 1, cloth, formula), 150);
    EXPECT_GT(compare(snapshot, camera, 2, sphere, formula), 50);
  }
};

TEST(Shading, Normal) {
  // Not sRGB: what is compared is the byte itself.
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
  stage.expect(Textured{image}, [&](const Hit& hit, const Vector3&) {
    return Vector3(sample(*image, 0, hit.uv), sample(*image, 1, hit.uv), sample(*image, 2, hit.uv));
  });
}

TEST(Shading, PhongTexture) {
  Stage stage;
  PhongTexture shading{small_image(), {0.1, 0.8, 0.3, 20}};
  stage.expect(shading, [&](const Hit& hit, const Vector3& view) {
    const Vector3 albedo(sample(*shading.image, 0, hit.uv), sample(*shading.image, 1, hit.uv),
                         sample(*shading.image, 2, hit.uv));
    return blinn_phong(shading.phong, stage.snapshot.light, albedo, hit.position, hit.normal, view);
  });
}

/// The normal of a height map at a hit, on the side it is seen from.
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

/// Six faces, each of one colour.
std::shared_ptr<const CubeMap> colored_cube() {
  auto cube = std::make_shared<CubeMap>();
  const std::uint8_t colors[6][3] = {{255, 0, 0},   {0, 255, 255}, {0, 255, 0},
                                     {255, 0, 255}, {0, 0, 255},   {255, 255, 0}};
  for (std::size_t i = 0; i < 6; ++i) {
    cube->faces[i] = {16, 16, {}};
    for (int k = 0; k < 256; ++k)
      cube->faces[i].rgb.insert(cube->faces[i].rgb.end(), colors[i], colors[i] + 3);
  }
  return cube;
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
      if (name == "wireframe") continue;  // lines have no area and are seen
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
        "16 x 16 against 128 x 128, heights %.2f m, rms of 255: bump %.1f, displacement "
        "%.1f\n",
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
}  // namespace clothsim
