#include "clothsim/simulation/scene_yaml.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

constexpr const char* good_scene = R"(
cloth:
  width: 1.0
  height: 2.0
  columns: 5
  rows: 4
  orientation: horizontal
  origin: [0, 0, 1]
  pinned: [[0, 0], {point: [4, 3], frame: hand}]
  springs: {structural: true, shear: true, bending: false}
  ks: 5000
  density: 150
  damping: 5.4
  strain_limit: 0.1
  thickness: 0.0095
  self_collision: false
colliders:
  - {name: ball, shape: sphere, center: [0.5, 0.5, 0.2], radius: 0.2, friction: 0.3, frame: ball}
  - {name: ground, shape: plane, point: [0, 0, 0], normal: [0, 0, 1], friction: 0.5, two_sided: false}
simulation:
  gravity: [0, 0, -9.8]
  frames_per_second: 90
  substeps: auto
  method: auto
  seed: 1
)";

std::string joined(const std::vector<std::string>& key) {
  std::string path;
  for (const std::string& part : key) path += (path.empty() ? "" : ".") + part;
  return path;
}

/// Reads `text`; the message of the refusal, or "accepted".
std::string refusal(const std::string& text) {
  try {
    read_scene(YAML::Load(text));
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

Scene read_changed(const std::vector<std::string>& assignments) {
  YAML::Node root = YAML::Load(good_scene);
  for (const std::string& assignment : assignments) override_value(root, assignment);
  return read_scene(root);
}

/// All of a scene in one text, to compare scenes by.
std::string print(const Scene& scene) {
  std::ostringstream out;
  out.precision(12);
  const auto print_vector = [&](const Vector3& v) {
    out << '[' << v.x() << ' ' << v.y() << ' ' << v.z() << "] ";
  };
  const ClothSpec& cloth = scene.cloth;
  out << cloth.width << ' ' << cloth.height << ' ' << cloth.columns << ' ' << cloth.rows << ' '
      << static_cast<int>(cloth.orientation) << ' ' << cloth.thickness << ' '
      << cloth.self_collision << ' ' << cloth.friction << ' ';
  print_vector(cloth.origin);
  for (const Pin& pin : cloth.pinned) {
    out << "pin " << pin.column << ' ' << pin.row << ' ' << pin.frame << ' ';
  }
  const Material& material = cloth.material;
  out << material.ks << ' ' << material.density << ' ' << material.damping << ' '
      << material.strain_limit.value_or(-1) << ' ';
  for (const bool on : material.springs) out << on;
  for (const ColliderSpec& collider : scene.colliders) {
    out << " collider " << collider.name << ' ' << collider.friction << ' ' << collider.frame
        << ' ';
    print_vector(collider.pose.position);
    const Vector3 normal = collider.pose.orientation * Vector3::UnitZ();
    print_vector((normal * 1e12).array().round() * 1e-12 + 0.0);  // without rounding errors
    if (const auto* sphere = std::get_if<Sphere>(&collider.shape)) out << sphere->radius;
    if (const auto* plane = std::get_if<Plane>(&collider.shape)) out << plane->two_sided;
  }
  out << ' ';
  print_vector(scene.simulation.gravity);
  out << scene.simulation.frames_per_second << ' ' << scene.simulation.substeps.value_or(0) << ' '
      << scene.simulation.strain_tolerance << ' ' << scene.simulation.method << ' '
      << scene.simulation.seed;
  return out.str();
}

// ---- One test per class of mistake
// ---------------------------------------------------------------

struct Mistake {
  const char* assignment;  // made to the good scene
  const char* message;     // in full
};

std::ostream& operator<<(std::ostream& out, const Mistake& m) { return out << m.assignment; }

class SceneMistake : public testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, IsRefusedWithKeyGotAndExpected) {
  try {
    read_changed({GetParam().assignment});
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_STREQ(error.what(), GetParam().message);
  }
}

constexpr const char* cloth_keys =
    "width, height, columns, rows, orientation, origin, pinned, springs, ks, density, damping, "
    "strain_limit, thickness, self_collision, friction";

INSTANTIATE_TEST_SUITE_P(
    UnknownKey, SceneMistake,
    testing::Values(
        Mistake{"clothes=1",
                "clothes: got an unknown key, expected one of cloth, colliders, simulation"},
        Mistake{"cloth.springs.bend=true",
                "cloth.springs.bend: got an unknown key, expected one of structural, shear, "
                "bending"},
        Mistake{"cloth.pinned.1.link=hand",
                "cloth.pinned.1.link: got an unknown key, expected one of point, frame"},
        Mistake{"colliders.1.radius=0.3",
                "colliders.1.radius: got an unknown key, expected one of name, shape, friction, "
                "frame, point, normal, two_sided"},
        Mistake{"colliders.0.normal=[0, 0, 1]",
                "colliders.0.normal: got an unknown key, expected one of name, shape, friction, "
                "frame, center, radius"},
        Mistake{"simulation.fps=30",
                "simulation.fps: got an unknown key, expected one of gravity, frames_per_second, "
                "substeps, strain_tolerance, method, seed"}));

INSTANTIATE_TEST_SUITE_P(
    WrongType, SceneMistake,
    testing::Values(
        Mistake{"cloth=5", "cloth: got 5, expected a map"},
        Mistake{"cloth=", "cloth: got nothing, expected a map"},
        Mistake{"cloth=[1, 2]", "cloth: got [1, 2], expected a map"},
        Mistake{"cloth.ks=stiff", "cloth.ks: got stiff, expected a finite number"},
        Mistake{"cloth.ks='5000'", "cloth.ks: got \"5000\" (text), expected a finite number"},
        Mistake{"cloth.ks=!!str 5", "cloth.ks: got \"5\" (text), expected a finite number"},
        Mistake{"cloth.ks=true", "cloth.ks: got true, expected a finite number"},
        Mistake{"cloth.ks=~", "cloth.ks: got nothing, expected a finite number"},
        Mistake{"cloth.ks=[1]", "cloth.ks: got [1], expected a finite number"},
        Mistake{"cloth.ks=[1, [2]]", "cloth.ks: got a list of 2, expected a finite number"},
        Mistake{"cloth.ks={a: 1}", "cloth.ks: got a map, expected a finite number"},
        Mistake{"cloth.ks=5 N/m", "cloth.ks: got 5 N/m, expected a finite number"},
        Mistake{"cloth.ks=0x10", "cloth.ks: got 0x10, expected a finite number"},
        Mistake{"cloth.ks=010", "cloth.ks: got 010, expected a finite number"},
        Mistake{"cloth.ks=1_000", "cloth.ks: got 1_000, expected a finite number"},
        Mistake{"cloth.columns=50.0", "cloth.columns: got 50.0, expected a whole number"},
        Mistake{"cloth.columns=five", "cloth.columns: got five, expected a whole number"},
        Mistake{"cloth.self_collision=1", "cloth.self_collision: got 1, expected true or false"},
        Mistake{"cloth.self_collision='true'",
                "cloth.self_collision: got \"true\" (text), expected true or false"},
        Mistake{"cloth.springs=true", "cloth.springs: got true, expected a map"},
        Mistake{"cloth.springs.shear=2", "cloth.springs.shear: got 2, expected true or false"},
        Mistake{"cloth.strain_limit=true",
                "cloth.strain_limit: got true, expected a finite number or off"},
        Mistake{"cloth.pinned=5", "cloth.pinned: got 5, expected a list"},
        Mistake{"cloth.pinned.0=5", "cloth.pinned.0: got 5, expected [column, row]"},
        Mistake{"cloth.pinned.0=[1.5, 0]", "cloth.pinned.0.0: got 1.5, expected a whole number"},
        Mistake{"cloth.pinned.1.frame=5",
                "cloth.pinned.1.frame: got 5, expected a text that is not empty"},
        Mistake{"colliders={}", "colliders: got a map, expected a list"},
        Mistake{"colliders.0=ball", "colliders.0: got ball, expected a map"},
        Mistake{"colliders.0.name=12",
                "colliders.0.name: got 12, expected a text that is not empty"},
        Mistake{"colliders.0.name=on",
                "colliders.0.name: got on, expected a text that is not empty"},
        Mistake{"simulation=fast", "simulation: got fast, expected a map"},
        Mistake{"simulation.substeps=many",
                "simulation.substeps: got many, expected auto or a whole number"},
        Mistake{"simulation.seed=1.5", "simulation.seed: got 1.5, expected a whole number"}));

INSTANTIATE_TEST_SUITE_P(
    NonFinite, SceneMistake,
    testing::Values(Mistake{"cloth.ks=.nan", "cloth.ks: got .nan, expected a finite number"},
                    Mistake{"cloth.ks=.inf", "cloth.ks: got .inf, expected a finite number"},
                    Mistake{"cloth.ks=nan", "cloth.ks: got nan, expected a finite number"},
                    Mistake{"cloth.ks=-infinity",
                            "cloth.ks: got -infinity, expected a finite number"},
                    Mistake{"cloth.ks=1e999", "cloth.ks: got 1e999, expected a finite number"},
                    Mistake{"cloth.origin=[0, .nan, 0]",
                            "cloth.origin.1: got .nan, expected a finite number"}));

INSTANTIATE_TEST_SUITE_P(
    WrongLength, SceneMistake,
    testing::Values(Mistake{"cloth.origin=[0, 0]",
                            "cloth.origin: got [0, 0], expected a list of three numbers"},
                    Mistake{"simulation.gravity=9.8",
                            "simulation.gravity: got 9.8, expected a list of three numbers"},
                    Mistake{"cloth.pinned.0=[1, 2, 3]",
                            "cloth.pinned.0: got [1, 2, 3], expected [column, row]"},
                    Mistake{"cloth.pinned.1.point=[1]",
                            "cloth.pinned.1.point: got [1], expected [column, row]"}));

INSTANTIATE_TEST_SUITE_P(
    OutOfRange, SceneMistake,
    testing::Values(
        Mistake{"cloth.ks=-5", "cloth.ks: got -5, expected a number of at least 0 [N/m]"},
        Mistake{"cloth.ks=1e13", "cloth.ks: got 1e+13, expected a number of at most 1e+12 [N/m]"},
        Mistake{"cloth.density=0",
                "cloth.density: got 0, expected a number of at least 1e-06 [kg/m^2]"},
        Mistake{"cloth.damping=-0.1",
                "cloth.damping: got -0.1, expected a number of at least 0 [1/s]"},
        Mistake{"cloth.strain_limit=-0.1",
                "cloth.strain_limit: got -0.1, expected a number of at least 0"},
        Mistake{"cloth.friction=-1", "cloth.friction: got -1, expected a number of at least 0"},
        Mistake{"cloth.thickness=0",
                "cloth.thickness: got 0, expected a number of at least 1e-06 [m]"},
        Mistake{"cloth.width=0", "cloth.width: got 0, expected a number of at least 1e-06 [m]"},
        Mistake{"cloth.height=-1", "cloth.height: got -1, expected a number of at least 1e-06 [m]"},
        Mistake{"cloth.origin=[0, 0, 1e9]",
                "cloth.origin.2: got 1e+09, expected a number of at most 1e+06 [m]"},
        Mistake{"colliders.0.radius=-0.2",
                "colliders.0.radius: got -0.2, expected a number of at least 1e-06 [m]"},
        Mistake{"colliders.0.friction=-1",
                "colliders.0.friction: got -1, expected a number of at least 0"},
        Mistake{"colliders.0.center=[0, -1e9, 0]",
                "colliders.0.center.1: got -1e+09, expected a number of at least -1e+06 [m]"},
        Mistake{"colliders.1.point=[1e9, 0, 0]",
                "colliders.1.point.0: got 1e+09, expected a number of at most 1e+06 [m]"},
        Mistake{"colliders.1.normal=[0, 0, 0]",
                "colliders.1.normal: got [0, 0, 0], expected a direction, of a length of at least "
                "1e-06"},
        Mistake{"simulation.gravity=[0, 0, -1e9]",
                "simulation.gravity.2: got -1e+09, expected a number of at least -1e+06 [m/s^2]"},
        Mistake{"simulation.frames_per_second=0",
                "simulation.frames_per_second: got 0, expected a number of at least 0.001 [Hz]"},
        Mistake{"simulation.substeps=0",
                "simulation.substeps: got 0, expected auto or a whole number from 1 to 10000"},
        Mistake{"simulation.substeps=10001",
                "simulation.substeps: got 10001, expected auto or a whole number from 1 to 10000"},
        Mistake{"simulation.strain_tolerance=0",
                "simulation.strain_tolerance: got 0, expected a number of at least 1e-09"},
        Mistake{"simulation.seed=-1",
                "simulation.seed: got -1, expected a whole number of at least 0"},
        Mistake{"simulation.seed=18446744073709551616",
                "simulation.seed: got 18446744073709551616, expected a whole number of at most "
                "9223372036854775807"}));

INSTANTIATE_TEST_SUITE_P(
    AbsurdSize, SceneMistake,
    testing::Values(
        Mistake{"cloth.columns=0", "cloth.columns: got 0, expected a whole number of at least 1"},
        Mistake{"cloth.rows=-3", "cloth.rows: got -3, expected a whole number of at least 1"},
        Mistake{"cloth.columns=1000000",
                "cloth.columns: got 1000000 columns of 4 rows, expected 2 to 1000000 points in "
                "all"},
        Mistake{"cloth.columns=99999999999",
                "cloth.columns: got 99999999999, expected a whole number of at most 2147483647"},
        Mistake{"cloth.rows=-99999999999999999999",
                "cloth.rows: got -99999999999999999999, expected a whole number of at least "
                "-2147483648"}));

INSTANTIATE_TEST_SUITE_P(
    WrongPin, SceneMistake,
    testing::Values(
        Mistake{"cloth.pinned.0=[5, 0]",
                "cloth.pinned.0: got [5, 0], expected [column, row] with column 0 to 4 and row 0 "
                "to 3"},
        Mistake{"cloth.pinned.0=[0, -1]",
                "cloth.pinned.0: got [0, -1], expected [column, row] with column 0 to 4 and row 0 "
                "to 3"},
        Mistake{"cloth.pinned=[[1, 2], [0, 0], [1, 2]]",
                "cloth.pinned.2: got [1, 2] again, expected a point other than that of pinned.0"},
        Mistake{"cloth.pinned.1={frame: hand}",
                "cloth.pinned.1.point: got nothing, expected [column, row]"},
        Mistake{"cloth.pinned.1.frame=/hand",
                "cloth.pinned.1.frame: got \"/hand\", expected a tf frame without a leading "
                "slash"}));

INSTANTIATE_TEST_SUITE_P(
    WrongName, SceneMistake,
    testing::Values(
        Mistake{"cloth.orientation=diagonal",
                "cloth.orientation: got diagonal, expected one of horizontal, vertical"},
        Mistake{"colliders.0.shape=teapot",
                "colliders.0.shape: got teapot, expected one of sphere, plane"},
        Mistake{"colliders.0={name: ball}",
                "colliders.0.shape: got nothing, expected one of sphere, plane"},
        Mistake{"colliders.0.name=''",
                "colliders.0.name: got \"\" (text), expected a text that is not empty"},
        Mistake{"colliders.0.frame=''",
                "colliders.0.frame: got \"\" (text), expected a text that is not empty"},
        Mistake{"colliders.0.frame=/ball",
                "colliders.0.frame: got \"/ball\", expected a tf frame without a leading slash"},
        Mistake{"colliders.0.name=ground",
                "colliders.1.name: got \"ground\" again, expected a name other than that of "
                "colliders.0"}));

TEST(SceneYaml, UnknownClothKeyListsAllOfThem) {
  EXPECT_EQ(refusal("cloth: {kss: 1}"),
            std::string("cloth.kss: got an unknown key, expected one of ") + cloth_keys);
}

TEST(SceneYaml, UnknownMethodListsTheKnown) {
  const std::string message = refusal("{cloth: {}, simulation: {method: magic}}");
  EXPECT_EQ(message.rfind("simulation.method: got \"magic\", expected one of auto, verlet", 0), 0u)
      << message;
}

TEST(SceneYaml, RefusesKeysGivenTwice) {
  EXPECT_EQ(refusal("cloth: {ks: 1, ks: 1}"), "cloth.ks: got the key again, expected it once");
  EXPECT_EQ(refusal("cloth: {}\ncloth: {}"), "cloth: got the key again, expected it once");
}

TEST(SceneYaml, RefusesWhatIsNoScene) {
  EXPECT_EQ(refusal("[1, 2]"), "scene: got [1, 2], expected a map");
  EXPECT_EQ(refusal("~"), "scene: got nothing, expected a map");
  EXPECT_EQ(refusal("{}"), "cloth: got nothing, expected a map");
  EXPECT_EQ(refusal("{[1, 2]: 3}"), "scene: got [1, 2] as a key, expected a name");
}

TEST(SceneYaml, SurvivesANodeThatHoldsItself) {
  EXPECT_EQ(refusal("cloth: &c {pinned: &p [*p, *c]}"),
            "cloth.pinned.0.0: got a list of 2, expected a whole number");
}

TEST(SceneYaml, MessagesHoldNoControlCharacters) {
  EXPECT_EQ(refusal("cloth: {\"a\\e[2J\\nb\": 1}").substr(0, 15), "cloth.a?[2J?b: ");
}

TEST(SceneYaml, NamesTheParameterTheWayTheNodeWritesIt) {
  try {
    read_changed({"colliders.0.radius=-1"});
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), (std::vector<std::string>{"colliders", "0", "radius"}));
    EXPECT_EQ(error.message("/clothsim/scene/", "/"),
              "/clothsim/scene/colliders/0/radius: got -1, expected a number of at least 1e-06 "
              "[m]");
  }
}

