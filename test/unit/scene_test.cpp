#include "clothsim/scene/scene.h"

#include <gtest/gtest.h>

#include <limits>

#include "clothsim/model/errors.h"
#include "says.h"

namespace clothsim::scene_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Path of the key that validate() names, or "" where it accepts.
template <class Spec>
std::string refused_key(const Spec& spec) {
  try {
    validate(spec);
  } catch (const InvalidValue& error) {
    std::string path;
    for (const std::string& part : error.key()) path += (path.empty() ? "" : ".") + part;
    return path;
  }
  return "";
}

TEST(Validate, AcceptsTheDefaults) {
  EXPECT_EQ(refused_key(Material()), "");
  EXPECT_EQ(refused_key(ClothSpec()), "");
  EXPECT_EQ(refused_key(SimulationSpec()), "");
  EXPECT_EQ(refused_key(Scene()), "");
}

/// The same for the defaults after `change`.
template <class Spec>
std::string key_after(void (*change)(Spec&, double), double value = 0) {
  Spec spec;
  change(spec, value);
  return refused_key(spec);
}

TEST(Validate, MaterialKeysStandAlone) {
  using M = Material;
  for (const double bad : {nan, infinity, -1.0, 1e300}) {
    EXPECT_EQ(key_after<M>([](M& m, double x) { m.ks = x; }, bad), "ks") << bad;
    EXPECT_EQ(key_after<M>([](M& m, double x) { m.density = x; }, bad), "density") << bad;
    EXPECT_EQ(key_after<M>([](M& m, double x) { m.damping = x; }, bad), "damping") << bad;
    EXPECT_EQ(key_after<M>([](M& m, double x) { m.strain_limit = x; }, bad), "strain_limit") << bad;
  }
}

TEST(Validate, SimulationKeysStandAlone) {
  using S = SimulationSpec;
  EXPECT_EQ(key_after<S>([](S& s, double x) { s.gravity.y() = x; }, nan), "gravity.1");
  EXPECT_EQ(key_after<S>([](S& s, double x) { s.frames_per_second = x; }, infinity),
            "frames_per_second");
  EXPECT_EQ(key_after<S>([](S& s, double) { s.substeps = 0; }), "substeps");
  EXPECT_EQ(key_after<S>([](S& s, double x) { s.tolerance = x; }), "tolerance");
  EXPECT_EQ(key_after<S>([](S& s, double x) { s.strain_tolerance = x; }), "strain_tolerance");
  EXPECT_EQ(key_after<S>([](S& s, double) { s.threads = 0; }), "threads");
  EXPECT_EQ(key_after<S>([](S& s, double) { s.method = ""; }), "method");
}

TEST(Validate, ASceneNamesTheWholePath) {
  Scene scene;
  scene.cloth.material.ks = nan;
  EXPECT_EQ(refused_key(scene), "cloth.ks");

  scene = Scene();
  scene.cloth.pinned = {{0, 0, ""}, {1, 0, ""}, {0, 0, "hand"}};
  EXPECT_EQ(refused_key(scene), "cloth.pinned.2");

  scene = Scene();
  scene.cloth.columns = std::numeric_limits<int>::max();
  scene.cloth.rows = std::numeric_limits<int>::max();
  EXPECT_EQ(refused_key(scene), "cloth.columns");

  scene = Scene();
  scene.cloth.columns = scene.cloth.rows = 1;
  EXPECT_EQ(refused_key(scene), "cloth.columns");

  ColliderSpec ball;
  ball.name = "ball";
  scene = Scene();
  scene.colliders = {ball, ball};
  EXPECT_EQ(refused_key(scene), "colliders.1.name");

  scene.colliders = {ball};
  scene.colliders[0].name = "";
  EXPECT_EQ(refused_key(scene), "colliders.0.name");

  scene.colliders = {ball};
  scene.colliders[0].shape = Sphere{nan};
  EXPECT_EQ(refused_key(scene), "colliders.0.radius");

  scene.colliders = {ball};
  scene.colliders[0].pose.position.z() = infinity;
  EXPECT_EQ(refused_key(scene), "colliders.0.center.2");

  for (const double w : {0.0, 2.0, nan}) {
    scene.colliders = {ball};
    scene.colliders[0].pose.orientation.w() = w;
    EXPECT_EQ(refused_key(scene), "colliders.0.orientation") << w;
  }

  scene = Scene();
  scene.simulation.substeps = -1;
  EXPECT_EQ(refused_key(scene), "simulation.substeps");
}

TEST(Validate, ACollidersIdHas8Bits) {
  Scene scene;
  for (std::size_t i = 0; i < max_colliders; ++i) {
    scene.colliders.emplace_back();
    scene.colliders.back().name = std::to_string(i);
  }
  EXPECT_EQ(refused_key(scene), "");
  scene.colliders.push_back(scene.colliders.back());
  scene.colliders.back().name = "one more";
  try {
    validate(scene);
    FAIL() << "took 255 colliders";
  } catch (const InvalidValue& error) {
    EXPECT_TRUE(says(error.what(), "colliders: got 255 ... most 254"));
  }
}

}  // namespace
}  // namespace clothsim::scene_test
