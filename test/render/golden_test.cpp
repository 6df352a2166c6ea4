#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "render_fixture.h"

// A few whole pictures against those in goldens/. With CLOTHSIM_UPDATE_GOLDENS=1 in the
// environment the pictures are written anew: look at them before they are committed.

namespace clothsim::golden_test {
namespace {

namespace fs = std::filesystem;

// Drivers round colours and cover edges in their own ways.
constexpr int channel_tolerance = 6;            // of 255
constexpr double failing_share_allowed = 0.01;  // of the pixels

/// A waved cloth over a sphere above a plane.
Snapshot scene(const Shading& cloth, const Shading& sphere) {
  Snapshot snapshot = flat_cloth(24, 24);
  Points positions = *snapshot.positions;
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    positions(i, 2) =
        0.75 + 0.08 * std::sin(7 * positions(i, 0) + 1) * std::cos(6 * positions(i, 1));
  move_cloth(snapshot, positions);
  snapshot.cloth_shading = cloth;
  snapshot.colliders.resize(2);
  snapshot.colliders[0].shape = Sphere{0.25};
  snapshot.colliders[0].pose.position = {0.3, -0.15, 0.3};
  snapshot.colliders[0].shading = sphere;
  snapshot.colliders[1].shape = Plane{};
  snapshot.colliders[1].extent = 4;
  snapshot.colliders[1].shading = Diffuse{{0.5, 0.5, 0.5}, 1};
  return snapshot;
}

/// Minimum and maximum of a channel within `reach` pixels of one.
std::pair<int, int> range_around(const Image& image, int u, int v, int channel, int reach) {
  std::pair<int, int> range{255, 0};
  for (int y = std::max(0, v - reach); y <= std::min(image.height - 1, v + reach); ++y)
    for (int x = std::max(0, u - reach); x <= std::min(image.width - 1, u + reach); ++x) {
      const int value = image.rgb[static_cast<std::size_t>(3 * (y * image.width + x) + channel)];
      range = {std::min(range.first, value), std::max(range.second, value)};
    }
  return range;
}

/// `reach`: largest distance to a place with that colour in the golden picture [pixels].
void expect_golden(const std::string& name, const Snapshot& snapshot, int reach = 0) {
  Camera camera = camera_with_fov(160, 120, 0.9);
  camera.pose = look_at({-0.6, -1.5, 1.3}, {0.5, 0.4, 0.5});
  const Images images = draw(snapshot, camera);
  const Image actual{images.width, images.height, images.color};
  const std::string path = std::string(CLOTHSIM_GOLDENS_DIR) + "/" + name + ".png";
  if (std::getenv("CLOTHSIM_UPDATE_GOLDENS")) save_image(path, actual);

  const auto golden = load_image(path, "golden");
  ASSERT_EQ(golden->rgb.size(), actual.rgb.size());
  Image difference = actual;
  int failing = 0;
  for (int v = 0; v < actual.height; ++v)
    for (int u = 0; u < actual.width; ++u) {
      int worst = 0;
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(3 * (v * actual.width + u) + c);
        const auto [least, most] = range_around(*golden, u, v, c, reach);
        const int off = std::max({0, least - actual.rgb[i], actual.rgb[i] - most});
        worst = std::max(worst, off);
        difference.rgb[i] = static_cast<std::uint8_t>(std::min(255, 8 * off));
      }
      failing += worst > channel_tolerance;
    }
  const double share = 3.0 * failing / static_cast<double>(actual.rgb.size());
  if (share > failing_share_allowed) {
    fs::create_directories(CLOTHSIM_IMAGES_OUT);
    const std::string out = std::string(CLOTHSIM_IMAGES_OUT) + "/" + name;
    save_image(out + "_actual.png", actual);
    save_image(out + "_diff.png", difference);
    ADD_FAILURE() << name << ": " << 100 * share << " % of the pixels differ by more than "
                  << channel_tolerance << "; see " << out << "_actual.png and _diff.png";
  }
}

std::string texture(const char* name) { return std::string(CLOTHSIM_TEXTURES_DIR) + "/" + name; }

TEST(Golden, PhongTextureOverBlinnPhong) {
  expect_golden(
      "phong_texture",
      scene(PhongTexture{load_image(texture("fabric.png"), "texture"), {}}, BlinnPhong{}));
}

TEST(Golden, WireframeOverCartoon) {
  const int beside_lines = 1;  // where lines cross, drivers cover samples in other orders
  expect_golden("wireframe", scene(Wireframe{}, Cartoon{}), beside_lines);
}

TEST(Golden, TranslucentOverMirrorUnderTheSky) {
  const auto sky = load_cube_map(texture("sky"), "sky");
  Translucent veil;
  veil.image = load_image(texture("fabric.png"), "texture");
  Snapshot snapshot = scene(veil, Mirror{sky});
  snapshot.background.sky = sky;
  expect_golden("translucent", snapshot);
}

TEST(Golden, BumpOverDisplacement) {
  Bump bump;
  bump.height_map = load_height_map(texture("quilt_height.png"), "height_map");
  bump.height_scaling = 0.01;
  Displacement displacement;
  displacement.height_map = bump.height_map;
  displacement.height_scaling = 0.05;
  displacement.normal_scaling = 20;
  expect_golden("bump", scene(bump, displacement));
}

}  // namespace
}  // namespace clothsim::golden_test
