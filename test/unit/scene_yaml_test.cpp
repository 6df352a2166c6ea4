#include "clothsim/scene/scene_yaml.h"

#include <gtest/gtest.h>

#include <random>

#include "says.h"
#include "scene_text.h"

namespace clothsim::scene_yaml_test {
namespace {

// ---- Reading

TEST(SceneYaml, ReadsEveryKey) {
  const Scene scene = read_changed({});
  EXPECT_EQ(print(scene),
            "1 2 5 4 0 0.0095 off 0.3 [0 0 1] pin 0 0  pin 4 3 hand 5000 150 5.4 0.1 110 collider "
            "ball 0.3 ball [0.5 0.5 0.2] [0 0 1] 0.2 collider ground 0.5  [0 0 0] [0 0 1] 0 [0 0 "
            "-9.8] 90 0 0.004 0.001 auto 1 2");

  const Scene other = read_changed(
      {"cloth.width=3", "cloth.height=4", "cloth.columns=7", "cloth.rows=8",
       "cloth.orientation=vertical", "cloth.origin=[1, 2, 3]", "cloth.pinned=[[6, 7]]",
       "cloth.springs={structural: false, bending: true}", "cloth.ks=1", "cloth.density=2",
       "cloth.damping=3", "cloth.strain_limit=off", "cloth.thickness=4",
       "cloth.self_collision=true", "cloth.friction=0.7",
       "colliders=[{shape: plane, name: wall, point: [1, 2, 3], normal: [5, 0, 0], friction: 6, "
       "two_sided: true, frame: arm, enabled: false}]",
       "simulation={gravity: [1, 2, 3], frames_per_second: 60, substeps: 7, strain_tolerance: 0.5, "
       "tolerance: 0.25, method: verlet, seed: 9223372036854775807, threads: 3}"});
  EXPECT_EQ(print(other),
            "3 4 7 8 1 4 automatic 0.7 [1 2 3] pin 6 7  1 2 3 -1 011 collider wall 6 arm [1 2 3] "
            "[1 0 0] 1 [1 2 3] 60 7 0.5 0.25 verlet 9223372036854775807 3");
  EXPECT_FALSE(other.colliders[0].enabled);
}

TEST(SceneYaml, ReadsHowAClothIsKeptOffItself) {
  const auto read = [](const std::string& value) {
    return read_changed({"cloth.self_collision=" + value}).cloth.self_collision;
  };
  EXPECT_EQ(read("false"), SelfCollision::off);
  EXPECT_EQ(read("true"), SelfCollision::automatic);
  EXPECT_EQ(read("points"), SelfCollision::points);
  EXPECT_EQ(read("surface"), SelfCollision::surface);
  EXPECT_EQ(read("automatic"), SelfCollision::automatic);  // as among live values
}

TEST(SceneYaml, ReadsTheParametersOfTheMethod) {
  // In either order of the keys; a missing key keeps its default.
  for (const char* text :
       {"{cloth: {}, simulation: {method: bdf2, method_parameters: {max_iterations: 3}}}",
        "{cloth: {}, simulation: {method_parameters: {max_iterations: 3}, method: bdf2}}"}) {
    const Scene scene = read_scene(YAML::Load(text));
    const auto& parameters = std::get<Bdf2::Parameters>(scene.simulation.method_parameters);
    EXPECT_EQ(parameters.max_iterations, 3);
    EXPECT_EQ(parameters.tolerance, Bdf2::Parameters().tolerance);
  }
  // An empty name is the same as none.
  for (const std::string& method : method_names()) {
    EXPECT_NO_THROW(
        read_changed({"simulation.method=" + method, "simulation.method_parameters={}"}));
  }
  EXPECT_NO_THROW(read_changed({"simulation.method_parameters={}"}));
}

TEST(SceneYaml, WhatIsLeftOutKeepsItsDefault) {
  EXPECT_EQ(print(read_scene(YAML::Load("cloth: {}"))), print(Scene()));
}

TEST(SceneYaml, ScenesWrittenInTwoWaysReadEqual) {
  const char* block = R"(
simulation:
  seed: 1
cloth:
  strain_limit: "off"
  pinned:
    - point: [0, 0]
    - - 49
      - 0
  orientation: "vertical"
  ks: 5.0e+3
  origin: &corner [0, 0, 1.0]
  self_collision: no
colliders:
  - shape: plane
    point: *corner
    normal: [0, 0, 7]
)";
  const char* flow =
      "{cloth: {ks: +5000, orientation: vertical, pinned: [[0, 0], [49, 0]], strain_limit: off}, "
      "colliders: [{name: plane, shape: 'plane', point: [0, 0, 1]}]}";
  EXPECT_EQ(print(read_scene(YAML::Load(block))), print(read_scene(YAML::Load(flow))));
}

TEST(SceneYaml, NodesMadeByAProgramReadLikeAFile) {
  YAML::Node root;
  root["cloth"]["ks"] = 0.1;
  root["cloth"]["columns"] = 5;
  root["cloth"]["strain_limit"] = false;
  root["cloth"]["orientation"] = "vertical";
  const Scene scene = read_scene(root);
  EXPECT_EQ(print(scene),
            print(read_scene(YAML::Load(
                "cloth: {ks: 0.1, columns: 5, strain_limit: off, orientation: vertical}"))));

  root["cloth"]["ks"].SetTag("!");  // a text parameter that looks like a number
  EXPECT_THROW(read_scene(root), InvalidValue);
}

TEST(SceneYaml, AcceptsWhatPhysicsAllows) {
  EXPECT_EQ(read_changed({"cloth.ks=0"}).cloth.material.ks, 0);
  EXPECT_EQ(read_changed({"cloth.damping=0"}).cloth.material.damping, 0);
  EXPECT_EQ(read_changed({"cloth.strain_limit=0"}).cloth.material.strain_limit, 0);
  EXPECT_EQ(read_changed({"cloth.columns=1", "cloth.pinned=[]"}).cloth.columns, 1);
  EXPECT_EQ(read_changed({"cloth.rows=1", "cloth.pinned=[]"}).cloth.rows, 1);
  EXPECT_EQ(read_changed({"cloth.columns=1000", "cloth.rows=1000"}).cloth.rows, 1000);
}

// The parameter server has 50.0 and 50 as two types, and hands on the first as 50.
TEST(SceneYaml, AWholeNumberMayBeWrittenAsAnyNumber) {
  EXPECT_EQ(read_changed({"cloth.columns=50.0"}).cloth.columns, 50);
  EXPECT_EQ(read_changed({"cloth.columns=5.0e+1"}).cloth.columns, 50);
  EXPECT_EQ(read_changed({"cloth.pinned.0=[1.0, -0.0]"}).cloth.pinned[0].column, 1);
  EXPECT_EQ(read_changed({"simulation.seed=7.0"}).simulation.seed, 7u);
  EXPECT_EQ(read_changed({"simulation.seed=9223372036854775807"}).simulation.seed,
            9223372036854775807u);
}

TEST(SceneYaml, PlaneTurnsItsZAxisToTheNormal) {
  for (const char* normal :
       {"[0, 0, 1]", "[0, 0, -1]", "[3, -4, 0]", "[1e-5, 2e-5, -3e-5]", "[1e300, 1e300, 0]"}) {
    const Scene scene = read_changed({std::string("colliders.1.normal=") + normal});
    const YAML::Node given = YAML::Load(normal);
    const Vector3 expected(given[0].as<double>(), given[1].as<double>(), given[2].as<double>());
    const Eigen::Quaterniond& turn = scene.colliders[1].pose.orientation;
    EXPECT_NEAR(turn.norm(), 1, 1e-12);
    EXPECT_LT((turn * Vector3::UnitZ() - expected.stableNormalized()).norm(), 1e-12) << normal;
  }
}

TEST(SceneYaml, CapsuleTurnsItsZAxisToTheAxis) {
  const Scene scene = read_changed(
      {"colliders.0={shape: capsule, center: [1, 2, 3], axis: [0, -2, 0], length: 0.5, radius: "
       "0.03}"});
  const ColliderSpec& rod = scene.colliders[0];
  EXPECT_EQ(rod.name, "capsule");
  EXPECT_EQ(std::get<Capsule>(rod.shape).length, 0.5);
  EXPECT_EQ(std::get<Capsule>(rod.shape).radius, 0.03);
  EXPECT_EQ(rod.pose.position, Vector3(1, 2, 3));
  EXPECT_LT((rod.pose.orientation * Vector3::UnitZ() + Vector3::UnitY()).norm(), 1e-12);
}

TEST(SceneYaml, CylinderTurnsItsZAxisToTheAxis) {
  const Scene scene = read_changed(
      {"colliders.0={shape: cylinder, center: [1, 2, 3], axis: [0, -2, 0], length: 0.5, radius: "
       "0.03}"});
  const ColliderSpec& drum = scene.colliders[0];
  EXPECT_EQ(drum.name, "cylinder");
  EXPECT_EQ(std::get<Cylinder>(drum.shape), (Cylinder{0.5, 0.03}));
  EXPECT_LT((drum.pose.orientation * Vector3::UnitZ() + Vector3::UnitY()).norm(), 1e-12);
}

TEST(SceneYaml, BoxIsTurnedByRollThenPitchThenYawAboutFixedAxes) {
  const auto turned = [](const std::string& rpy) {
    const Scene scene =
        read_changed({"colliders.0={shape: box, size: [1, 2, 3], rpy: " + rpy + "}"});
    EXPECT_EQ(std::get<Cuboid>(scene.colliders[0].shape).size, Vector3(1, 2, 3));
    return scene.colliders[0].pose.orientation;
  };
  const double quarter = M_PI / 2;
  const std::string q = std::to_string(quarter);
  EXPECT_LT((turned("[" + q + ", 0, 0]") * Vector3::UnitY() - Vector3::UnitZ()).norm(), 1e-5);
  EXPECT_LT((turned("[0, " + q + ", 0]") * Vector3::UnitZ() - Vector3::UnitX()).norm(), 1e-5);
  EXPECT_LT((turned("[0, 0, " + q + "]") * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-5);
  // Roll takes y to z, and pitch then z to x.
  EXPECT_LT((turned("[" + q + ", " + q + ", 0]") * Vector3::UnitY() - Vector3::UnitX()).norm(),
            1e-5);
}

// ---- override_values

TEST(OverrideValues, ReplacesAndAdds) {
  const Scene scene = read_changed({"cloth.ks=500", "colliders.0.radius=0.3",
                                    "cloth.pinned.1.point=[1, 1]", "cloth.pinned.1.point.0=2"});
  EXPECT_EQ(scene.cloth.material.ks, 500);
  EXPECT_EQ(std::get<Sphere>(scene.colliders[0].shape).radius, 0.3);
  EXPECT_EQ(scene.cloth.pinned[1].column, 2);
  EXPECT_EQ(scene.cloth.pinned[1].row, 1);

  YAML::Node root = YAML::Load("cloth: {}");
  override_values(root, {"simulation.seed=7", "cloth.springs.shear=false"});
  EXPECT_EQ(read_scene(root).simulation.seed, 7u);
  EXPECT_FALSE(read_scene(root).cloth.material.springs[1]);
}

TEST(OverrideValues, LeavesWhatSharesAnAnchorAlone) {
  YAML::Node root = YAML::Load("cloth: {width: &w 2, height: *w}");
  override_values(root, {"cloth.width=3"});
  const Scene scene = read_scene(root);
  EXPECT_EQ(scene.cloth.width, 3);
  EXPECT_EQ(scene.cloth.height, 2);
}

TEST(OverrideValues, TheLaterOneHolds) {
  const auto width_after = [](const std::vector<std::string>& assignments) {
    return read_changed(assignments).cloth.width;
  };
  EXPECT_EQ(width_after({"cloth.width=3", "cloth.width=4"}), 4);
  EXPECT_EQ(width_after({"cloth={}", "cloth.width=3"}), 3);
  EXPECT_EQ(width_after({"cloth.width=3", "cloth={}"}), ClothSpec().width);
  EXPECT_EQ(width_after({"cloth.width=3", "cloth={width: 4, ks: 1}", "cloth.ks=2"}), 4);
}

TEST(OverrideValues, RefusesMalformedText) {
  for (const char* text : {"", "cloth.ks", "=5", ".ks=5", "cloth.=5", "cloth..ks=5"}) {
    YAML::Node root = YAML::Load(good_scene);
    EXPECT_THROW(override_values(root, {text}), InvalidValue) << text;
  }
  YAML::Node root = YAML::Load(good_scene);
  try {
    override_values(root, {"cloth.origin=[1, 2"});
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), (std::vector<std::string>{"cloth", "origin"}));
  }
  std::string deep = "a";
  for (int i = 0; i < 100'000; ++i) deep += ".a";
  EXPECT_THROW(override_values(root, {deep + "=1"}), InvalidValue);
  EXPECT_THROW(override_values(root, {"cloth.ks=5\n---\n6"}), InvalidValue);
  EXPECT_THROW(override_values(root, {"cloth.ks=" + std::string(1000, '[')}), InvalidValue);
  EXPECT_EQ(read_scene(root).cloth.material.ks, 5000);
  for (const char* text : {"colliders.2.radius=1", "colliders.ball.radius=1", "colliders.-1=1"}) {
    EXPECT_THROW(override_values(root, {text}), InvalidValue) << text;
  }
}

// ---- Random scenes: read or refused, nothing else

/// Makes invalid scenes from valid ones.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  /// A copy of `node` in which each part may be dropped, doubled, renamed or replaced.
  YAML::Node mutate(const YAML::Node& node) {
    if (chance(0.03)) return any_value();
    if (node.IsMap()) return mutate_map(node);
    if (node.IsSequence()) return mutate_list(node);
    return YAML::Clone(node);
  }

