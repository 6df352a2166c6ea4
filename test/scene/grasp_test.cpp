// Two fingers take a ridge of a cloth on a table, lift it by friction alone and carry it: a few
// cases of scripts/grasp_matrix, whose table is in docs/grasping.md.

#include <algorithm>
#include <cmath>
#include <vector>

#include "clothsim/geometry/intersections.h"
#include "verification/testing.h"

namespace clothsim::grasp_test {
namespace {

using namespace test;

constexpr double side = 0.24;    // of the cloth [m]
constexpr double rod = 0.005;    // radius of the rod below the ridge [m]
constexpr double top = 0.055;    // height of its middle [m]
constexpr double tips = 0.024;   // height of the fingers' middle when they close [m]
constexpr double lift = 0.15;    // [m]
constexpr double speed = 0.1;    // of a finger [m/s]
constexpr double gravity = 9.8;  // [m/s^2]
constexpr int table = 0, left = 1, right = 2, under = 3;

struct Case {
  const char* name;
  double gap;  // [m]
  Shape finger;
  double reach;      // of the finger, from its face to its middle [m]
  double spacing;    // of points [m]
  double thickness;  // of a layer [m]
  double friction;   // of the fingers
  bool holds;
  double aside = 0;  // of the cloth, along x [m]
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const Shape box = Cuboid{{0.02, 0.04, 0.03}};

const Case cases[] = {
    {"room_for_less_than_one", 0.0, box, 0.01, 0.01, 0.002, 0.6, true},
    {"room_for_one", 0.002, box, 0.01, 0.01, 0.002, 0.6, true},
    {"room_for_one_and_a_half", 0.003, box, 0.01, 0.01, 0.002, 0.6, true},
    {"coarse", 0.001, box, 0.01, 0.02, 0.002, 0.6, true},
    {"thin_layers_without_room", 0.0, box, 0.01, 0.015, 0.0009, 1, true},
    // Its cells are five times as wide as the fingers, which slip or not by where a cell is: in 4
    // of 16 places of the cloth over a cell's width they do.
    {"thin_fingers", 0.001, Capsule{0.04, 0.002}, 0.002, 0.02, 0.002, 0.6, true, 5e-3},
    {"too_wide", 0.003, box, 0.01, 0.01, 0.001, 0.2, false},
};

/// Place and height [m] on a line that runs up one side of the rod and down the other, at an arc
/// length `way` from its top [m].
Eigen::Vector2d ridge(double way, double radius, double height) {
  const double sign = way < 0 ? -1 : 1;
  const double round = radius * M_PI / 2, wall = top - height;
  double left_over = std::abs(way);
  if (left_over < round) {
    const double angle = left_over / radius;
    return {sign * radius * std::sin(angle), top + radius * std::cos(angle)};
  }
  left_over -= round;
  if (left_over < wall) return {sign * radius, top - left_over};
  return {sign * (radius + left_over - wall), height};
}

/// The cloth over a rod, and two fingers.
class Hand {
 public:
  /// The cloth is shifted by `aside` [m] along x.
  explicit Hand(const Case& c, double aside = 0) : case_(c), simulator_(scene(c)) {
    const double height = case_.thickness / 2 + 2e-4;
    // So wide that chords between points clear the rod.
    const double radius = std::hypot(rod + case_.thickness / 2 + 5e-4, case_.spacing / 2);
    State state = simulator_.state();
    const int columns = simulator_.cloth().columns;
    for (int i = 0; i < state.positions.rows(); ++i) {
      const Eigen::Vector2d at = ridge((i % columns) * case_.spacing - side / 2, radius, height);
      state.positions.row(i) << at.x() + case_.aside + aside,
          (i / columns) * case_.spacing - side / 2, at.y();
    }
    simulator_.set_state(state);
    half_ = radius + 0.012;
    place();
    for (int frame = 0; frame < 36; ++frame) simulator_.step();
  }

