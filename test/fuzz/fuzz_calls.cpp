// Random calls of the simulator's functions, with ordinary values and with absurd ones. A refusal
// changes nothing, all numbers stay finite, and held points stay at their holders.

#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>

#include "clothsim/model/errors.h"
#include "fuzz/draw.h"
#include "fuzz/fuzz.h"
#include "fuzz/random_scene.h"
#include "verification/testing.h"

namespace clothsim {

const int test::usual_count = 40;

namespace {

using namespace test;

constexpr int max_side_points = 8;  // points along a side of a cloth
constexpr int calls = 60;           // for each seed

/// Distance [m] between a held point and its place above which the test fails.
constexpr double held_tolerance = 1e-9;

const std::vector<std::string> frames = {"left", "right", "other"};

class Caller {
 public:
  /// With fabrics: classic cloths become fabrics and fabrics classic cloths, in wind.
  Caller(std::uint64_t seed, bool with_fabrics)
      : draw_(seed), with_fabrics_(with_fabrics), simulator_(scene(seed)) {}

  /// Makes one call and returns its name.
  const char* call();

  bool is_finite() const {
    return simulator_.state().positions.allFinite() && simulator_.state().velocities.allFinite();
  }
  int refused() const { return refused_; }
  int diverged() const { return diverged_; }

 private:
  struct Call {
    const char* name;
    void (Caller::*make)();
  };

  void step();
  void spoil(Fabric&);
  void set_material();
  void set_simulation();
  void attach();
  void detach() { simulator_.detach(points()); }
  void move_grip() { simulator_.move_grip(draw_.one_of(frames), pose()); }
  void move_pin() { simulator_.move_pin(index(pins()), pose().position); }
  void move_collider() { simulator_.move_collider(index(colliders()), pose()); }
  void place_collider() { simulator_.place_collider(index(colliders()), pose()); }
  void enable_collider() { simulator_.enable_collider(index(colliders()), draw_.happens(0.5)); }
  void save() { saved_ = simulator_.save(); }
  void restore() {
    if (saved_) simulator_.restore(*saved_);
  }
  void replay();
  void set_state();
  void set_memory();
  void reset() {
    simulator_.reset();
    EXPECT_EQ(simulator_.state().time, 0);
    EXPECT_TRUE(simulator_.grips().empty());
  }
  void load() { simulator_.load(scene(seed())); }

  // Arguments of the calls.
  Scene scene(std::uint64_t seed) {
    const bool is_fabric = with_fabrics_ && draw_.happens(0.7);
    return (is_fabric ? random_fabric_scene : random_scene)(seed, max_side_points).scene;
  }
  std::uint64_t seed() { return static_cast<std::uint64_t>(draw_.whole(1, 1'000'000)); }
  bool is_hostile() { return draw_.happens(0.1); }
  double hostile() {
    return draw_.one_of<double>(
        {std::nan(""), std::numeric_limits<double>::infinity(), -1, 0, 1e300, -1e300, 1e-300});
  }
  int pins() const { return static_cast<int>(simulator_.scene().cloth.pinned.size()); }
  int colliders() const { return static_cast<int>(simulator_.scene().colliders.size()); }
  int index(int count) {
    return is_hostile() ? draw_.whole(-2, count + 2) : draw_.whole(0, std::max(0, count - 1));
  }
  Pose pose();
  std::vector<int> points();

  void expect_held() const;