// ---- What is read
// --------------------------------------------------------------------------------

TEST(SceneYaml, ReadsEveryKey) {
  const Scene scene = read_changed({});
  EXPECT_EQ(print(scene),
            "1 2 5 4 0 0.0095 0 0.3 [0 0 1] pin 0 0  pin 4 3 hand "
            "5000 150 5.4 0.1 110"
            " collider ball 0.3 ball [0.5 0.5 0.2] [0 0 1] "
            "0.2"
            " collider ground 0.5  [0 0 0] [0 0 1] 0 "
            "[0 0 -9.8] 90 0 0.004 auto 1");

  const Scene other = read_changed(
      {"cloth.width=3", "cloth.height=4", "cloth.columns=7", "cloth.rows=8",
       "cloth.orientation=vertical", "cloth.origin=[1, 2, 3]", "cloth.pinned=[[6, 7]]",
       "cloth.springs={structural: false, bending: true}", "cloth.ks=1", "cloth.density=2",
       "cloth.damping=3", "cloth.strain_limit=off", "cloth.thickness=4",
       "cloth.self_collision=true", "cloth.friction=0.7",
       "colliders=[{shape: plane, name: wall, point: [1, 2, 3], normal: [5, 0, 0], friction: 6, "
       "two_sided: true, frame: arm}]",
       "simulation={gravity: [1, 2, 3], frames_per_second: 60, substeps: 7, strain_tolerance: 0.5, "
       "method: verlet, seed: "
       "9223372036854775807}"});
  EXPECT_EQ(print(other),
            "3 4 7 8 1 4 1 0.7 [1 2 3] pin 6 7  1 2 3 -1 011 collider wall 6 arm [1 2 3] [1 0 0] 1 "
            "[1 2 3] 60 7 0.5 verlet 9223372036854775807");
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

// ---- override_value
// ------------------------------------------------------------------------------

TEST(OverrideValue, ReplacesAndAdds) {
  const Scene scene = read_changed({"cloth.ks=500", "colliders.0.radius=0.3",
                                    "cloth.pinned.1.point=[1, 1]", "cloth.pinned.1.point.0=2"});
  EXPECT_EQ(scene.cloth.material.ks, 500);
  EXPECT_EQ(std::get<Sphere>(scene.colliders[0].shape).radius, 0.3);
  EXPECT_EQ(scene.cloth.pinned[1].column, 2);
  EXPECT_EQ(scene.cloth.pinned[1].row, 1);

  YAML::Node root = YAML::Load("cloth: {}");
  override_value(root, "simulation.seed=7");
  override_value(root, "cloth.springs.shear=false");
  EXPECT_EQ(read_scene(root).simulation.seed, 7u);
  EXPECT_FALSE(read_scene(root).cloth.material.springs[1]);
}

TEST(OverrideValue, LeavesWhatSharesAnAnchorAlone) {
  YAML::Node root = YAML::Load("cloth: {width: &w 2, height: *w}");
  override_value(root, "cloth.width=3");
  const Scene scene = read_scene(root);
  EXPECT_EQ(scene.cloth.width, 3);
  EXPECT_EQ(scene.cloth.height, 2);
}

TEST(OverrideValue, RefusesMalformedText) {
  for (const char* text : {"", "cloth.ks", "=5", ".ks=5", "cloth.=5", "cloth..ks=5"}) {
    YAML::Node root = YAML::Load(good_scene);
    EXPECT_THROW(override_value(root, text), InvalidValue) << text;
  }
  YAML::Node root = YAML::Load(good_scene);
  try {
    override_value(root, "cloth.origin=[1, 2");
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(joined(error.key()), "cloth.origin");
  }
  for (const char* text : {"colliders.2.radius=1", "colliders.ball.radius=1", "colliders.-1=1"}) {
    EXPECT_THROW(override_value(root, text), InvalidValue) << text;
  }
}

// ---- Files
// ---------------------------------------------------------------------------------------

std::string write_temporary(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path) << text;
  return path;
}

