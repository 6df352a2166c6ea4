// Views, and pictures made of them.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "clothsim/model/errors.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/view/contact_sheet.h"
#include "clothsim/view/resources.h"
#include "clothsim/view/snapshot_maker.h"
#include "clothsim/view/view_yaml.h"
#include "says.h"
#include "temporary_folder.h"

namespace clothsim::view_test {
namespace {

namespace fs = std::filesystem;

/// Key and got of the error that ends the reading and preparing of this view.
std::string refused(const std::string& yaml) {
  try {
    ImageStore images(textures_folder());
    prepare(read_view(YAML::Load(yaml)), images);
  } catch (const InvalidValue& error) {
    return error.message("", ".");
  }
  return "nothing";
}

void expect_refused(const std::string& yaml, const std::string& start) {
  const std::string message = refused(yaml);
  EXPECT_EQ(message.substr(0, start.size()), start) << message;
}

TEST(View, AnEmptyOneHasDefaultsThatCanBeDrawn) {
  EXPECT_EQ(refused("{}"), "nothing");
  const View view = read_view(YAML::Load("{}"));
  EXPECT_EQ(view.camera.width, 640);
  EXPECT_EQ(view.cloth.shader, "blinn_phong");
}

// In the default view, or that of a fabric's scene, a cloth of any shipped scene is in the picture
// from its start until it rests.
class SceneInView : public ::testing::TestWithParam<std::string> {};

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& file : fs::directory_iterator(CLOTHSIM_SCENES_DIR))
    names.push_back(file.path().stem().string());
  return names;
}

