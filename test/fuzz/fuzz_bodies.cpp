// Random scenes of rigid bodies on, over and under a cloth: free, on joints, of several shapes,
// with points of the cloth attached, and held by a frame for a while. Invariants hold in every
// frame.

#include <algorithm>
#include <cmath>
#include <iostream>

#include "bodies.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "clothsim/shapes/mass_properties.h"
#include "fuzz/fuzz.h"
#include "fuzz/random_bodies.h"
#include "verification/testing.h"

namespace clothsim {

const int test::usual_count = 8;

namespace {

using namespace test;

constexpr double run_for = 5, held_for = 1;  // [s]
constexpr double on_place = 1e-9;            // of joints, parts and attached points [m], [rad]
constexpr double slow = 0.05;                // speed of a body that lies [m/s]
constexpr double restless_share = 0.15;      // of lying bodies: they roll or swing on the cloth

/// A number that no scene may take beyond `worst`, and few beyond `usual`: where heavy bodies hit
/// light cloth on a floor, see docs/limits.md.
struct Bound {
  const char* name;
  double usual;
  double worst;
  double most = 0;  // in the running scene
  int beyond = 0;   // scenes

  void see(double value, const std::string& where) {
    most = std::max(most, value);
    EXPECT_LT(value, worst) << name << where;
  }
  void end_scene() {
    beyond += most > usual;
    std::cout << name << ' ' << most << "; ";
    most = 0;
  }
};

/// Share of the scenes that may take a number beyond the usual.
constexpr double unusual_share = 0.1;

struct Bounds {
  Bound depth{"cloth in a collider [m]", 1e-3, 0.03};
  Bound overlap{"colliders overlap [m]", 2e-3, 0.01};
  Bound made{"energy from nothing, of that which could move", 0.05, 0.5};
  Bound thrown{"speed of a body, of the fall's", 3, 12};
  Bound whipped{"speed of the cloth, of the fall's and of springs' release", 1, 3};

  template <class F>
  void for_each(const F& f) {
    for (Bound* bound : {&depth, &overlap, &made, &thrown, &whipped}) f(*bound);
  }
};

constexpr double whip = 8;  // speed of cloth to that of the fall

/// Balls by which a shape meets another one: of round shapes, and points of edges and faces.
std::vector<std::pair<Vector3, double>> probes(const Shape& shape) {
  std::vector<std::pair<Vector3, double>> balls;
  constexpr int n = 12;
  if (const auto* s = std::get_if<Sphere>(&shape)) balls = {{{0, 0, 0}, s->radius}};
  for (int i = 0; i < (n + 1) * (n + 1); ++i) {
    const double u = i % (n + 1) / (1.0 * n) - 0.5, v = i / (n + 1) / (1.0 * n) - 0.5;
    if (const auto* c = std::get_if<Capsule>(&shape)) {
      balls.push_back({{0, 0, u * c->length}, c->radius});
    } else if (const auto* d = std::get_if<Cylinder>(&shape)) {
      const double x = std::cos(2 * M_PI * v), y = std::sin(2 * M_PI * v);
      balls.push_back({{d->radius * x, d->radius * y, u * d->length}, 0});
    } else if (const auto* box = std::get_if<Cuboid>(&shape)) {
      for (const double w : {-0.5, 0.5}) {
        for (const Vector3& p : {Vector3(u, v, w), Vector3(w, u, v), Vector3(v, w, u)}) {
          balls.push_back({p.cwiseProduct(box->size), 0});
        }
      }
    }
  }
  return balls;
}

/// A random scene as it runs.
class BodiesRun {
 public:
  BodiesRun(const BodyScene& made, Bounds& bounds)
      : made_(made), simulator_(made.scene), bounds_(bounds) {
    for (const ColliderSpec& c : specs()) {
      probes_.push_back(probes(c.shape));
      highest_ = std::max(highest_, c.pose.position.z());
    }
    if (made.held >= 0) simulator_.attach_body(made.held, "hand", {});
  }

  bool is_over() const { return state().time > run_for; }

  void step() {
    drive();
    report_ = simulator_.step();
    ASSERT_TRUE(state().positions.allFinite() && state().velocities.allFinite());
    worst_ = std::max(worst_, report_.worst_stretch);
    check_contact();
    check_speeds();
    for (std::size_t k = 0; k < specs().size(); ++k) {
      for (std::size_t l = 0; l < specs().size(); ++l) check_overlap(k, l);
      if (!specs()[k].part_of.empty()) check_part(k);
      if (specs()[k].body && specs()[k].body->joint) check_joint(k, *specs()[k].body->joint);
    }
    for (const BodyPoints& attached : made_.scene.cloth.attached) check_attached(attached);
    if (made_.held < 0 || state().time > held_for + 0.02) check_energy();
  }

