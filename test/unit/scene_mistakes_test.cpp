// Scenes that the reader refuses: each class of mistake, with key, value and reason.

#include <gtest/gtest.h>

#include "says.h"
#include "scene_text.h"

namespace clothsim::scene_mistakes_test {
namespace {

struct Mistake {
  const char* assignment;  // the change to the good scene
  const char* message;     // as says() takes it
};

std::ostream& operator<<(std::ostream& out, const Mistake& m) { return out << m.assignment; }

class SceneMistake : public testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, IsRefusedWithKeyGotAndExpected) {
  try {
    read_changed({GetParam().assignment});
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_TRUE(says(error.what(), GetParam().message));
  }
}

constexpr const char* cloth_keys =
    "mesh, pattern, width, height, columns, rows, orientation, origin, pinned, attached, "
    "pin_strength, "
    "springs, "
    "ks, "
    "untangle, fabric, self_collision, density, damping, drag, strain_limit, thickness, friction, "
    "stretch_stiffness, shear_stiffness, bending_stiffness, internal_damping, "
    "poisson";

INSTANTIATE_TEST_SUITE_P(
    UnknownKey, SceneMistake,
    testing::Values(
        Mistake{
            "clothes=1",
            "clothes: got ... unknown ... cloth, cloths, colliders, robots, simulation, motions"},
        Mistake{"cloth.springs.bend=true",
                "cloth.springs.bend: got ... unknown ... structural, shear, bending"},
        Mistake{"cloth.pinned.1.link=hand",
                "cloth.pinned.1.link: got ... unknown ... near, within, of, uv, corner, side, "
                "point, frame, "
                "strength"},
        Mistake{"colliders.1.radius=0.3",
                "colliders.1.radius: got ... unknown ... name, shape, friction, frame, enabled, "
                "part_of, "
                "pose, mass, point, normal, two_sided"},
        Mistake{"colliders.0.normal=[0, 0, 1]",
                "colliders.0.normal: got ... unknown ... name, shape, friction, frame, enabled, "
                "part_of, "
                "pose, mass, center, radius"},
        Mistake{"simulation.fps=30",
                "simulation.fps: got ... unknown ... gravity, wind, gusts, frames_per_second, "
                "substeps, strain_tolerance, tolerance, method, method_parameters, seed, threads"},
        Mistake{"simulation={method: bdf2, method_parameters: {iterations: 3}}",
                "simulation.method_parameters.iterations: got ... unknown ... tolerance, "
                "max_iterations"}));

INSTANTIATE_TEST_SUITE_P(
    Body, SceneMistake,
    testing::Values(Mistake{"colliders.0.mass=0", "colliders.0.mass: got 0 ... 1e-06 ... [kg]"},
                    Mistake{"colliders.0.mass=heavy",
                            "colliders.0.mass: got heavy ... finite number"},
                    Mistake{"colliders.1.mass=1", "colliders.1.mass: got ... plane ... solid"},
                    Mistake{"colliders.0.damping=1",
                            "colliders.0.damping: got ... unknown ... pose, mass, center"},
                    Mistake{"colliders.0={shape: sphere, mass: 1, frame: hand}",
                            "colliders.0.frame: got hand ... none ... mass"},
                    Mistake{"colliders.0={shape: sphere, mass: 1, inertia: [1, 1]}",
                            "colliders.0.inertia: got [1, 1] ... [xx, yy, zz] or"},
                    Mistake{"colliders.0={shape: sphere, mass: 1, inertia: [1, 1, 3]}",
                            "colliders.0.inertia: got ... principal moments 1, 1 and 3 ... solid"},
                    Mistake{"colliders.0={shape: sphere, mass: 1, inertia: [1, 2, 0, 1, 0, 1]}",
                            "colliders.0.inertia: got ... principal moments ... solid"},
                    Mistake{"colliders.0={shape: sphere, mass: 1, velocity: [0, 0, 1e4]}",
                            "colliders.0.velocity.2: got 10000 ... [m/s]"}));

INSTANTIATE_TEST_SUITE_P(
    FabricAndWind, SceneMistake,
    testing::Values(
        Mistake{"cloth.stretch_stiffness=500",
                "cloth.ks: got 5000 ... fabric ... stretch_stiffness"},
        Mistake{"cloth={stretch_stiffness: [500, -1]}",
                "cloth.stretch_stiffness.1: got -1 ... least 0 [N/m]"},
        Mistake{"cloth={stretch_stiffness: [500, 1, 1]}",
                "cloth.stretch_stiffness: got [500, 1, 1] ... number ... two"},
        Mistake{"cloth={stretch_stiffness: -1}",
                "cloth.stretch_stiffness: got -1 ... least 0 [N/m]"},
        Mistake{"cloth={shear_stiffness: [1, 2]}", "cloth.shear_stiffness: got [1, 2] ... finite"},
        Mistake{"cloth={shear_stiffness: -1}", "cloth.shear_stiffness: got -1 ... least 0 [N/m]"},
        Mistake{"cloth={bending_stiffness: [0, -1e-6]}",
                "cloth.bending_stiffness.1: got -1e-06 ... least 0 [N m]"},
        Mistake{"cloth={internal_damping: -1}", "cloth.internal_damping: got -1 ... least 0 [s]"},
        Mistake{"cloth={bending_stiffness: 1e10}",
                "cloth.bending_stiffness: got 1e+10 ... most 1e+09 [N m]"},
        Mistake{"cloth={internal_damping: [0, .inf]}",
                "cloth.internal_damping.1: got .inf ... finite"},
        Mistake{"cloth={poisson: 1}", "cloth.poisson: got 1 ... most 0.9"},
        Mistake{"cloth={poisson: [0.2, 0.1]}", "cloth.poisson: got [0.2, 0.1] ... finite"},
        Mistake{"cloth.drag=-1", "cloth.drag: got -1 ... least 0"},
        Mistake{"simulation.wind=5", "simulation.wind: got 5 ... three"},
        Mistake{"simulation.wind=[0, 0, 400]", "simulation.wind.2: got 400 ... most 300 [m/s]"},
        Mistake{"simulation.gusts=-1", "simulation.gusts: got -1 ... least 0 [m/s]"}));

INSTANTIATE_TEST_SUITE_P(
    CapsuleAndBox, SceneMistake,
    testing::Values(
        Mistake{
            "colliders.0={shape: capsule, size: 1}",
            "colliders.0.size: got ... unknown ... name, shape, friction, frame, enabled, part_of, "
            "pose, mass, center, axis, length, radius"},
        Mistake{"colliders.0={shape: box, radius: 1}",
                "colliders.0.radius: got ... unknown ... name, shape, friction, frame, enabled, "
                "part_of, "
                "pose, mass, center, size, rpy"},
        Mistake{"colliders.0={shape: capsule, radius: 0}",
                "colliders.0.radius: got 0 ... least 1e-06 [m]"},
        Mistake{"colliders.0={shape: capsule, length: -1}",
                "colliders.0.length: got -1 ... least 1e-06 [m]"},
        Mistake{"colliders.0={shape: capsule, length: 1e7}",
                "colliders.0.length: got 1e+07 ... most 1e+06 [m]"},
        Mistake{"colliders.0={shape: capsule, axis: [0, 0, 0]}",
                "colliders.0.axis: got [0, 0, 0] ... direction ... 1e-06"},
        Mistake{"colliders.0={shape: capsule, axis: up}", "colliders.0.axis: got up ... three"},
        Mistake{"colliders.0={shape: box, size: [1, 0, 1]}",
                "colliders.0.size.1: got 0 ... least 1e-06 [m]"},
        Mistake{"colliders.0={shape: box, size: [1, 1, -2]}",
                "colliders.0.size.2: got -2 ... least 1e-06 [m]"},
        Mistake{"colliders.0={shape: box, size: [.nan, 1, 1]}",
                "colliders.0.size.0: got .nan ... finite"},
        Mistake{"colliders.0={shape: box, size: [1e9, 1, 1]}",
                "colliders.0.size.0: got 1e+09 ... most 1e+06 [m]"},
        Mistake{"colliders.0={shape: box, size: 1}", "colliders.0.size: got 1 ... three"},
        Mistake{"colliders.0={shape: box, rpy: [0, .inf, 0]}",
                "colliders.0.rpy.1: got .inf ... finite"},
        Mistake{"colliders.0={shape: box, rpy: [0, 1]}", "colliders.0.rpy: got [0, 1] ... three"},
        Mistake{"colliders.0={shape: cone}",
                "colliders.0.shape: got cone ... sphere, plane, capsule, box, cylinder, mesh"}));

INSTANTIATE_TEST_SUITE_P(
    MethodParameters, SceneMistake,
    testing::Values(
        Mistake{"simulation={method: xpbd, method_parameters: 5}",
                "simulation.method_parameters: got 5 ... map"},
        Mistake{"simulation={method: xpbd, method_parameters: {iterations: 0}}",
                "simulation.method_parameters.iterations: got 0 ... whole ... 1 to 100000"},
        Mistake{"simulation={method: xpbd, method_parameters: {iterations: 1.5}}",
                "simulation.method_parameters.iterations: got 1.5 ... whole"},
        Mistake{"simulation={method: bdf2, method_parameters: {tolerance: tight}}",
                "simulation.method_parameters.tolerance: got tight ... finite"},
        Mistake{"simulation={method: bdf2, method_parameters: {tolerance: 2}}",
                "simulation.method_parameters.tolerance: got 2 ... most 1"},
        Mistake{"simulation={method: rk4, method_parameters: {iterations: 3}}",
                "simulation.method_parameters: got parameters ... rk4"},
        Mistake{"simulation={method: verlet, method_parameters: {iterations: 3}}",
                "simulation.method_parameters.iterations: got ... unknown ... precision"},
        Mistake{"simulation={method: verlet, method_parameters: {precision: half}}",
                "simulation.method_parameters.precision: got half ... double, single"},
        Mistake{"simulation={method: verlet, method_parameters: {precision: 32}}",
                "simulation.method_parameters.precision: got 32 ... double, single"},
        Mistake{"simulation={method: auto, method_parameters: {iterations: 3}}",
                "simulation.method_parameters: got parameters ... auto"},
        Mistake{"simulation={method: magic, method_parameters: {iterations: 3}}",
                "simulation.method: got \"magic\" ... auto, verlet, symplectic_euler, rk4, "
                "implicit_euler, bdf2, xpbd"}));

INSTANTIATE_TEST_SUITE_P(
    WrongType, SceneMistake,
    testing::Values(
        Mistake{"cloth=5", "cloth: got 5 ... map"}, Mistake{"cloth=", "cloth: got nothing ... map"},
        Mistake{"cloth=[1, 2]", "cloth: got [1, 2] ... map"},
        Mistake{"cloth.ks=stiff", "cloth.ks: got stiff ... finite"},
        Mistake{"cloth.ks='5000'", "cloth.ks: got \"5000\" ... text ... finite"},
        Mistake{"cloth.ks=!!str 5", "cloth.ks: got \"5\" ... text ... finite"},
        Mistake{"cloth.ks=true", "cloth.ks: got true ... finite"},
        Mistake{"cloth.ks=~", "cloth.ks: got nothing ... finite"},
        Mistake{"cloth.ks=[1]", "cloth.ks: got [1] ... finite"},
        Mistake{"cloth.ks=[1, [2]]", "cloth.ks: got ... list of 2 ... finite"},
        Mistake{"cloth.ks={a: 1}", "cloth.ks: got ... map ... finite"},
        Mistake{"cloth.ks=5 N/m", "cloth.ks: got 5 N/m ... finite"},
        Mistake{"cloth.ks=0x10", "cloth.ks: got 0x10 ... finite"},
        Mistake{"cloth.ks=010", "cloth.ks: got 010 ... finite"},
        Mistake{"cloth.ks=1_000", "cloth.ks: got 1_000 ... finite"},
        Mistake{"cloth.columns=50.5", "cloth.columns: got 50.5 ... whole"},
        Mistake{"cloth.columns=1e-320", "cloth.columns: got 1e-320 ... whole"},
        Mistake{"cloth.columns=1e300", "cloth.columns: got 1e300 ... whole"},
        Mistake{"cloth.columns=five", "cloth.columns: got five ... whole"},
        Mistake{"cloth.self_collision=1",
                "cloth.self_collision: got 1 ... true, false, points ... surface"},
        Mistake{"cloth.self_collision='true'",
                "cloth.self_collision: got \"true\" ... text ... true, false, points ... surface"},
        Mistake{"cloth.springs=true", "cloth.springs: got true ... map"},
        Mistake{"cloth.springs.shear=2", "cloth.springs.shear: got 2 ... true ... false"},
        Mistake{"cloth.strain_limit=true", "cloth.strain_limit: got true ... number ... off"},
        Mistake{"cloth.pinned=5", "cloth.pinned: got 5 ... list"},
        Mistake{"cloth.pinned.0=5", "cloth.pinned.0: got 5 ... [column, row]"},
        Mistake{"cloth.pinned.0=[1.5, 0]", "cloth.pinned.0.0: got 1.5 ... whole"},
        Mistake{"cloth.pinned.1.frame=5", "cloth.pinned.1.frame: got 5 ... empty"},
        Mistake{"colliders={}", "colliders: got ... map ... list"},
        Mistake{"colliders.0=ball", "colliders.0: got ball ... map"},
        Mistake{"colliders.0.name=12", "colliders.0.name: got 12 ... empty"},
        Mistake{"colliders.0.name=on", "colliders.0.name: got on ... empty"},
        Mistake{"simulation=fast", "simulation: got fast ... map"},
        Mistake{"simulation.substeps=many", "simulation.substeps: got many ... auto ... whole"},
        Mistake{"simulation.seed=1.5", "simulation.seed: got 1.5 ... whole"}));

INSTANTIATE_TEST_SUITE_P(
    NonFinite, SceneMistake,
    testing::Values(Mistake{"cloth.ks=.nan", "cloth.ks: got .nan ... finite"},
                    Mistake{"cloth.ks=.inf", "cloth.ks: got .inf ... finite"},
                    Mistake{"cloth.ks=nan", "cloth.ks: got nan ... finite"},
                    Mistake{"cloth.ks=-infinity", "cloth.ks: got -infinity ... finite"},
                    Mistake{"cloth.ks=1e999", "cloth.ks: got 1e999 ... finite"},
                    Mistake{"cloth.origin=[0, .nan, 0]", "cloth.origin.1: got .nan ... finite"}));

INSTANTIATE_TEST_SUITE_P(
    WrongLength, SceneMistake,
    testing::Values(
        Mistake{"cloth.origin=[0, 0]", "cloth.origin: got [0, 0] ... three"},
        Mistake{"simulation.gravity=9.8", "simulation.gravity: got 9.8 ... three"},
        Mistake{"cloth.pinned.0=[1, 2, 3]", "cloth.pinned.0: got [1, 2, 3] ... [column, row]"},
        Mistake{"cloth.pinned.1.point=[1]", "cloth.pinned.1.point: got [1] ... [column, row]"}));

INSTANTIATE_TEST_SUITE_P(
    OutOfRange, SceneMistake,
    testing::Values(
        Mistake{"cloth.ks=-5", "cloth.ks: got -5 ... least 0 [N/m]"},
        Mistake{"cloth.ks=1e13", "cloth.ks: got 1e+13 ... most 1e+12 [N/m]"},
        Mistake{"cloth.density=0", "cloth.density: got 0 ... least 1e-06 [kg/m^2]"},
        Mistake{"cloth.damping=-0.1", "cloth.damping: got -0.1 ... least 0 [1/s]"},
        Mistake{"cloth.strain_limit=-0.1", "cloth.strain_limit: got -0.1 ... least 0"},
        Mistake{"cloth.friction=-1", "cloth.friction: got -1 ... least 0"},
        Mistake{"cloth.thickness=0", "cloth.thickness: got 0 ... least 1e-06 [m]"},
        Mistake{"cloth.width=0", "cloth.width: got 0 ... least 1e-06 [m]"},
        Mistake{"cloth.height=-1", "cloth.height: got -1 ... least 1e-06 [m]"},
        Mistake{"cloth.origin=[0, 0, 1e9]", "cloth.origin.2: got 1e+09 ... most 1e+06 [m]"},
        Mistake{"colliders.0.radius=-0.2", "colliders.0.radius: got -0.2 ... least 1e-06 [m]"},
        Mistake{"colliders.0.friction=-1", "colliders.0.friction: got -1 ... least 0"},
        Mistake{"colliders.0.center=[0, -1e9, 0]",
                "colliders.0.center.1: got -1e+09 ... least -1e+06 [m]"},
        Mistake{"colliders.1.point=[1e9, 0, 0]",
                "colliders.1.point.0: got 1e+09 ... most 1e+06 [m]"},
        Mistake{"colliders.1.normal=[0, 0, 0]",
                "colliders.1.normal: got [0, 0, 0] ... direction ... 1e-06"},
        Mistake{"simulation.gravity=[0, 0, -1e9]",
                "simulation.gravity.2: got -1e+09 ... least -1e+06 [m/s^2]"},
        Mistake{"simulation.frames_per_second=0",
                "simulation.frames_per_second: got 0 ... least 0.001 [Hz]"},
        Mistake{"simulation.substeps=0", "simulation.substeps: got 0 ... auto ... 1 to 10000"},
        Mistake{"simulation.substeps=10001",
                "simulation.substeps: got 10001 ... auto ... 1 to 10000"},
        Mistake{"simulation.strain_tolerance=0",
                "simulation.strain_tolerance: got 0 ... least 1e-09"},
        Mistake{"simulation.threads=0", "simulation.threads: got 0 ... whole ... 1 to 64"},
        Mistake{"simulation.threads=65", "simulation.threads: got 65 ... whole ... 1 to 64"},
        Mistake{"simulation.threads=1.5", "simulation.threads: got 1.5 ... whole"},
        Mistake{"simulation.seed=-1", "simulation.seed: got -1 ... whole ... least 0"},
        Mistake{
            "simulation.seed=18446744073709551616",
            "simulation.seed: got 18446744073709551616 ... whole ... most 9223372036854775807"}));

INSTANTIATE_TEST_SUITE_P(
    AbsurdSize, SceneMistake,
    testing::Values(
        Mistake{"cloth.columns=0", "cloth.columns: got 0 ... whole ... least 1"},
        Mistake{"cloth.rows=-3", "cloth.rows: got -3 ... whole ... least 1"},
        Mistake{"cloth.columns=1000000",
                "cloth.columns: got 1000000 columns ... 4 rows ... 2 to 1000000 points"},
        Mistake{"cloth.columns=1e11", "cloth.columns: got 1e11 ... whole ... most 2147483647"},
        Mistake{"cloth.columns=99999999999",
                "cloth.columns: got 99999999999 ... whole ... most 2147483647"},
        Mistake{"cloth.rows=-99999999999999999999",
                "cloth.rows: got -99999999999999999999 ... whole ... least -2147483648"}));

INSTANTIATE_TEST_SUITE_P(
    WrongPin, SceneMistake,
    testing::Values(
        Mistake{"cloth.pinned.0=[5, 0]",
                "cloth.pinned.0: got [5, 0] ... [column, row] ... 0 to 4 ... 0 to 3"},
        Mistake{"cloth.pinned.0=[0, -1]",
                "cloth.pinned.0: got [0, -1] ... [column, row] ... 0 to 4 ... 0 to 3"},
        Mistake{"cloth.pinned=[[1, 2], [0, 0], [1, 2]]",
                "cloth.pinned.2: got [1, 2] ... again ... item 0"},
        Mistake{"cloth.pinned.1={frame: hand}",
                "cloth.pinned.1.point: got nothing ... [column, row]"},
        Mistake{"cloth.pinned.0={point: [0, 0], uv: [0, 0]}",
                "cloth.pinned.0.point: got a place, too ... instead"},
        Mistake{"cloth.pinned.0={point: {uv: [0, 0]}}",
                "cloth.pinned.0.point: got ... [column, row]"},
        Mistake{"cloth.pinned.0={near: [0, 0, 0], uv: [0, 0]}",
                "cloth.pinned.0: got a part of a place, or two ... near"},
        Mistake{"cloth.pinned.0={within: 1}",
                "cloth.pinned.0: got a part of a place, or two ... within and of"},
        Mistake{"cloth.pinned.0={within: 0.1, of: [9, 9, 9]}",
                "cloth.pinned.0.within: got 0.1 ... with points of the cloth"},
        Mistake{"cloth.pinned.0={uv: [0, 1.5]}", "cloth.pinned.0.uv.1: got 1.5 ... 0 to 1"},
        Mistake{"cloth.pinned.0={uv: [1]}", "cloth.pinned.0.uv: got [1] ... [u, v]"},
        Mistake{"cloth.pinned.0={}", "cloth.pinned.0.point: got nothing ... near"},
        Mistake{"cloth.pinned.1.frame=/hand", "cloth.pinned.1.frame: got \"/hand\" ... slash"}));

INSTANTIATE_TEST_SUITE_P(
    WrongName, SceneMistake,
    testing::Values(
        Mistake{"cloth.orientation=diagonal",
                "cloth.orientation: got diagonal ... horizontal, vertical"},
        Mistake{"colliders.0.shape=teapot",
                "colliders.0.shape: got teapot ... sphere, plane, capsule, box, cylinder, mesh"},
        Mistake{"colliders.0={name: ball}",
                "colliders.0.shape: got nothing ... sphere, plane, capsule, box, cylinder, mesh"},
        Mistake{"colliders.0.name=''", "colliders.0.name: got \"\" ... empty"},
        Mistake{"colliders.0.frame=''", "colliders.0.frame: got \"\" ... empty"},
        Mistake{"colliders.0.frame=/ball", "colliders.0.frame: got \"/ball\" ... slash"},
        Mistake{"colliders.0.name=ground",
                "colliders.1.name: got \"ground\" ... again ... item 0"}));

TEST(SceneYaml, WholeMessagesReadLikeThese) {
  const auto message_of = [](const char* assignment) -> std::string {
    try {
      read_changed({assignment});
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message_of("cloth.ks=-5"), "cloth.ks: got -5, expected a number of at least 0 [N/m]");
  EXPECT_EQ(message_of("cloth.ks='5000'"),
            "cloth.ks: got \"5000\" (text), expected a finite number");
  EXPECT_EQ(message_of("cloth.springs.bend=true"),
            "cloth.springs.bend: got an unknown key, expected one of structural, shear, bending");
  EXPECT_EQ(message_of("colliders.0.name=ground"),
            "colliders.1.name: got \"ground\" again, expected a name other than that of item 0");
}

TEST(SceneYaml, UnknownClothKeyListsAllOfThem) {
  EXPECT_TRUE(says(refusal("cloth: {kss: 1}"),
                   std::string("cloth.kss: got ... unknown ... ") + cloth_keys));
}

TEST(SceneYaml, UnknownMethodListsTheKnown) {
  EXPECT_TRUE(says(refusal("{cloth: {}, simulation: {method: magic}}"),
                   "simulation.method: got \"magic\" ... auto, verlet"));
}

TEST(SceneYaml, RefusesKeysGivenTwice) {
  EXPECT_TRUE(says(refusal("cloth: {ks: 1, ks: 1}"), "cloth.ks: got ... again"));
  EXPECT_TRUE(says(refusal("cloth: {}\ncloth: {}"), "cloth: got ... again"));
}

TEST(SceneYaml, RefusesWhatIsNoScene) {
  EXPECT_TRUE(says(refusal("[1, 2]"), "scene: got [1, 2] ... map"));
  EXPECT_TRUE(says(refusal("~"), "scene: got nothing ... map"));
  EXPECT_TRUE(says(refusal("{}"), "cloth: got nothing ... map"));
  EXPECT_TRUE(says(refusal("{[1, 2]: 3}"), "scene: got [1, 2] as a key ... name"));
}

TEST(SceneYaml, SurvivesANodeThatHoldsItself) {
  EXPECT_TRUE(says(refusal("cloth: &c {pinned: &p [*p, *c]}"),
                   "cloth.pinned.0.0: got ... list of 2 ... whole"));
}

TEST(SceneYaml, MessagesHoldNoControlCharacters) {
  EXPECT_TRUE(says(refusal("cloth: {\"a\\e[2J\\nb\": 1}"), "cloth.a?[2J?b: "));
}

TEST(SceneYaml, MessagesStayShortWhateverTheyGot) {
  const std::string name(5'000'000, 'x');
  EXPECT_LT(refusal("{cloth: {}, simulation: {method: " + name + "}}").size(), 2000u);
  EXPECT_LT(refusal("{cloth: {}, colliders: [{shape: plane, name: " + name +
                    "}, {shape: plane, name: " + name + "}]}")
                .size(),
            2000u);
  EXPECT_LT(
      InvalidValue({name, name}, name, name).inside(name).message(name.substr(0, 9), "/").size(),
      6000u);
}

TEST(SceneYaml, ShortenedTextsEndWithAWholeCharacter) {
  EXPECT_EQ(shortened("\u00e4\u00e4\u00e4", 3), "\u00e4...");
  EXPECT_EQ(shortened("\u00e4\u00e4\u00e4", 4), "\u00e4\u00e4...");
  EXPECT_EQ(shortened("abc", 3), "abc");
}

TEST(SceneYaml, NamesTheParameterTheWayTheNodeWritesIt) {
  try {
    read_changed({"colliders.0.radius=-1"});
    FAIL() << "accepted";
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), (std::vector<std::string>{"colliders", "0", "radius"}));
    EXPECT_TRUE(says(error.message("/clothsim/scene/", "/"),
                     "/clothsim/scene/colliders/0/radius: got -1 ... least 1e-06 [m]"));
  }
}

}  // namespace
}  // namespace clothsim::scene_mistakes_test