TEST_P(SceneInView, StaysInThePictureAndFillsIt) {
  ImageStore images(textures_folder());
  const bool has_own = std::set<std::string>{"arm",  "bag",     "curtain", "disc",  "drag",
                                             "flag", "napkins", "t_shirt", "towel", "trousers"}
                           .count(GetParam()) > 0;
  const std::string own = package_folder("config/views") + "/" + GetParam() + ".yaml";
  const YAML::Node view = has_own ? load_scene_file(own) : YAML::Load("{}");
  const Camera camera = prepare(read_view(view), images).camera;
  const Eigen::Matrix3d to_camera = camera.pose.orientation.conjugate().toRotationMatrix();
  Simulator simulator(
      read_scene(load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/" + GetParam() + ".yaml")));

  constexpr double run = 3;  // [s] longer than any of them falls, swings over or spreads
  Eigen::AlignedBox2d seen;  // bounds of the cloth in the picture
  while (simulator.state().time < run) {
    for (const auto& point : simulator.state().positions.rowwise()) {
      const Vector3 p = to_camera * (point.transpose() - camera.pose.position);
      seen.extend(Eigen::Vector2d(camera.fx * p.x() / p.z() + camera.cx,
                                  camera.fy * p.y() / p.z() + camera.cy));
    }
    const double time = simulator.state().time;
    ASSERT_GE(seen.min().minCoeff(), 0) << "beyond the left or upper edge at " << time << " s";
    ASSERT_LE(seen.max().x(), camera.width - 1) << "beyond the right edge at " << time << " s";
    ASSERT_LE(seen.max().y(), camera.height - 1) << "beyond the lower edge at " << time << " s";
    simulator.step();
  }
  const double share = std::max(seen.sizes().x() / camera.width, seen.sizes().y() / camera.height);
  EXPECT_GT(share, 0.5);
}

INSTANTIATE_TEST_SUITE_P(All, SceneInView, ::testing::ValuesIn(shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

TEST(View, EachShaderCanBeNamedAndNeedsNoMore) {
  for (const std::string& name : shading_names()) {
    EXPECT_EQ(refused("{cloth: {shader: " + name + "}, collider: {shader: " + name + "}}"),
              "nothing");
  }
}

TEST(View, FieldOfViewOrFocalLengths) {
  const Camera wide = read_view(YAML::Load("{width: 200, height: 100, field_of_view: 1.5}")).camera;
  EXPECT_DOUBLE_EQ(wide.fx, 100 / std::tan(0.75));
  EXPECT_DOUBLE_EQ(wide.cx, 99.5);
  const Camera odd =
      read_view(YAML::Load("{width: 200, height: 100, fx: 150, fy: 140, cx: 90, cy: 60}")).camera;
  EXPECT_EQ(odd.fx, 150);
  EXPECT_EQ(odd.fy, 140);
  EXPECT_EQ(odd.cx, 90);
  EXPECT_EQ(odd.cy, 60);
  expect_refused("{fx: 100, fy: 100, field_of_view: 1}", "field_of_view: got 1");
  expect_refused("{fx: 100}", "fy: got nothing");
}

TEST(View, CollidersOfANameTakeTheRestFromAll) {
  const View view = read_view(YAML::Load(
      "{colliders: {sphere: {shader: cartoon}}, collider: {segments: 20, color: [1, 0, 0]}}"));
  EXPECT_EQ(view.collider.look.shader, "blinn_phong");
  EXPECT_EQ(view.colliders.at("sphere").look.shader, "cartoon");
  EXPECT_EQ(view.colliders.at("sphere").segments, 20);
  EXPECT_EQ(view.colliders.at("sphere").look.color, Color(1, 0, 0));
}

TEST(View, ShadowsAreOffUnlessAskedFor) {
  ImageStore images(textures_folder());
  EXPECT_FALSE(prepare(read_view(YAML::Load("{}")), images).light.shadows);
  EXPECT_TRUE(prepare(read_view(YAML::Load("{shadows: true}")), images).light.shadows);
}

TEST(View, MistakesAreNamed) {
  expect_refused("{widht: 3}", "widht: got an unknown key");
  expect_refused("{width: 0}", "width: got 0");
  expect_refused("{width: 3.5}", "width: got 3.5");
  expect_refused("{height: 9000}", "height: got 9000");
  expect_refused("{field_of_view: 3.2}", "field_of_view: got 3.2");
  expect_refused("{eye: [1, 2]}", "eye: got [1, 2]");
  expect_refused("{eye: [1, 2, 3], target: [1, 2, 3]}", "target: got");
  expect_refused("{near: 2, far: 1}", "far: got 1");
  expect_refused("{rate: 0}", "rate: got 0");
  expect_refused("{light: {intensity: -1}}", "light.intensity: got -1");
  expect_refused("{depth_noise: {sigma: -1}}", "depth_noise.sigma: got -1");
  expect_refused("{depth_noise: {sigma: 2}}", "depth_noise.sigma: got 2");
  expect_refused("{depth_noise: {sigma: .nan}}", "depth_noise.sigma: got");
  expect_refused("{depth_noise: {seed: -1}}", "depth_noise.seed: got -1");
  expect_refused("{depth_noise: {seed: 1.5}}", "depth_noise.seed: got 1.5");
  expect_refused("{depth_noise: {sigmas: 1}}", "depth_noise.sigmas: got an unknown key");
  expect_refused("{depth_noise: 0.1}", "depth_noise: got 0.1");
  expect_refused("{shadows: 3}", "shadows: got 3");
  expect_refused("{shadows: [true]}", "shadows: got [true]");
  expect_refused("{background: [0, 0, 2]}", "background.2: got 2");
  expect_refused("{sky: no/such/sky}", "sky: got \"no/such/sky\"");
  expect_refused("{cloth: {shader: shiny}}", "cloth.shader: got shiny");
  expect_refused("{cloth: {power: 0}}", "cloth.power: got 0");
  expect_refused("{cloth: {shader: texture, texture: no.png}}", "cloth.texture: got \"no.png\"");
  expect_refused("{cloth: {alpha: 2}}", "cloth.alpha: got 2");  // for a shader that is not chosen
  expect_refused("{cloth: {levels: 0}}", "cloth.levels: got 0");
  expect_refused("{cloth: {texture: no.png}}", "cloth.texture: got \"no.png\"");
  expect_refused("{cloth: {environment: no/such/sky}}", "cloth.environment: got \"no/such");
  const std::string too_long(300, 'x');  // for the name of a file
  for (const char* key : {"texture", "height_map", "environment"})
    expect_refused("{cloth: {" + std::string(key) + ": " + too_long + "}}",
                   "cloth." + std::string(key) + ": got \"" + too_long + '"');
  expect_refused("{collider: {segments: 2}}", "collider.segments: got 2");
  expect_refused("{colliders: {ball: {color: [2, 0, 0]}}}", "colliders.ball.color.0: got 2");
}

TEST(View, AClothOfSeveralTakesTheLookOfAllWhereItHasNone) {
  const View view = read_view(
      YAML::Load("{cloths: {upper: {color: [0, 0, 1]}}, cloth: {shader: diffuse, kd: 0.5}}"));
  EXPECT_EQ(view.cloths.at("upper").shader, "diffuse");
  EXPECT_EQ(view.cloths.at("upper").phong.kd, 0.5);
  EXPECT_EQ(view.cloths.at("upper").color, Color(0, 0, 1));
  EXPECT_NE(view.cloth.color, Color(0, 0, 1));
  expect_refused("{cloths: {upper: {power: 0}}}", "cloths.upper.power: got 0");
  expect_refused("{cloths: {upper: {shade: diffuse}}}", "cloths.upper.shade: got an unknown key");
  expect_refused("{cloths: [upper]}", "cloths: got");

  const Scene stack =
      read_scene(load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/napkins.yaml"));
  EXPECT_NO_THROW(check_names(view, stack));
  const auto refusal = [&](const Scene& scene) -> std::string {
    try {
      check_names(read_view(YAML::Load("{cloths: {middle: {}}}")), scene);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_TRUE(says(refusal(stack), "cloths.middle ... lower, upper"));
  EXPECT_TRUE(says(refusal(Scene()), "cloths.middle ... `cloth`"));
  EXPECT_TRUE(without_missing_names(view, Scene()).cloths.empty());
  EXPECT_EQ(without_missing_names(view, stack).cloths.size(), 1u);

  ImageStore images(textures_folder());
  SnapshotMaker maker;
  const Simulator simulator(stack);
  const Snapshot snapshot = maker.make(simulator, prepare(view, images));
  ASSERT_EQ(snapshot.cloth_shadings.size(), 2u);
  EXPECT_EQ(std::get<Diffuse>(snapshot.cloth_shadings[0]).color, view.cloth.color);
  EXPECT_EQ(std::get<Diffuse>(snapshot.cloth_shadings[1]).color, Color(0, 0, 1));
}

TEST(View, CollidersMustBeThoseOfTheScene) {
  Scene scene;
  scene.colliders.resize(1);
  scene.colliders[0].name = "sphere";
  const View view = read_view(YAML::Load("{colliders: {sphere: {}}}"));
  EXPECT_NO_THROW(check_names(view, scene));
  scene.colliders[0].name = "ball";
  try {
    check_names(view, scene);
    FAIL() << "took a look for a collider that is not there";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), (std::vector<std::string>{"colliders", "sphere"}));
    EXPECT_NE(std::string(error.what()).find("ball"), std::string::npos) << error.what();
  }
}

TEST(Resources, AreFoundBesideTheInstalledLibrary) {
  // PREFIX/lib, and Debian's PREFIX/lib/x86_64-linux-gnu.
  const test::TemporaryFolder prefix("installed");
  const fs::path shaders = prefix.path() / "share/clothsim/shaders";
  const auto found_from = [&](const char* folder) {
    const fs::path library = prefix.path() / folder / "libclothsim_view.so";
    fs::create_directories(library.parent_path());
    std::ofstream(library).close();
    return find_installed(library.string(), "shaders");
  };
  EXPECT_FALSE(found_from("lib"));
  fs::create_directories(shaders);
  for (const char* folder : {".", "lib", "lib/x86_64-linux-gnu"})
    EXPECT_EQ(found_from(folder), shaders.string()) << folder;
  // Other folders above a build folder are not ours.
  EXPECT_FALSE(found_from("src/clothsim/build/devel/lib"));
}

TEST(View, AnImageIsReadAgainWhenItsFileHasChanged) {
  const fs::path path = fs::path(::testing::TempDir()) / "clothsim_texture.png";
  save_image(path.string(), {1, 1, {1, 2, 3}});
  ImageStore images(textures_folder());
  const auto first = images.image(path.string(), "texture");
  EXPECT_EQ(images.image(path.string(), "texture"), first);
  save_image(path.string(), {1, 1, {4, 5, 6}});
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(2));
  EXPECT_EQ(images.image(path.string(), "texture")->rgb[0], 4);
  EXPECT_EQ(first->rgb[0], 1);
  fs::remove(path);
}

TEST(View, ACubeMapIsReadAgainWhenOneOfItsFacesHasChanged) {
  const test::TemporaryFolder folder("cube");
  const auto save = [&](const char* face, std::uint8_t level) {
    save_image((folder.path() / (std::string(face) + ".png")).string(),
               {1, 1, {level, level, level}});
  };
  for (const char* face : {"posx", "negx", "posy", "negy", "posz", "negz"}) save(face, 1);
  ImageStore images(textures_folder());
  const auto first = images.cube_map(folder.path().string(), "sky");
  EXPECT_EQ(images.cube_map(folder.path().string(), "sky"), first);
  save("posx", 4);  // in place: the folder itself does not change
  const fs::path posx = folder.path() / "posx.png";
  fs::last_write_time(posx, fs::last_write_time(posx) + std::chrono::seconds(2));
  EXPECT_EQ(images.cube_map(folder.path().string(), "sky")->faces[0].rgb[0], 4);
}

TEST(View, ImagesAreKeptAsLongAsTheyAreUsed) {
  const test::TemporaryFolder folder("used");
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  save_image(path("a.png"), {1, 1, {1, 1, 1}});
  save_image(path("b.png"), {1, 1, {2, 2, 2}});
  ImageStore images(textures_folder());
  const std::weak_ptr<const Image> a = images.image(path("a.png"), "texture");
  const std::weak_ptr<const Image> b = images.image(path("b.png"), "texture");
  const std::weak_ptr<const HeightMap> h = images.height_map(path("a.png"), "height_map");
  images.sweep();
  EXPECT_EQ(images.image(path("b.png"), "texture"), b.lock());
  images.sweep();
  EXPECT_TRUE(a.expired());
  EXPECT_TRUE(h.expired());
  EXPECT_FALSE(b.expired());
}

TEST(SnapshotMaker, SharesWhatDidNotChange) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 5;
  scene.colliders.resize(1);
  scene.colliders[0].name = "ball";
  scene.colliders[0].pose.position = {0, 0, -5};
  Simulator simulator(scene);
  ImageStore images(textures_folder());
  const PreparedView view =
      prepare(read_view(YAML::Load("{colliders: {ball: {shader: cartoon}}}")), images);
  SnapshotMaker maker;
  const Snapshot first = maker.make(simulator, view);
  EXPECT_STREQ(shading_name(first.colliders[0].shading), "cartoon");
  const Snapshot paused = maker.make(simulator, view);
  EXPECT_EQ(paused.cloth, first.cloth);
  EXPECT_EQ(paused.positions, first.positions);

  simulator.step();
  const Snapshot moved = maker.make(simulator, view);
  EXPECT_EQ(moved.cloth, first.cloth);
  EXPECT_NE(moved.positions, first.positions);
  EXPECT_EQ(*moved.positions, simulator.state().positions);
  EXPECT_EQ(*first.positions, simulator.cloth().rest_positions) << "a snapshot changed";

  Material material = scene.cloth.material;
  material.springs = {true, false, false};
  simulator.set_material(material);
  EXPECT_LT(maker.make(simulator, view).cloth->springs.size(), first.cloth->springs.size());

  LiveSpec thicker = live_values(simulator.scene());
  thicker.thickness = 0.05;  // a rope's picture depends on it
  simulator.set(thicker);
  EXPECT_EQ(maker.make(simulator, view).cloth->thickness, 0.05);
}

TEST(ContactSheet, PutsTilesInRows) {
  std::vector<Tile> tiles(3);
  for (std::size_t i = 0; i < 3; ++i) {
    Image& image = tiles[i].image;
    image.width = 1;
    image.height = 2;
    image.rgb.assign(6, static_cast<std::uint8_t>(i));
  }
  const Image sheet = contact_sheet(tiles, 2);
  EXPECT_EQ(sheet.width, 6);   // 1 + 4 + 1
  EXPECT_EQ(sheet.height, 8);  // 2 + 4 + 2
  const auto at = [&](int x, int y) {
    return sheet.rgb[static_cast<std::size_t>(3 * (y * sheet.width + x))];
  };
  EXPECT_EQ(at(0, 0), 0);
  EXPECT_EQ(at(5, 1), 1);
  EXPECT_EQ(at(0, 6), 2);
  EXPECT_EQ(at(5, 6), 255);
}

}  // namespace
}  // namespace clothsim::view_test
