// Random scenes: cloths of all materials, pinned, thrown and pushed by moving colliders. The
// invariants of all such scenes are checked after every frame.

#include <algorithm>
#include <cmath>
#include <iostream>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/errors.h"
#include "clothsim/run/report.h"
#include "fuzz/fuzz.h"
#include "fuzz/random_scene.h"
#include "verification/energy_account.h"
#include "verification/testing.h"

namespace clothsim {

const int test::usual_count = 40;

namespace {

using namespace test;

/// Speed [m/s] that is allowed in any scene, for cloth that leaves a collider, or swings.
constexpr double usual_speed = 10;

/// Allowed ratio of the cloth's speed to the drive's: the end of a whip is faster than its handle.
constexpr double whip = 8;

/// Stretch over the strain limit without a pull: the limit's tolerance plus the effect of contact.
constexpr double over_limit = 0.05;

/// Time [s] within which colliders push out a cloth that overlapped them at the start.
constexpr double time_to_leave = 1;

/// Depth of the cloth in a collider [m] that is allowed after a frame's repairs.
constexpr double skin = 1e-3;

/// The same where pins pull on cloth that the crossing guard holds back: 2.2 mm in one frame of
/// seed 24.
constexpr double held_skin = 5e-3;

/// Distance [m] to its target within which a pin has arrived.
constexpr double arrived = 1e-9;

/// Shares of the energy that a second without drive may add, and of the angular momentum: errors of
/// the methods, and of velocities that are sampled once a frame. A cloth that trembles adds all its
/// energy many times a second.
constexpr double made_share = 0.1;
constexpr double spin_share = 0.05;

/// Relative error of the momentum that is allowed to a method in gravity and drag.
constexpr double momentum_share = 1e-4;

/// Mean, weighted by mass.
Vector3 mean(const Cloth& cloth, const Points& points) {
  return points.transpose() * cloth.mass / cloth.mass.sum();
}

/// Angular momentum about the centre of mass, per kilogram [m^2/s].
Vector3 spin(const Cloth& cloth, const State& state) {
  const Vector3 momentum_of_middle =
      mean(cloth, state.positions).cross(mean(cloth, state.velocities));
  return angular_momentum(cloth, state) / cloth.mass.sum() - momentum_of_middle;
}

/// Upper bound of the speed of sound in a cloth [m/s].
double sound(const Material& material) {
  const auto& fabric = material.fabric;
  const double stiffness = fabric
                               ? std::max({fabric->stretch_stiffness[0],
                                           fabric->stretch_stiffness[1], fabric->shear_stiffness})
                               : material.ks;
  return std::sqrt(4 * stiffness / material.density);
}

/// A random scene as it runs.
class SceneRun {
 public:
  explicit SceneRun(const RandomScene& random)
      : random_(random), simulator_(random.scene), start_(simulator_.state()) {
    throw_cloth();
    is_out_ = deepest_penetration(simulator_) == 0;
  }

  void step() {
    const double dt = simulator_.frame_duration();
    const bool is_driven = time_ + dt / 2 < driven_for;
    drive();
    report_ = simulator_.step();
    time_ += dt;
    recoveries_ += report_.recoveries;
    visits_ +=
        1.0 * cloth().num_points() * (report_.substeps + report_.sweeps + report_.corrections);
    worst_ = std::max(worst_, report_.worst_stretch);
    max_speed_ = std::max(max_speed_, test::max_speed(state()));
    ASSERT_TRUE(state().positions.allFinite() && state().velocities.allFinite());
    check_speed();
    check_stretch();
    check_colliders();
    check_crossings();
    was_held_back_ = was_held_back_ || report_.held_back > 0;
    const bool is_free = random_.pins.empty() && random_.colliders.empty() && !has_air();
    if (is_free && !was_held_back_) check_momentum();
    if (is_driven || has_air() || is_pin_late()) {
      account_.begin(simulator_);
    } else {
      made_ = account_.share_made(simulator_);
      EXPECT_LT(made_, made_share) << "energy out of nothing";
    }
  }

  bool is_over() const { return time_ >= driven_for + still_for; }

  /// Prints cost and results.
  void print(double cpu) const {
    std::cout << "; " << cpu / time_ << " CPU seconds and " << visits_ / time_
              << " visits of points a second, stretch " << worst_ << ", fastest " << max_speed_
              << " m/s, in the end " << rms_velocity(state()) << " m/s rms, deepest " << deepest_
              << " m, " << recoveries_ << " recoveries, made " << made_ << " of the energy";
  }

 private:
  const Cloth& cloth() const { return simulator_.cloth(); }
  const State& state() const { return simulator_.state(); }
  const Vector3& gravity() const { return random_.scene.simulation.gravity; }
  bool has_air() const {
    return random_.scene.simulation.wind || random_.scene.simulation.gusts > 0;
  }
  double size() const { return std::hypot(random_.scene.cloth.width, random_.scene.cloth.height); }

  /// Sets the velocities of a thrown cloth.
  void throw_cloth() {
    if (random_.velocity.isZero()) return;
    const Vector3 middle = mean(cloth(), start_.positions);
    for (int i = 0; i < cloth().num_points(); ++i) {
      const Vector3 arm = row(start_.positions, i) - middle;
      start_.velocities.row(i) = (random_.velocity + random_.spin.cross(arm)).transpose();
    }
    simulator_.set_state(start_);
  }