  /// Moves the fingers to a half opening and a height [m], from rest to rest, and turns them by an
  /// angle about a vertical axis between them [rad].
  void go(double half, double z, double seconds, double turn = 0) {
    const int frames = static_cast<int>(std::lround(seconds / simulator_.frame_duration()));
    const double from_half = half_, from_z = z_, from_angle = angle_;
    max_speed_beyond_fall_ = 0;
    for (int frame = 1; frame <= frames; ++frame) {
      const double linear = static_cast<double>(frame) / frames;
      const double share = linear * linear * (3 - 2 * linear);  // 1.5 times as fast at most
      half_ = from_half + share * (half - from_half);
      z_ = from_z + share * (z - from_z);
      angle_ = from_angle + share * turn;
      for (const int which : {left, right}) simulator_.move_collider(which, finger(which));
      const StepReport report = simulator_.step();
      pinched_ = report.pinched;
      EXPECT_EQ(report.slipping, 0) << "nothing pulls it from the fingers";
      EXPECT_EQ(report.recoveries, 0);
      const State& state = simulator_.state();
      const double highest = state.positions.col(2).maxCoeff();
      for (int i = 0; i < state.positions.rows(); ++i) {
        const double fall = 2 * gravity * (highest - state.positions(i, 2));
        max_speed_beyond_fall_ =
            std::max(max_speed_beyond_fall_, state.velocities.row(i).squaredNorm() - fall);
      }
    }
    max_speed_beyond_fall_ = std::sqrt(max_speed_beyond_fall_);
  }

  /// Points between the fingers.
  std::vector<int> between() const {
    std::vector<int> points;
    for (int i = 0; i < simulator_.state().positions.rows(); ++i) {
      const Vector3 x = row(simulator_.state().positions, i);
      const bool is_near = std::abs(x.x()) < 0.01 && std::abs(x.y()) < 0.018;
      if (is_near && std::abs(x.z() - z_) < std::max(0.012, 0.6 * case_.spacing)) {
        points.push_back(i);
      }
    }
    return points;
  }

  /// Closes the fingers, removes the support of the cloth, and lifts it.
  void lift_it() {
    go(closed(), z_, (half_ - closed()) / speed);
    go(closed(), z_, 0.2);
    simulator_.enable_collider(under, false);
    held_ = between();
    before_ = simulator_.state().positions;
    go(closed(), z_ + lift, lift / speed);
  }

  double closed() const { return case_.gap / 2; }
  double height() const { return z_; }
  int pinched() const { return pinched_; }
  Simulator& simulator() { return simulator_; }
  bool holds_any() const { return !held_.empty(); }

  /// Largest velocity of a point in the last go(), beyond that of free fall [m/s].
  double max_speed_beyond_fall() const { return max_speed_beyond_fall_; }

  /// Median distance of the points first held to their places in the moved fingers [m].
  double slipped() const {
    std::vector<double> lag;
    for (const int i : held_) {
      const Vector3 with_fingers = turn_about_z() * row(before_, i) + Vector3(0, 0, lift);
      lag.push_back((row(simulator_.state().positions, i) - with_fingers).norm());
    }
    const auto middle = lag.begin() + static_cast<std::ptrdiff_t>(lag.size() / 2);
    std::nth_element(lag.begin(), middle, lag.end());
    return *middle;
  }

 private:
  static Scene scene(const Case& c) {
    Scene scene;
    scene.cloth.width = scene.cloth.height = side;
    scene.cloth.columns = scene.cloth.rows = static_cast<int>(std::lround(side / c.spacing)) + 1;
    scene.cloth.origin = Vector3(0, -side / 2, 0.01);
    Fabric fabric;  // as config/fabrics/cotton_towel.yaml
    fabric.stretch_stiffness = {600, 450};
    fabric.shear_stiffness = 25;
    fabric.bending_stiffness = {2.5e-5, 1.8e-5};
    fabric.internal_damping = {1e-5, 4e-3};
    scene.cloth.material.fabric = fabric;
    scene.cloth.material.density = 0.35;
    scene.cloth.material.strain_limit.reset();
    scene.cloth.material.damping = 1;
    scene.cloth.thickness = c.thickness / 2;
    scene.cloth.friction = 0.5;
    scene.cloth.self_collision = SelfCollision::surface;
    scene.simulation.method = "xpbd";
    scene.simulation.substeps = 10;
    const Pose level{Vector3::Zero(), Eigen::Quaterniond::Identity()};
    const Pose along_y{Vector3(0, 0, top), turn_to_y()};
    scene.colliders = {{"table", Plane{}, level, 0.5, ""},
                       {"left", c.finger, level, c.friction, ""},
                       {"right", c.finger, level, c.friction, ""},
                       {"rod", Capsule{side, rod}, along_y, 0, ""}};
    return scene;
  }