  Draw draw_;
  bool with_fabrics_;
  Simulator simulator_;
  std::shared_ptr<const Simulator::Saved> saved_;
  int refused_ = 0;
  int diverged_ = 0;
};

Pose Caller::pose() {
  const ClothSpec& cloth = simulator_.scene().cloth;
  const Vector3 size = Vector3::Constant(std::max(cloth.width, cloth.height));
  Pose pose{draw_.in_box(cloth.origin - size, cloth.origin + 2 * size), draw_.orientation()};
  if (is_hostile()) pose.position[draw_.whole(0, 2)] = hostile();
  if (is_hostile()) pose.orientation.x() += hostile();
  return pose;
}

std::vector<int> Caller::points() {
  const int count = simulator_.cloth().num_points();
  std::vector<int> points;
  for (int i = draw_.whole(is_hostile() ? 0 : 1, 4); i > 0; --i) {
    points.push_back(is_hostile() ? draw_.whole(-5, 2 * count) : draw_.whole(0, count - 1));
  }
  return points;
}

void Caller::spoil(Fabric& fabric) {
  if (is_hostile()) fabric.stretch_stiffness[draw_.whole(0, 1)] = hostile();
  if (is_hostile()) fabric.shear_stiffness = hostile();
  if (is_hostile()) fabric.bending_stiffness[draw_.whole(0, 1)] = hostile();
  if (is_hostile()) fabric.internal_damping[draw_.whole(0, 1)] = hostile();
  if (is_hostile()) fabric.poisson = hostile();
}

void Caller::set_material() {
  Material material = scene(seed()).cloth.material;
  if (is_hostile()) material.ks = hostile();
  if (is_hostile()) material.density = hostile();
  if (is_hostile()) material.damping = hostile();
  if (is_hostile()) material.strain_limit = hostile();
  if (material.fabric) spoil(*material.fabric);
  for (bool& family : material.springs) family = draw_.happens(0.9);
  simulator_.set_material(material);
}

void Caller::set_simulation() {
  SimulationSpec simulation = scene(seed()).simulation;
  if (draw_.happens(0.2)) simulation.substeps = draw_.whole(1, 20);
  if (is_hostile()) simulation.gravity.x() = hostile();
  if (is_hostile()) simulation.frames_per_second = hostile();
  if (is_hostile()) simulation.method = "no method";
  if (simulation.wind && is_hostile()) simulation.wind->y() = hostile();
  simulator_.set_simulation(simulation);
}

void Caller::attach() {
  std::optional<double> tear_force;
  if (draw_.happens(0.3)) tear_force = is_hostile() ? hostile() : draw_.decades(0.01, 1000);
  std::optional<double> strength;
  if (draw_.happens(0.3)) strength = is_hostile() ? hostile() : draw_.decades(0.01, 1000);
  simulator_.attach(draw_.one_of(frames), pose(), points(), {tear_force, strength});
}

void Caller::step() {
  for (int frame = draw_.whole(1, 5); frame > 0; --frame) {
    const State before = simulator_.state();
    try {
      simulator_.step();
    } catch (const Diverged&) {
      ++diverged_;
      EXPECT_EQ(simulator_.state().positions, before.positions) << "the last good frame";
      return;
    }
    expect_held();
  }
}

/// Each held point is where its frame has it, up to the lag that the grip reports.
void Caller::expect_held() const {
  for (const auto& [frame, grip] : simulator_.grips()) {
    for (const Grip::Held& held : grip.held) {
      const Vector3 place = grip.pose.position + grip.pose.orientation * held.offset;
      const double apart = (row(simulator_.state().positions, held.point) - place).norm();
      EXPECT_LT(apart, grip.lag + held_tolerance * (1 + place.norm()))
          << frame << ' ' << held.point;
    }
  }
}

/// A restored copy continues bit-identically.
void Caller::replay() {
  const auto copy = simulator_.save();
  const auto go_on = [&] {
    try {
      run(simulator_, 3 * simulator_.frame_duration());
    } catch (const Diverged&) {
      ++diverged_;
    }
    return simulator_.state();
  };
  const State first = go_on();
  simulator_.restore(*copy);
  const State second = go_on();
  EXPECT_EQ(first.positions, second.positions);
  EXPECT_EQ(first.velocities, second.velocities);
}

void Caller::set_state() {
  const int count = simulator_.cloth().num_points();
  const double size = simulator_.scene().cloth.width;
  State state = simulator_.state();
  const Points shake = random_points(count, size * draw_.decades(1e-4, 10), seed());
  const Points kick = random_points(count, draw_.decades(1e-3, 999), seed());
  for (int i = 0; i < count; ++i) {
    if (simulator_.cloth().inv_mass[i] > 0) state.positions.row(i) += shake.row(i);
  }
  state.velocities += draw_.happens(0.5) ? 1 * kick : 0 * kick;
  if (is_hostile()) state.positions(draw_.whole(0, count - 1), draw_.whole(0, 2)) = hostile();
  if (is_hostile()) state.velocities(draw_.whole(0, count - 1), draw_.whole(0, 2)) = hostile();
  if (is_hostile()) state.time = hostile();
  if (is_hostile()) state.positions.conservativeResize(count - 1, 3);
  simulator_.set_state(state);
}

/// The current memory, damaged.
void Caller::set_memory() {
  std::vector<double> memory = simulator_.memory();
  for (int i = draw_.whole(0, 3); i > 0; --i) {
    double& number =
        memory[static_cast<std::size_t>(draw_.whole(0, static_cast<int>(memory.size()) - 1))];
    number = draw_.happens(0.5) ? hostile() : number * draw_.even(-2, 2);
  }
  if (is_hostile()) memory.resize(memory.size() / 2);
  simulator_.set_state(simulator_.state(), memory);
}

const char* Caller::call() {
  static const std::vector<Call> all = {{"step", &Caller::step},
                                        {"step", &Caller::step},
                                        {"step", &Caller::step},
                                        {"set_material", &Caller::set_material},
                                        {"set_simulation", &Caller::set_simulation},
                                        {"attach", &Caller::attach},
                                        {"detach", &Caller::detach},
                                        {"move_grip", &Caller::move_grip},
                                        {"move_pin", &Caller::move_pin},
                                        {"move_collider", &Caller::move_collider},
                                        {"place_collider", &Caller::place_collider},
                                        {"enable_collider", &Caller::enable_collider},
                                        {"save", &Caller::save},
                                        {"restore", &Caller::restore},
                                        {"replay", &Caller::replay},
                                        {"set_state", &Caller::set_state},
                                        {"set_memory", &Caller::set_memory},
                                        {"reset", &Caller::reset},
                                        {"load", &Caller::load}};
  const Call& chosen = draw_.one_of(all);
  const State before = simulator_.state();
  const std::vector<double> memory_before = simulator_.memory();
  const auto refuse = [&] {
    ++refused_;
    EXPECT_EQ(simulator_.state().positions, before.positions) << chosen.name << " changed it";
    EXPECT_EQ(simulator_.state().velocities, before.velocities) << chosen.name << " changed it";
    EXPECT_EQ(simulator_.memory(), memory_before) << chosen.name << " changed it";
  };
  try {
    (this->*chosen.make)();
  } catch (const InvalidValue&) {
    refuse();
  } catch (const std::out_of_range&) {
    refuse();
  }
  return chosen.name;
}

void make_calls(std::uint64_t seed, bool with_fabrics) {
  const double begun = cpu_seconds();
  Caller caller(seed, with_fabrics);
  for (int i = 0; i < calls && !has_failed(); ++i) {
    const std::string name = caller.call();
    EXPECT_TRUE(caller.is_finite()) << name;
    if (has_failed()) std::cout << "call " << i << ", " << name << ": ";
  }
  std::cout << caller.refused() << " of " << calls << " calls refused, " << caller.diverged()
            << " diverged, " << cpu_seconds() - begun << " CPU seconds";
}

TEST(FuzzCalls, RandomCalls) {
  for_each_seed([](std::uint64_t seed) { make_calls(seed, false); });
}

TEST(FuzzCalls, RandomCallsOfFabrics) {
  for_each_seed([](std::uint64_t seed) { make_calls(seed, true); });
}

}  // namespace
}  // namespace clothsim