TEST(SceneFile, RefusesWhatIsNoYamlFile) {
  EXPECT_THROW(load_scene_file("no/such/file.yaml"), InvalidValue);
  EXPECT_THROW(load_scene_file(testing::TempDir()), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("open.yaml", "cloth: [1, 2")), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("tail.yaml", "cloth: {}\n}")), InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("two.yaml", "cloth: {}\n---\ncloth: {}")),
               InvalidValue);
  EXPECT_THROW(load_scene_file(write_temporary("deep.yaml", std::string(100'000, '['))),
               InvalidValue);
  EXPECT_THROW(load_scene_file("/dev/zero"), InvalidValue);
}

TEST(SceneFile, AnEmptyFileIsNoScene) {
  const YAML::Node root = load_scene_file(write_temporary("empty.yaml", "# nothing\n"));
  EXPECT_THROW(read_scene(root), InvalidValue);
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
  expected.cloth.self_collision = true;
  expected.colliders = {ground()};
  EXPECT_EQ(print(load("self_collision")), print(expected));
}

// ---- Random scenes: read or refused, nothing else
// ------------------------------------------------

/// Makes wrong scenes out of right ones.
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
  // Both ways are taken.
  EXPECT_GT(read, runs / 100);
  EXPECT_LT(read, runs * 99 / 100);
}

}  // namespace
}  // namespace clothsim
