// Self contact of a cloth in cases that tangle other codes: no two of its triangles cross, in any
// frame.

#include <cmath>
#include <cstdlib>
#include <tuple>

#include "algebra.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "five_layers.h"
#include "verification/testing.h"

namespace clothsim::self_contact_test {
namespace {

using namespace test;

/// A cloth of 25 x 25 points, 4 cm apart, so that points alone would let layers pass.
Scene pile() {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.cloth.self_collision = SelfCollision::surface;
  return scene;
}

struct Judgement {
  int held_back = 0;
  int frames_that_cross = 0;
};

/// Counts crossings after each frame; drive(frame) moves holders and colliders before it.
template <typename Drive>
Judgement judge(Simulator& simulator, int frames, const Drive& drive) {
  Judgement judgement;
  for (int frame = 1; frame <= frames; ++frame) {
    drive(frame);
    judgement.held_back += simulator.step().held_back;
    EXPECT_TRUE(simulator.state().positions.allFinite()) << frame;
    const int crossing = count_intersections(simulator.cloth(), simulator.state().positions);
    EXPECT_EQ(crossing, 0) << "in frame " << frame;
    if (crossing > 0 && ++judgement.frames_that_cross > 3) break;
  }
  return judgement;
}

Judgement judge(Simulator& simulator, int frames) {
  return judge(simulator, frames, [](int) {});
}

/// Continues until the cloth lies still, for `seconds` at most, and counts crossings. Returns the
/// root mean square velocity in its last half a second [m/s].
double rest(Simulator& simulator, double seconds) {
  constexpr double calm = 1e-3;  // [m/s]
  double speed = 1;
  for (double begin = simulator.state().time; simulator.state().time < begin + seconds;) {
    double sum = 0;
    const Judgement judgement = judge(
        simulator, 45, [&](int) { sum += std::pow(rms_velocity(simulator.state()), 2) / 45; });
    speed = std::sqrt(sum);
    if (speed < calm || judgement.frames_that_cross > 0) break;
  }
  ::testing::Test::RecordProperty("at_rest_after_s", std::to_string(simulator.state().time));
  ::testing::Test::RecordProperty("mm_s", std::to_string(1e3 * speed));
  return speed;
}

/// A cloth with both end rows pinned, `width` x 1 m of 4 cm cells.
Scene strip(double width) {
  Scene scene;
  scene.cloth.width = width;
  scene.cloth.columns = static_cast<int>(std::lround(width / 0.04)) + 1;
  scene.cloth.rows = 26;
  scene.cloth.self_collision = SelfCollision::surface;
  return scene;
}

class Pile : public ::testing::TestWithParam<std::pair<double, double>> {};

TEST_P(Pile, NeverCrossesItselfAndComesToRest) {
  Scene scene = pile();
  scene.cloth.material.ks = GetParam().first;
  scene.cloth.material.density = GetParam().second;
  Simulator simulator(scene);
  EXPECT_LT(rest(simulator, 8), 1e-3);
}

// Stiffness [N/m] and density [kg/m^2].
INSTANTIATE_TEST_SUITE_P(Materials, Pile,
                         ::testing::Values(std::pair(50.0, 150.0), std::pair(5000.0, 150.0),
                                           std::pair(1e5, 150.0), std::pair(5000.0, 10.0),
                                           std::pair(5000.0, 1e4)));

TEST(SelfContact, ADropOfTwoMetres) {
  Scene scene = pile();
  scene.cloth.origin.z() = 2;
  Simulator simulator(scene);
  EXPECT_LT(rest(simulator, 8), 1e-3);
}

struct Fall {
  int side;          // [points]
  double thickness;  // half of it [m]
  int seed;
};

/// Depth [m] to which a thin cloth gets into the ground as it falls, without a crossing or a
/// stretch beyond the limit. Layers come down at metres a second: points that the guard holds back
/// hang on their neighbours.
double depth_in_ground(const Fall& fall) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = fall.side;
  scene.cloth.thickness = fall.thickness;
  scene.simulation.seed = static_cast<std::uint64_t>(fall.seed);
  scene.cloth.self_collision = SelfCollision::surface;
  Simulator simulator(scene);
  double stretch = 0, lowest = 0;  // [m]
  for (int part = 0; part < 100; ++part) {
    judge(simulator, 1);
    stretch = std::max(stretch, worst_stretch(simulator.cloth(), simulator.state().positions));
    lowest = std::min(lowest, simulator.state().positions.col(2).minCoeff());
  }
  EXPECT_LT(stretch, 0.105);
  return -lowest;
}

/// The guard holds back points that are on their way out: at most `most` falls get into the ground.
void expect_falls(const std::vector<Fall>& falls, int most) {
  int in_ground = 0;
  for (const Fall& fall : falls) {
    SCOPED_TRACE(fall.seed);
    const double depth = depth_in_ground(fall);
    EXPECT_LT(depth, 1e-3);
    in_ground += depth >= surface_offset;
  }
  ::testing::Test::RecordProperty("in_ground", in_ground);
  EXPECT_LE(in_ground, most);
}

TEST(SelfContact, AThinClothTearsAtNothing) {
  std::vector<Fall> falls = {{50, 5e-4, 1}};
  for (int seed = 1; seed <= 6; ++seed) falls.push_back({30, 1e-3, seed});
  expect_falls(falls, 0);
}

TEST(DISABLED_Survey, FortyFallsOfAThinCloth) {
  std::vector<Fall> falls;
  for (int seed = 1; seed <= 40; ++seed) falls.push_back({30, 1e-3, seed});
  expect_falls(falls, 4);
}

class Twist : public ::testing::TestWithParam<double> {};

TEST_P(Twist, OfAStripBetweenTwoRows) {
  Scene scene = strip(0.32);
  const int columns = scene.cloth.columns, last = scene.cloth.rows - 1;
  for (int column = 0; column < columns; ++column) {
    scene.cloth.pinned.push_back({column, 0, ""});
    scene.cloth.pinned.push_back({column, last, ""});
  }
  Simulator simulator(scene);
  const auto drive = [&](int frame) {
    const double share = std::min(1.0, frame / 180.0);
    const double angle = 2 * M_PI * GetParam() * share;
    for (int column = 0; column < columns; ++column) {
      const double r = 0.04 * column - 0.16;
      simulator.move_pin(2 * column + 1, {0.16 + r * std::cos(angle), 1 - 0.5 * GetParam() * share,
                                          1 + r * std::sin(angle)});
    }
  };
  judge(simulator, 2 * 90, drive);
  EXPECT_LT(rest(simulator, 4), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Turns, Twist, ::testing::Values(0.5, 1.0));

TEST(SelfContact, FiveLayersPressedByAPlane) {
  // A strip in five layers, pressed to the height at which all touch.
  Scene scene = strip_for_layers();
  const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Vector3::UnitX()));
  scene.colliders.push_back({"press", Plane{}, Pose{Vector3(0, 0, 0.3), down}, 0.5, ""});
  Simulator simulator(scene);
  simulator.set_state(five_layers(simulator));
  const double pressed = 4 * 2 * scene.cloth.thickness;
  judge(simulator, 4 * 90, [&](int frame) {
    const double share = std::min(1.0, frame / 180.0);
    simulator.move_collider(1, {Vector3(0, 0, 0.3 + share * (pressed + 0.002 - 0.3)), down});
  });
  EXPECT_LT(simulator.state().positions.col(2).maxCoeff(), pressed + 0.0025);
  EXPECT_LT(rms_velocity(simulator.state()), 1e-3);
}

