#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "scene_text.h"
#include "temporary_folder.h"

namespace clothsim::scene_file_test {
namespace {

std::string write_temporary(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + name;
  std::ofstream(path) << text;
  return path;
}

TEST(SceneFile, RefusesWhatIsNoYamlFile) {
  EXPECT_THROW(load_scene_file("no/such/file.yaml"), InvalidValue);
  EXPECT_THROW(load_scene_file(::testing::TempDir()), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("open.yaml", "cloth: [1, 2")), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("tail.yaml", "cloth: {}\n}")), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("two.yaml", "cloth: {}\n---\ncloth: {}")),
               InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("deep.yaml", std::string(100'000, '['))),
               InvalidValue);
  EXPECT_THROW(load_scene_file("/dev/zero"), InvalidValue);
}

/// The message that refuses a file.
std::string file_refusal(const std::string& path) {
  try {
    load_scene_file(path);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

// Opening a pipe that nobody writes to would wait for ever.
TEST(SceneFile, AsksForARegularFile) {
  const clothsim::test::TemporaryFolder folder("pipe");
  const std::string pipe = folder.path() / "pipe.yaml";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, std::string("/dev/zero"), std::string("/dev/tty")}) {
    const std::string message = file_refusal(path);
    EXPECT_NE(message.find("expected a regular file"), std::string::npos) << message;
  }
}

// The file has no size, and reading it waits for the next line of the kernel.
TEST(SceneFile, AFileWithoutSizeIsEmpty) {
  if (access("/proc/kmsg", R_OK) != 0) GTEST_SKIP() << "no /proc/kmsg that can be read";
  EXPECT_THROW(read_scene(load_scene_file("/proc/kmsg")), InvalidValue);
}

TEST(SceneFile, DeepYamlIsToldAsSuch) {
  const std::string deep = std::string(1000, '[') + std::string(1000, ']');
  const std::string message = file_refusal(write_temporary("deeper.yaml", "cloth:\n  " + deep));
  EXPECT_NE(message.find("too deep inside one another in line 2"), std::string::npos) << message;
}

TEST(SceneFile, AnEmptyFileIsNoScene) {
  const YAML::Node root = load_scene_file(write_temporary("empty.yaml", "# nothing\n"));
  EXPECT_THROW(read_scene(root), InvalidValue);
}

TEST(SceneFile, TextIsReadLikeAFile) {
  EXPECT_EQ(print(read_scene(load_scene_text(good_scene, "scene"))), print(read_changed({})));
  for (const char* text : {"cloth: [", "a: 1\n---\nb: 2\n"}) {
    try {
      load_scene_text(text, "scene");
      FAIL() << text;
    } catch (const InvalidValue& error) {
      EXPECT_EQ(error.key(), std::vector<std::string>{"scene"});
    }
  }
}

Scene load(const std::string& name) {
  return read_scene(load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/" + name + ".yaml"));
}

/// The default cloth with `pins`.
Scene default_scene(const std::vector<Pin>& pins) {
  Scene scene;
  scene.cloth.pinned = pins;
  return scene;
}

ColliderSpec ground() {
  ColliderSpec collider;
  collider.name = "ground";
  collider.shape = Plane{false};
  collider.friction = 0.5;
  return collider;
}

TEST(SceneFile, Pinned2) {
  EXPECT_EQ(print(load("pinned2")), print(default_scene({{0, 0, ""}, {49, 0, ""}})));
}

TEST(SceneFile, Pinned4) {
  EXPECT_EQ(print(load("pinned4")),
            print(default_scene({{0, 0, ""}, {49, 0, ""}, {0, 49, ""}, {49, 49, ""}})));
}

TEST(SceneFile, Sphere) {
  ColliderSpec sphere;
  sphere.name = sphere.frame = "sphere";
  sphere.shape = Sphere{0.2};
  sphere.pose.position = {0.5, 0.5, 0.2};
  sphere.friction = 0.3;
  Scene expected;
  expected.colliders = {sphere};
  EXPECT_EQ(print(load("sphere")), print(expected));
}

TEST(SceneFile, Plane) {
  Scene expected;
  expected.colliders = {ground()};
  EXPECT_EQ(print(load("plane")), print(expected));
}

TEST(SceneFile, SelfCollision) {
  Scene expected;
  expected.cloth.orientation = Orientation::vertical;
  expected.cloth.origin = {0, 0, 0};
  expected.cloth.self_collision = SelfCollision::automatic;
  expected.colliders = {ground()};
  EXPECT_EQ(print(load("self_collision")), print(expected));
}

}  // namespace
}  // namespace clothsim::scene_file_test