  /// Counts the bodies that lie in the end, and those of them that move.
  void count_restless(int& lying, int& restless) const {
    for (std::size_t k = 0; k < specs().size() && made_.setting != Setting::hung; ++k) {
      const bool is_held = simulator_.grips().count(specs()[k].name) > 0;
      if (!specs()[k].body || specs()[k].body->joint || is_held) continue;
      ++lying;
      if (motion(k).velocity.norm() < slow) continue;
      ++restless;
      std::cout << "; " << specs()[k].name << " moves at " << motion(k).velocity.norm() << " m/s";
    }
  }

 private:
  const State& state() const { return simulator_.state(); }
  const std::vector<ColliderSpec>& specs() const { return simulator_.scene().colliders; }
  const Pose& pose(std::size_t k) const { return simulator_.collider_pose(static_cast<int>(k)); }
  BodyMotion motion(std::size_t k) const { return simulator_.body_motion(static_cast<int>(k)); }
  std::string body_of(std::size_t k) const {
    return specs()[k].body ? specs()[k].name : specs()[k].part_of;
  }
  std::string when() const { return ", t " + std::to_string(state().time); }

  void drive() {
    if (made_.held < 0 || !simulator_.frame_of_body(made_.held)) return;
    const double t = state().time + simulator_.frame_duration();
    if (t > held_for) return simulator_.detach_body(made_.held);
    const Vector3& middle = specs()[static_cast<std::size_t>(made_.held)].pose.position;
    const Eigen::Quaterniond turn = turned(Eigen::Quaterniond::Identity(), t * made_.turn);
    simulator_.move_grip("hand", {middle + t * made_.velocity - turn * middle, turn});
  }

  void check_speeds() {
    const double fall = std::sqrt(2 * g * (highest_ + 1)) + 2 + made_.turn.norm();
    for (std::size_t k = 0; k < specs().size(); ++k) {
      if (specs()[k].body) {
        bounds_.thrown.see(motion(k).velocity.norm() / fall, " of " + specs()[k].name + when());
      }
    }
    const Material& material = made_.scene.cloth.material;
    const double sound = std::sqrt(4 * material.ks / material.density);
    bounds_.whipped.see(max_speed(state()) / (whip * fall + 2 * worst_ * sound), when());
  }

  void check_contact() {
    if (!is_pressed()) bounds_.depth.see(deepest_penetration(simulator_), when());
    if (simulator_.cloth().self_collision != SelfCollision::surface) return;
    EXPECT_EQ(count_intersections(simulator_.cloth(), state().positions), 0) << when();
  }

  /// Does the hand move points of the cloth, perhaps into a collider?
  bool is_pressed() const {
    const auto is_held = [&](const BodyPoints& attached) {
      return *simulator_.body_named(attached.body) == made_.held;
    };
    const auto& attached = made_.scene.cloth.attached;
    return std::any_of(attached.begin(), attached.end(), is_held);
  }

  void check_overlap(std::size_t a, std::size_t b) {
    if (body_of(a) == body_of(b)) return;  // also of colliders that are no bodies
    double depth = 0;
    for (const auto& [center, radius] : probes_[a]) {
      const Vector3 local = to_local(pose(b), to_world(pose(a), center));
      depth = std::max(depth, radius - signed_distance(specs()[b].shape, local, local).value);
    }
    bounds_.overlap.see(depth, ": " + specs()[a].name + " in " + specs()[b].name + when());
  }

  void check_part(std::size_t k) {
    const auto leader = static_cast<std::size_t>(*simulator_.body_named(specs()[k].part_of));
    const Pose& start = specs()[leader].pose;
    const Vector3 place = to_world(pose(leader), to_local(start, specs()[k].pose.position));
    EXPECT_LT((pose(k).position - place).norm(), on_place) << specs()[k].name << when();
    const Eigen::Quaterniond way = start.orientation.conjugate() * specs()[k].pose.orientation;
    const Eigen::Quaterniond apart =
        pose(k).orientation.conjugate() * pose(leader).orientation * way;
    EXPECT_LT(apart.vec().norm(), on_place) << specs()[k].name << when();
  }