/// A sphere that comes down on the middle of the pile.
Pose ball_at(double z) { return {Vector3(0.5, 0, z), Eigen::Quaterniond::Identity()}; }

Scene pile_below_a_ball() {
  Scene scene = pile();
  scene.colliders.push_back({"ball", Sphere{0.15}, ball_at(1), 0.3, ""});
  return scene;
}

/// Whether a pile rests after a sphere at `speed` [m/s] has gone through it, without a crossing.
bool rests_after_sphere(double speed, std::uint64_t seed) {
  // The sphere goes on into the ground and pinches the cloth in between, until all of it is below.
  Scene scene = pile_below_a_ball();
  scene.simulation.seed = seed;
  Simulator simulator(scene);
  run(simulator, 1);
  const int frames = std::max(1, static_cast<int>(std::lround(90 * 1.2 / speed)));
  judge(simulator, frames,
        [&](int frame) { simulator.move_collider(1, ball_at(1 - 1.2 * frame / frames)); });
  // The pressed cloth separates again: no knot stays.
  const bool calm = rest(simulator, 8) < 1e-3;
  EXPECT_LT(worst_stretch(simulator.cloth(), simulator.state().positions), 0.11);
  return calm && simulator.step().held_back == 0;
}

/// Piles of seeds from 1 on, hit at 100 m/s.
void expect_rest_at_100_m_s(int seeds, int most_that_move) {
  int move = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE(seed);
    move += !rests_after_sphere(100, static_cast<std::uint64_t>(seed));
  }
  ::testing::Test::RecordProperty("moving", move);
  EXPECT_LE(move, most_that_move);
}