 private:
  bool chance(double probability) { return std::bernoulli_distribution(probability)(random_); }

  size_t below(size_t count) {
    return std::uniform_int_distribution<size_t>(0, count - 1)(random_);
  }

  YAML::Node mutate_map(const YAML::Node& node) {
    YAML::Node copy(YAML::NodeType::Map);
    for (const auto& entry : node) {
      if (chance(0.05)) continue;
      const YAML::Node key = chance(0.005) ? any_value() : YAML::Clone(entry.first);
      const YAML::Node value = mutate(entry.second);
      copy.force_insert(key, value);
      if (chance(0.005)) copy.force_insert(key, value);
    }
    return copy;
  }

  YAML::Node mutate_list(const YAML::Node& node) {
    YAML::Node copy(YAML::NodeType::Sequence);
    for (const YAML::Node& item : node) {
      if (chance(0.03)) continue;
      copy.push_back(mutate(item));
      if (chance(0.02)) copy.push_back(mutate(item));
    }
    return copy;
  }

  YAML::Node any_value() {
    static const char* const values[] = {"0",
                                         "1",
                                         "-1",
                                         "2",
                                         "0.5",
                                         "-0.1",
                                         "1e9",
                                         "1e308",
                                         "-1e308",
                                         "1e-320",
                                         "1e999",
                                         "99999999999999999999",
                                         "2147483648",
                                         ".nan",
                                         ".inf",
                                         "true",
                                         "off",
                                         "auto",
                                         "''",
                                         "'5'",
                                         "~",
                                         "[]",
                                         "{}",
                                         "[0, 0]",
                                         "[0, 0, 0]",
                                         "[1, 2, 3, 4]",
                                         "{a: 1}",
                                         "[[0, 0], [1, 1]]",
                                         "sphere",
                                         "plane",
                                         "vertical",
                                         "verlet",
                                         "{shape: plane}",
                                         "!!int 3",
                                         "!x y",
                                         "\"\\0\"",
                                         "[[[[]]]]",
                                         "\xc3\xa9",
                                         "0x1F",
                                         "1:30"};
    return YAML::Load(values[below(std::size(values))]);
  }

