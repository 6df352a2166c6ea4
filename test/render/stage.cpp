#include "stage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothsim {

int compare(const Snapshot& snapshot, const Camera& camera, int id, const Mesh& mesh,
            const Formula& formula, Renderer& renderer, double tolerance) {
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
        EXPECT_NEAR(channel(images, u, v, c), srgb_byte((*expected)[c]), tolerance)
            << "pixel " << u << " " << v << " channel " << c;
    }
  return compared;
}

Vector3 linear(const Color& color) {
  return {linear_of_srgb(color[0]), linear_of_srgb(color[1]), linear_of_srgb(color[2])};
}

double lambert(const Light& light, const Vector3& at, const Vector3& n) {
  const Vector3 to_light = light.position - at;
  return light.intensity / to_light.squaredNorm() * std::max(0.0, n.dot(to_light.normalized()));
}

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

std::shared_ptr<const HeightMap> small_heights() {
  auto map = std::make_shared<HeightMap>();
  map->width = 8;
  map->height = 9;
  for (int y = 0; y < map->height; ++y)
    for (int x = 0; x < map->width; ++x)
      map->heights.push_back(static_cast<float>(0.5 + 0.25 * std::sin(2 * M_PI * x / map->width) +
                                                0.25 * std::cos(2 * M_PI * y / map->height)));
  return map;
}

Stage::Stage() {
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

void Stage::expect(const Shading& shading, const Formula& formula, double tolerance) {
  validate(shading);
  snapshot.cloth_shading = shading;
  snapshot.colliders[0].shading = shading;
  EXPECT_GT(compare(snapshot, camera, 1, cloth, formula, shared_renderer(), tolerance), 150);
  EXPECT_GT(compare(snapshot, camera, 2, sphere, formula, shared_renderer(), tolerance), 50);
}

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

}  // namespace clothsim