class SphereThroughPile : public ::testing::TestWithParam<double> {};

TEST_P(SphereThroughPile, CrossesNothingAndLeavesItAtRest) {
  EXPECT_TRUE(rests_after_sphere(GetParam(), 1));
}

INSTANTIATE_TEST_SUITE_P(Speeds, SphereThroughPile, ::testing::Values(1.0, 10.0));

TEST(SphereThroughPiles, LeavesThemAtRestAt100MetresASecond) { expect_rest_at_100_m_s(4, 0); }

TEST(DISABLED_Survey, FiftyPilesHitAt100MetresASecond) { expect_rest_at_100_m_s(50, 1); }

TEST(SelfContact, APileUnderASphereThatLeavesItNoRoomIsCalm) {
  // The sphere stops 5 cm deep in the ground, where the cloth in between has no rest shape. It does
  // not cross, and trembles no faster than this; 0.01 m/s rms were measured.
  Simulator simulator(pile_below_a_ball());
  run(simulator, 1);
  judge(simulator, 81,
        [&](int frame) { simulator.move_collider(1, ball_at(1 - 0.9 * frame / 81)); });
  judge(simulator, 180);
  EXPECT_GT(simulator.step().pinched, 10);
  EXPECT_LT(rms_velocity(simulator.state()), 0.05);
}

TEST(SelfContact, PinsDraggedThroughTheClothAreHeldBackAndSaidSo) {
  // Four pins hold a cell of a hanging cloth, which cannot give way. A pin on its lower edge is
  // led before the cell and then drawn through it, to the other side and back.
  constexpr int side = 13;
  constexpr int half = side / 2;
  Scene scene = pile();
  scene.cloth.columns = scene.cloth.rows = side;
  scene.colliders.clear();
  scene.cloth.pinned = {{half, 0, ""},
                        {half, half, ""},
                        {half + 1, half, ""},
                        {half, half + 1, ""},
                        {half + 1, half + 1, ""}};
  Simulator simulator(scene);
  run(simulator, 0.3);
  const auto pin = [&] { return point(simulator.cloth(), simulator.state().positions, half, 0); };
  const auto corner = [&] {
    return point(simulator.cloth(), simulator.state().positions, half, half);
  };
  const double middle = (half + 0.5) / (side - 1);  // of the cell, along x and z
  const Vector3 below = pin();
  const Vector3 before(middle, 0.15, middle);
  const Vector3 held = corner();

  const Judgement free = judge(simulator, 90, [&](int frame) {
    simulator.move_pin(0, below + frame / 90.0 * (before - below));
  });
  EXPECT_EQ(free.held_back, 0);
  const Judgement through = judge(simulator, 45, [&](int frame) {
    simulator.move_pin(0, before - Vector3(0, 0.3 * frame / 45.0, 0));
  });
  EXPECT_GT(through.held_back, 0);
  EXPECT_GT(pin().y(), corner().y()) << "on the side from which it came";
  EXPECT_LT(pin().y(), corner().y() + 0.05) << "as far as it can go";
  judge(simulator, 45, [&](int frame) {
    simulator.move_pin(0, before - Vector3(0, 0.3 * (45 - frame) / 45.0, 0));
  });
  judge(simulator, 45);  // it comes back, and sticks again
  EXPECT_EQ(pin(), before) << "follows when it can";
  EXPECT_EQ(corner(), held);
}