  std::mt19937 random_;
};

TEST(SceneYaml, RandomScenesAreReadOrRefused) {
  constexpr int runs = 5'000;
  const YAML::Node good = YAML::Load(good_scene);
  int read = 0;
  for (unsigned seed = 0; seed < runs; ++seed) {
    try {
      Mutator mutator(seed);
      const Scene scene = read_scene(mutator.mutate(good));
      validate(scene);
      ++read;
    } catch (const InvalidValue& error) {
      ASSERT_NE(std::string(error.what()).find(", expected "), std::string::npos);
    } catch (const std::exception& error) {
      FAIL() << "seed " << seed << ": " << error.what();
    }
  }
  // Both outcomes occur.
  EXPECT_GT(read, runs / 100);
  EXPECT_LT(read, runs * 99 / 100);
}

// ---- Values that may change while a cloth moves

void change(Scene& scene, const std::string& values) {
  LiveSpec live = live_values(scene);
  read_live_values(YAML::Load(values), live);
  scene.cloth.material = live.material;
  scene.cloth.thickness = live.thickness;
  scene.cloth.self_collision = live.self_collision;
  scene.cloth.friction = live.friction;
  scene.simulation = live.simulation;
}

TEST(LiveValues, AreReadAsInAScene) {
  const char* values =
      "{ks: 7, density: 2, damping: 3, strain_limit: off, springs: {bending: false}, "
      "gravity: [1, 2, 3], frames_per_second: 60, substeps: 7, strain_tolerance: 0.5, "
      "tolerance: 0.25, method: bdf2, method_parameters: {max_iterations: 3}, threads: 2, "
      "thickness: 0.03, friction: 0.4, self_collision: points}";
  Scene scene = read_changed({"simulation.seed=5"});
  change(scene, values);
  EXPECT_EQ(print(scene),
            print(read_changed(
                {"cloth.ks=7", "cloth.density=2", "cloth.damping=3", "cloth.strain_limit=off",
                 "cloth.springs.bending=false", "cloth.thickness=0.03", "cloth.friction=0.4",
                 "cloth.self_collision=points",
                 "simulation={gravity: [1, 2, 3], frames_per_second: 60, substeps: 7, "
                 "strain_tolerance: 0.5, tolerance: 0.25, method: bdf2, method_parameters: "
                 "{max_iterations: 3}, seed: 5, threads: 2}"})));
}