  /// Moves colliders and pins to their places at the end of the frame.
  void drive() {
    const double t = time_ + simulator_.frame_duration();
    for (std::size_t i = 0; i < random_.colliders.size(); ++i) {
      const Pose& start = random_.scene.colliders[i].pose;
      simulator_.move_collider(static_cast<int>(i), random_.colliders[i].at(t, start));
    }
    for (std::size_t i = 0; i < random_.pins.size(); ++i) {
      simulator_.move_pin(static_cast<int>(i), pin_target(i, t));
    }
  }

  int pin_point(std::size_t i) const {
    const Pin& pin = random_.scene.cloth.pinned[i];
    return pin.row * cloth().columns + pin.column;
  }

  Vector3 pin_target(std::size_t i, double time) const {
    const Pose start{row(start_.positions, pin_point(i)), Eigen::Quaterniond::Identity()};
    return random_.pins[i].at(time, start).position;
  }

  /// Whether a pin is not at its target yet. A pin that its own cloth has blocked goes on to its
  /// target, and drives the cloth meanwhile.
  bool is_pin_late() const {
    for (std::size_t i = 0; i < random_.pins.size(); ++i) {
      const Vector3 at = row(state().positions, pin_point(i));
      if ((at - pin_target(i, time_)).norm() > arrived) return true;
    }
    return false;
  }

  /// Bound of the speed: drive, fall, and the release of springs, which is the speed of sound in
  /// the cloth times the stretch.
  void check_speed() {
    const double bound = usual_speed + whip * random_.max_drive_speed() + gravity().norm() * time_ +
                         2 * worst_ * sound(random_.scene.cloth.material);
    EXPECT_LT(test::max_speed(state()), bound);
  }

  void check_stretch() {
    const std::optional<double>& limit = cloth().strain_limit;
    if (!limit || random_.may_be_pulled() || !is_out_) return;
    EXPECT_LT(report_.worst_stretch, *limit + over_limit) << report_.reasons.text();
  }

  void check_colliders() {
    const double depth = deepest_penetration(simulator_);
    if (depth == 0) is_out_ = true;
    if (!is_out_ && time_ < time_to_leave) return;
    if (report_.pinched > 0 || has_pins_at_colliders()) return;
    deepest_ = std::max(deepest_, depth);
    const bool is_held = report_.held_back > 0 && random_.may_be_pulled();
    EXPECT_LT(depth, is_held ? held_skin : skin);
  }

  /// A pinned point in a collider stays there, and so may the springs at it.
  bool has_pins_at_colliders() const {
    double longest = 0;
    for (const SpringRun& run : cloth().springs) longest = std::max(longest, run.rest_length);
    const double near = longest * (1 + worst_);
    for (const int pin : cloth().pinned) {
      for (std::size_t c = 0; c < random_.colliders.size(); ++c) {
        const Pose& pose = simulator_.collider_pose(static_cast<int>(c));
        const Vector3 local = to_local(pose, row(state().positions, pin));
        if (signed_distance(random_.scene.colliders[c].shape, local, local).value < near) {
          return true;
        }
      }
    }
    return false;
  }

  void check_crossings() {
    if (cloth().self_collision != SelfCollision::surface) return;
    EXPECT_EQ(count_intersections(cloth(), state().positions), 0);
  }

  /// Springs, strain limit and self contact neither move nor turn a free cloth. Only gravity, with
  /// the same acceleration at all points, and drag do.
  void check_momentum() {
    const double c = cloth().damping, kept = std::exp(-c * time_);
    const double fell = c > 0 ? (1 - kept) / c : time_;
    const Vector3 velocity = kept * mean(cloth(), start_.velocities) + fell * gravity();
    EXPECT_LT((mean(cloth(), state().velocities) - velocity).norm(),
              momentum_share * (1 + velocity.norm()));
    const double scale = size() * (1 + test::max_speed(start_));
    EXPECT_LT((spin(cloth(), state()) - kept * spin(cloth(), start_)).norm(), spin_share * scale);
  }

  const RandomScene& random_;
  Simulator simulator_;
  State start_;
  StepReport report_;
  double time_ = 0;
  int recoveries_ = 0;
  double visits_ = 0;     // of points, in substeps and passes
  double worst_ = 0;      // largest stretch
  double max_speed_ = 0;  // [m/s]
  double deepest_ = 0;    // in a collider, once the cloth was out of all [m]
  bool is_out_ = false;
  bool was_held_back_ = false;  // by the crossing guard
  EnergyAccount account_;       // since the end of the drive
  double made_ = 0;
};

void run_scene(const RandomScene& random) {
  std::cout << random.text() << std::flush;
  SceneRun scene(random);
  const double begun = cpu_seconds();
  try {
    while (!scene.is_over() && !has_failed()) scene.step();
  } catch (const Diverged&) {
    if (random.scene.simulation.method == "auto") throw;
    std::cout << "; diverged, as a named method may";
  }
  scene.print(cpu_seconds() - begun);
}

TEST(FuzzScene, RandomScenes) {
  for_each_seed([](std::uint64_t seed) { run_scene(random_scene(seed)); });
}

TEST(FuzzScene, RandomFabrics) {
  for_each_seed([](std::uint64_t seed) { run_scene(random_fabric_scene(seed)); });
}

}  // namespace
}  // namespace clothsim