TEST(SelfContact, PinchedBetweenTwoClosingSpheres) {
  Scene scene = pile();
  scene.cloth.pinned = {{0, 24, ""}, {24, 24, ""}};
  const auto at = [](double y) {
    return Pose{Vector3(0.5, y, 0.5), Eigen::Quaterniond::Identity()};
  };
  scene.colliders = {{"front", Sphere{0.2}, at(-0.4), 0.3, ""},
                     {"back", Sphere{0.2}, at(0.4), 0.3, ""}};
  Simulator simulator(scene);
  double mean = 0;  // of the fastest point [m/s]
  int pinched = 0;
  for (int frame = 1; frame <= 120; ++frame) {
    const double y = 0.4 - 0.25 * std::min(1.0, frame / 60.0);  // overlapping in the end
    simulator.move_collider(0, at(-y));
    simulator.move_collider(1, at(y));
    pinched = std::max(pinched, simulator.step().pinched);
    ASSERT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0) << frame;
    mean += max_speed(simulator.state()) / 120;
  }
  RecordProperty("mean_fastest_m_s", std::to_string(mean));
  EXPECT_LT(mean, 1);
  EXPECT_GT(pinched, 10) << "what cannot be met is reported";
}

class TableClothPull : public ::testing::TestWithParam<double> {};

TEST_P(TableClothPull, CrossesNothingAndLeavesItAtRest) {
  // The cloth hangs over the edge of a table that is drawn away from under it.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.cloth.origin = Vector3(0, 0, 0.5 + surface_offset);
  scene.cloth.thickness = 0.005;
  scene.cloth.self_collision = SelfCollision::surface;
  const auto at = [](double x) {
    return Pose{Vector3(x, 0.5, 0.25), Eigen::Quaterniond::Identity()};
  };
  scene.colliders = {{"table", Cuboid{Vector3(0.8, 1.2, 0.5)}, at(0.4), 0.3, ""},
                     {"floor", Plane{}, Pose{}, 0.5, ""}};
  Simulator simulator(scene);
  judge(simulator, 45);
  double x = 0.4;
  const double speed = GetParam();
  for (int frame = 1; x < 1.6; ++frame) {
    x += std::min(1.0, frame / 9.0) * speed / 90;  // at full speed after 0.1 s
    judge(simulator, 1, [&](int) { simulator.move_collider(0, at(x)); });
  }
  EXPECT_LT(rest(simulator, 6), 1e-3);
  EXPECT_EQ(deepest_penetration(simulator), 0);
}

INSTANTIATE_TEST_SUITE_P(Speeds, TableClothPull, ::testing::Values(0.5, 2.0, 8.0));