TEST(LiveValues, LeftOutKeepTheirValue) {
  const std::vector<std::string> changes = {
      "cloth.ks=7", "cloth.springs.shear=false",
      "simulation={method: xpbd, method_parameters: {iterations: 9}, substeps: 4}"};
  Scene scene = read_changed(changes);
  change(scene, "{}");
  EXPECT_EQ(print(scene), print(read_changed(changes)));
  change(scene, "{method: xpbd}");
  EXPECT_EQ(std::get<Xpbd::Parameters>(scene.simulation.method_parameters).iterations, 9);

  // The choice does not have the parameters of another method.
  change(scene, "{method: bdf2}");
  EXPECT_TRUE(std::holds_alternative<std::monostate>(scene.simulation.method_parameters));
}

TEST(LiveValues, RefuseWhatASceneWouldAndWhatCannotChange) {
  const auto message = [](const char* values) -> std::string {
    Scene scene = read_changed({});
    try {
      change(scene, values);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_TRUE(says(message("{ks: soft}"), "ks: got soft ... finite"));
  EXPECT_TRUE(says(message("{springs: {bend: true}}"),
                   "springs.bend: got ... unknown ... structural, shear, bending"));
  for (const char* key : {"columns", "width", "seed", "cloth"}) {
    EXPECT_TRUE(says(message(("{" + std::string(key) + ": 1}").c_str()),
                     key + std::string(": got ... unknown")));
  }
}

}  // namespace
}  // namespace clothsim::scene_yaml_test
