// Cloths of random materials in self contact: dropped, hit by a sphere, pressed or twisted. No two
// triangles cross in any frame, by a check of all near pairs in double precision.

#include <algorithm>
#include <cmath>
#include <iostream>

#include "clothsim/geometry/intersections.h"
#include "fuzz/draw.h"
#include "fuzz/fuzz.h"
#include "verification/testing.h"

namespace clothsim {

const int test::usual_count = 6;

namespace {

using namespace test;

/// Largest stretch of a spring on which neither pins nor colliders pull.
constexpr double max_stretch = 0.12;

/// Largest depth below the ground [m] at the end of a frame, where the crossing guard holds back
/// the cloth.
constexpr double held_skin = 2e-3;

/// RMS speed of a cloth at rest [m/s], over half a second.
constexpr double calm = 1e-3;

/// Processor time after which a scene is abandoned [s].
constexpr double max_cpu = 60;

enum class Attack { drop, sphere, press, twist };

/// A cloth in self contact, and its drive.
class Folding {
 public:
  explicit Folding(std::uint64_t seed) : draw_(seed), simulator_(scene(seed)) {}

  void step() {
    drive();
    const StepReport report = simulator_.step();
    ++frame_;
    worst_ = std::max(worst_, report.worst_stretch);
    lowest_ = std::min(lowest_, simulator_.state().positions.col(2).minCoeff());
    speed2_ += std::pow(rms_velocity(simulator_.state()), 2);
    EXPECT_EQ(count_intersections(simulator_.cloth(), simulator_.state().positions), 0);
    if (attack_ == Attack::drop) {
      EXPECT_LT(report.worst_stretch, max_stretch);
    }
    // Cloth that is driven into the ground, or pressed onto it, has no room.
    if (attack_ == Attack::drop || (attack_ == Attack::sphere && is_calm())) {
      EXPECT_GT(simulator_.state().positions.col(2).minCoeff(), -held_skin);
    }
    if (frame_ % 45 == 0) {
      speed_ = std::sqrt(speed2_ / 45);
      speed2_ = 0;
    }
  }

  double time() const { return simulator_.state().time; }
  bool is_driven() const { return attack_ != Attack::drop && time() < driven_until; }
  bool is_calm() const { return !is_driven() && speed_ < calm; }
  /// Fine cloths are checked as they fold, coarse ones until they rest; hanging ones swing.
  bool is_to_rest() const {
    return columns_ == 30 && (attack_ == Attack::drop || attack_ == Attack::sphere);
  }

  void print() const {
    static const char* const names[] = {"drop", "sphere", "press", "twist"};
    std::cout << names[static_cast<int>(attack_)] << ", " << columns_ << " x " << columns_
              << ", ks " << material_.ks << ", " << material_.density << " kg/m^2, half thickness "
              << 1e3 * simulator_.cloth().thickness << " mm: " << time() << " s, stretch " << worst_
              << ", lowest " << lowest_ << " m, rms " << speed_ << " m/s";
  }

 private:
  static constexpr double begins = 1, driven_until = 2;  // [s]

  Scene scene(std::uint64_t seed) {
    Scene scene = shipped_scene("self_collision");
    attack_ = draw_.one_of<Attack>(
        {Attack::drop, Attack::drop, Attack::sphere, Attack::press, Attack::twist});
    columns_ = draw_.one_of<int>({30, 30, 30, 30, 30, 50, 50, 100});
    scene.cloth.columns = scene.cloth.rows = columns_;
    material_.ks = draw_.decades(50, 1e5);
    material_.density = draw_.decades(0.15, 1e4);
    scene.cloth.material = material_;
    scene.cloth.thickness = draw_.decades(5e-4, 1e-2);
    scene.cloth.self_collision = SelfCollision::surface;
    scene.simulation.seed = seed;
    if (attack_ == Attack::drop) scene.cloth.origin.z() += draw_.even(0, 1);
    speed_of_drive_ = draw_.decades(1.2, 100);
    if (attack_ == Attack::sphere) {
      scene.colliders.push_back({"ball", Sphere{0.15}, pose_of_drive(0), 0.3, ""});
    } else if (attack_ == Attack::press) {
      scene.colliders.push_back({"press", Plane{}, pose_of_drive(0), 0.5, ""});
    } else if (attack_ == Attack::twist) {
      scene.colliders.clear();
      for (int column = 0; column < columns_; ++column) {
        scene.cloth.pinned.push_back({column, 0, ""});
        scene.cloth.pinned.push_back({column, columns_ - 1, ""});
      }
      turns_ = draw_.even(0.25, 0.75);
    }
    return scene;
  }

  /// A ball that goes down through the cloth into the ground, or a plane that comes down to 3 cm
  /// above the ground and goes up again.
  Pose pose_of_drive(double after) const {
    const double way = std::clamp(speed_of_drive_ * after, 0.0, 1.2);
    if (attack_ == Attack::sphere) return {{0.5, 0, 1 - way}, Eigen::Quaterniond::Identity()};
    const Eigen::Quaterniond down(Eigen::AngleAxisd(M_PI, Vector3::UnitX()));
    const double share = std::clamp(2 - 2 * std::abs(after - 0.5) / 0.5, 0.0, 1.0);
    return {{0, 0, 1.5 - share * 1.47}, down};
  }

  void drive() {
    const double after = time() + simulator_.frame_duration() - begins;
    if (attack_ == Attack::drop || after < 0 || !is_driven()) return;
    if (attack_ == Attack::twist) {
      twist(std::min(1.0, after / (driven_until - begins)));
    } else {
      simulator_.move_collider(1, pose_of_drive(after));
    }
  }

  /// Turns the last row about the line between the middles of both end rows, as it comes nearer.
  void twist(double share) {
    const int last = simulator_.cloth().num_points() - columns_;
    const Vector3 first_middle = (row(start_, 0) + row(start_, columns_ - 1)) / 2;
    const Vector3 middle =
        (row(start_, last) + row(start_, simulator_.cloth().num_points() - 1)) / 2;
    const Vector3 axis = (middle - first_middle).normalized();
    const Eigen::AngleAxisd turn(2 * M_PI * turns_ * share, axis);
    const Vector3 nearer = share * turns_ * (first_middle - middle);
    for (int column = 0; column < columns_; ++column) {
      const Vector3 arm = row(start_, last + column) - middle;
      simulator_.move_pin(2 * column + 1, middle + turn * arm + nearer);
    }
  }

  Draw draw_;
  Attack attack_ = Attack::drop;
  int columns_ = 0;
  Material material_;
  double speed_of_drive_ = 0, turns_ = 0;
  Simulator simulator_;
  Points start_ = simulator_.state().positions;
  int frame_ = 0;
  double worst_ = 0, lowest_ = 1, speed2_ = 0, speed_ = 1;
};

TEST(FuzzFolding, NothingCrosses) {
  for_each_seed([](std::uint64_t seed) {
    const double begin = cpu_seconds();
    Folding folding(seed);
    const double seconds = folding.is_to_rest() ? 10 : 2.5;
    const auto is_cut = [&] { return cpu_seconds() - begin > max_cpu; };
    while (folding.time() < seconds && !has_failed() && !folding.is_calm() && !is_cut()) {
      folding.step();
    }
    if (folding.is_to_rest() && !has_failed() && !is_cut()) {
      EXPECT_TRUE(folding.is_calm());
    }
    folding.print();
    if (is_cut()) std::cout << ", cut";
    std::cout << ", " << (cpu_seconds() - begin) / folding.time() << " CPU seconds a second";
  });
}

}  // namespace
}  // namespace clothsim