TEST(SelfContact, TumbledInARoomThatTurns) {
  // Half a turn a second. CLOTHSIM_TUMBLE_SECONDS=30 makes it a long one.
  const char* asked = std::getenv("CLOTHSIM_TUMBLE_SECONDS");
  const int frames = static_cast<int>(90 * (asked ? std::stod(asked) : 2));
  Scene scene = pile();
  scene.colliders.clear();
  scene.cloth.origin = Vector3(0, 0.5, 0.01);
  const Vector3 centre(0.5, 0.5, 0.5);
  std::vector<Eigen::Quaterniond> walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      walls.push_back(turn_between(Vector3::UnitZ(), sign * Vector3::Unit(axis)));
    }
  }
  const auto wall = [&](std::size_t i, double angle) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Vector3::UnitY()));
    const Eigen::Quaterniond orientation = turn * walls[i];
    return Pose{centre - 0.55 * (orientation * Vector3::UnitZ()), orientation};
  };
  for (std::size_t i = 0; i < walls.size(); ++i) {
    scene.colliders.push_back({"wall" + std::to_string(i), Plane{}, wall(i, 0), 0.5, ""});
  }
  Simulator simulator(scene);
  judge(simulator, frames, [&](int frame) {
    for (std::size_t i = 0; i < walls.size(); ++i) {
      simulator.move_collider(static_cast<int>(i), wall(i, 2 * M_PI * frame / 180.0));
    }
  });
}

/// Layers without springs that fall side by side at 1.5 m/s, and land within a frame.
class LandingLayers : public ::testing::TestWithParam<std::tuple<double, int>> {
 protected:
  static Simulator land(const ClothSpec& cloth, const Points& from) {
    Scene scene;
    scene.cloth = cloth;
    scene.cloth.thickness = 0.005;
    scene.cloth.material.springs = {false, false, false};
    scene.cloth.material.strain_limit.reset();
    scene.cloth.material.damping = 0;
    scene.simulation.frames_per_second = std::get<0>(GetParam());
    scene.simulation.substeps = std::get<1>(GetParam());
    scene.colliders = {ColliderSpec{"ground", Plane{}, {}, 0.5, ""}};
    Simulator simulator(scene);
    State state = simulator.state();
    state.positions = from;
    state.velocities.col(2).setConstant(-1.5);
    simulator.set_state(state);
    return simulator;
  }
};

TEST_P(LandingLayers, PointsStopOneAfterAnother) {
  for (int height = 0; height < 10; ++height) {
    ClothSpec cloth;
    cloth.columns = 2;
    cloth.rows = 1;
    cloth.self_collision = SelfCollision::points;
    Points x = Points::Zero(2, 3);
    x.col(2) << 0.1 + 0.01 * height, 0.12 + 0.01 * height;
    Simulator simulator = land(cloth, x);
    for (int frame = 0; frame < 20; ++frame) {
      simulator.step();
      const Points& now = simulator.state().positions;
      EXPECT_GT(now(1, 2) - now(0, 2), 0.008) << height << ' ' << frame;
    }
  }
}

TEST_P(LandingLayers, SurfacesStopOneAfterAnother) {
  constexpr int columns = 12, rows = 4;
  for (int height = 0; height < 5; ++height) {
    ClothSpec cloth;
    cloth.columns = columns;
    cloth.rows = rows;
    cloth.width = 1.1;
    cloth.height = 0.3;
    cloth.self_collision = SelfCollision::surface;
    Points x = Points::Zero(columns * rows, 3);
    for (int i = 0; i < columns * rows; ++i) {
      const int row = i / columns, column = i % columns;
      const double z = 0.1 + 0.007 * height;
      if (2 * column < columns) {
        x.row(i) << 0.1 * column, 0.1 * row, z;
      } else {  // the other half, turned back over it
        x.row(i) << 0.1 * (columns - 1 - column) + 0.03, 0.1 * row + 0.02, z + 0.02;
      }
    }
    Simulator simulator = land(cloth, x);
    for (int frame = 0; frame < 20; ++frame) {
      EXPECT_EQ(simulator.step().held_back, 0) << height << ' ' << frame;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FramesAndSubsteps, LandingLayers,
                         ::testing::Combine(::testing::Values(30.0, 120.0),
                                            ::testing::Values(20, 40)));

}  // namespace
}  // namespace clothsim::self_contact_test