  static Eigen::Quaterniond turn_to_y() {
    return Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()));
  }

  Pose finger(int which) const {
    const double x = (which == left ? -1 : 1) * (half_ + case_.reach);
    const bool is_rod = std::holds_alternative<Capsule>(case_.finger);
    const Pose level{Vector3(x, 0, z_), is_rod ? turn_to_y() : Eigen::Quaterniond::Identity()};
    return Pose{Vector3::Zero(), turn_about_z()} * level;
  }

  Eigen::Quaterniond turn_about_z() const {
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle_, Vector3::UnitZ()));
  }

  void place() {
    for (const int which : {left, right}) simulator_.place_collider(which, finger(which));
  }

  Case case_;
  Simulator simulator_;
  double half_ = 0;
  double z_ = tips;
  double angle_ = 0;  // [rad]
  int pinched_ = 0;
  double max_speed_beyond_fall_ = 0;  // [m/s]
  std::vector<int> held_;             // of the fingers, before they lift
  Points before_;                     // positions then
};

class Grasp : public ::testing::TestWithParam<Case> {};

TEST_P(Grasp, HoldsWhatIsThickerThanTheGap) {
  Hand hand(GetParam());
  hand.lift_it();
  ASSERT_TRUE(hand.holds_any());
  const double up = hand.max_speed_beyond_fall();
  const double closed = hand.closed();
  hand.go(closed, hand.height(), 1, M_PI / 2);
  hand.go(closed, hand.height(), 0.5);
  Simulator& simulator = hand.simulator();
  EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  if (!GetParam().holds) {
    EXPECT_GT(hand.slipped(), 0.03);
    return;
  }
  EXPECT_LT(hand.slipped(), 5e-3);
  EXPECT_GT(hand.pinched(), 0);

  // In two or three of ten runs that start some nanometres apart, an edge of the fold snaps free as
  // the table goes, at 0.5 to 0.65 m/s; with cells of 20 mm it turns over at 0.30 to 0.39 m/s.
  double calmest = up, max_speed = up;
  for (const double aside : {1e-9, 2e-9}) {
    Hand other(GetParam(), aside);
    other.lift_it();
    calmest = std::min(calmest, other.max_speed_beyond_fall());
    max_speed = std::max(max_speed, other.max_speed_beyond_fall());
  }
  EXPECT_LT(calmest, 4 * speed);
  EXPECT_LT(max_speed, 1) << "nothing is flung";

  // A restored copy continues bit-identically.
  const auto saved = simulator.save();
  hand.go(closed, hand.height(), 0.05);
  const Points expected = simulator.state().positions;
  simulator.restore(*saved);
  hand.go(closed, hand.height(), 0.05);
  EXPECT_TRUE(simulator.state().positions == expected);

  hand.go(0.015, hand.height(), 0.015 / speed);
  hand.go(0.015, hand.height(), 0.3);
  EXPECT_EQ(hand.pinched(), 0);
  // With cells of 20 mm the fold has turned over, and in half of the runs hangs over a finger.
  if (GetParam().spacing >= 0.02) return;
  EXPECT_LT(simulator.state().positions.col(2).maxCoeff(), hand.height() + 0.04) << "it falls";
}

INSTANTIATE_TEST_SUITE_P(Cases, Grasp, ::testing::ValuesIn(cases),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace clothsim::grasp_test