  void check_joint(std::size_t k, const Joint& joint) {
    const Pose& start = specs()[k].pose;
    const Eigen::Quaterniond turn = pose(k).orientation * start.orientation.conjugate();
    Vector3 off = turn.vec(), away = pose(k).position - start.position;
    double at = joint.axis.dot(away);
    if (joint.kind == Joint::Kind::hinge) {
      at = std::remainder(2 * std::atan2(joint.axis.dot(off), turn.w()), 2 * M_PI);
      off -= joint.axis.dot(off) * joint.axis;
      away = to_world(pose(k), to_local(start, joint.point)) - joint.point;
    } else {
      away -= at * joint.axis;
    }
    EXPECT_LT(off.norm() + away.norm(), on_place) << specs()[k].name << when();
    EXPECT_LT(std::max(joint.lower - at, at - joint.upper), on_place) << specs()[k].name << when();
  }

  /// Points are at their places, except for those that the crossing guard holds back for a while.
  void check_attached(const BodyPoints& attached) {
    const double lag = simulator_.grips().at(attached.body).lag;
    const auto k = static_cast<std::size_t>(*simulator_.body_named(attached.body));
    for (const auto& [column, r] : attached.points) {
      const int i = r * simulator_.cloth().columns + column;
      const Vector3 place = to_world(pose(k), to_local(specs()[k].pose, row(start_, i)));
      EXPECT_LT((row(state().positions, i) - place).norm(), lag + on_place) << when();
    }
    EXPECT_TRUE(lag < on_place || report_.held_back > 0) << lag << when();
  }

  /// Without the energy of springs [J].
  double energy_of_motion() const {
    double sum = kinetic_energy(simulator_.cloth(), state()) +
                 gravitational_energy(simulator_.cloth(), {0, 0, -g}, state().positions);
    for (std::size_t k = 0; k < specs().size(); ++k) {
      if (!specs()[k].body) continue;
      const Vector3 rate = pose(k).orientation.conjugate() * motion(k).angular_velocity;
      const Matrix3 inertia = mass_properties(specs()[k].shape)->inertia;
      const double moving = motion(k).velocity.squaredNorm() + rate.dot(inertia * rate);
      sum += specs()[k].body->mass * (moving / 2 + g * pose(k).position.z());
    }
    return sum;
  }

  /// Energy above the least one so far. Springs may gain some, see EnergyAccount; and so may all
  /// where the strain limit yields, see docs/limits.md.
  void check_energy() {
    const double moving = energy_of_motion();
    const double elastic = elastic_energy(simulator_.cloth(), state().positions);
    const auto& limit = simulator_.cloth().strain_limit;
    const bool begins = scale_ == 0 || (limit && report_.worst_stretch > 2 * *limit);
    if (begins) scale_ = moving + elastic;
    if (begins || moving + elastic < least_ + least_elastic_) {
      least_ = moving;
      least_elastic_ = elastic;
    }
    const double made = moving - least_ - std::max(0.0, least_elastic_ - elastic);
    bounds_.made.see(made / scale_, when());
  }

  const BodyScene& made_;
  Simulator simulator_;
  Bounds& bounds_;
  Points start_ = simulator_.state().positions;
  StepReport report_;
  std::vector<std::vector<std::pair<Vector3, double>>> probes_;  // by collider
  double highest_ = 0;                                // of the colliders at the start [m]
  double worst_ = 0;                                  // stretch
  double scale_ = 0, least_ = 0, least_elastic_ = 0;  // energies [J]
};

TEST(FuzzBodies, RandomScenes) {
  Bounds bounds;
  int scenes = 0, lying = 0, restless = 0;
  for_each_seed([&](std::uint64_t seed) {
    const BodyScene made = random_body_scene(seed);
    std::cout << made.text;
    BodiesRun run(made, bounds);
    const double begun = cpu_seconds();
    while (!run.is_over() && !has_failed()) run.step();
    bounds.for_each([](Bound& bound) { bound.end_scene(); });
    std::cout << cpu_seconds() - begun << " CPU s";
    if (!has_failed()) run.count_restless(lying, restless);
    ++scenes;
  });
  bounds.for_each([&](const Bound& bound) {
    std::cout << bound.name << " beyond " << bound.usual << ": " << bound.beyond << " of " << scenes
              << '\n';
    EXPECT_LE(bound.beyond, 1 + unusual_share * scenes) << bound.name;
  });
  std::cout << restless << " of " << lying << " bodies that lie move\n";
  EXPECT_LE(restless, 1 + restless_share * lying);
}

}  // namespace
}  // namespace clothsim
