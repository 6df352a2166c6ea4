// All methods follow one path: the trajectory of pinned2 without strain limit to t = 0.5 s, each at
// its order. A cloth of 10 x 10 points keeps it short.

#include <cmath>
#include <limits>

#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/errors.h"
#include "verification/testing.h"

namespace clothsim::trajectory_test {
namespace {

using namespace test;

constexpr double seconds = 0.5;

ClothSpec pinned2() {
  ClothSpec spec = shipped_scene("pinned2").cloth;
  spec.columns = spec.rows = 10;
  spec.pinned = {{0, 0, ""}, {9, 0, ""}};
  spec.material.strain_limit.reset();
  return spec;
}

template <typename Method>
State end(Method method, int steps) {
  const ClothSpec spec = pinned2();
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  run(method, cloth, Loads(), seconds / steps, steps, state);
  return state;
}

/// By Richardson from Verlet's method; its own error, against the finer run, is checked below.
const State& reference() {
  static const State state = [] {
    const State coarse = end(VelocityVerlet(), 20000);
    State fine = end(VelocityVerlet(), 40000);
    fine.positions += (fine.positions - coarse.positions) / 3;
    fine.velocities += (fine.velocities - coarse.velocities) / 3;
    return fine;
  }();
  return state;
}

TEST(Reference, IsThatOfRungeKuttaToo) {
  // Two methods that share no code but the forces.
  const State other = end(RungeKutta4(), 4000);
  EXPECT_LT(farthest(other.positions, reference().positions), 1e-10);
  EXPECT_LT(farthest(other.velocities, reference().velocities), 1e-8);
}

template <typename Method>
class Trajectory : public ::testing::Test {};
TYPED_TEST_SUITE(Trajectory, EachMethod);

TYPED_TEST(Trajectory, ConvergesToTheReferenceAtItsOrder) {
  // omega_max is 163 rad/s. Order 1 shows only at the finest steps; the fourth order soon reaches
  // the reference's own error.
  const int steps = TypeParam::order == 1 ? 1000 : TypeParam::order == 2 ? 500 : 200;
  const State coarse = end(converged<TypeParam>(), steps);
  const State fine = end(converged<TypeParam>(), 2 * steps);
  const double error_x = (coarse.positions - reference().positions).norm();
  const double order_x = std::log2(error_x / (fine.positions - reference().positions).norm());
  const double order_v = std::log2((coarse.velocities - reference().velocities).norm() /
                                   (fine.velocities - reference().velocities).norm());
  this->RecordProperty("rms_error", std::to_string(error_x / 10));
  this->RecordProperty("order_position", std::to_string(order_x));
  this->RecordProperty("order_velocity", std::to_string(order_v));
  EXPECT_NEAR(order_x, TypeParam::order, 0.15);
  // Started at rest, symplectic Euler's path is Verlet's half a step late, its velocities are those
  // of half a step ago: they have second order here.
  const bool late = std::is_same_v<TypeParam, SymplecticEuler>;
  EXPECT_NEAR(order_v, late ? 2 : TypeParam::order, 0.15);
}

TYPED_TEST(Trajectory, AsShippedItIsNearTheReference) {
  // With the method's own parameters at 8 substeps of 90 frames: within a hundredth of the cloth.
  const State state = end(TypeParam(), static_cast<int>(8 * 90 * seconds));
  EXPECT_LT(farthest(state.positions, reference().positions), 1e-2);
}

TYPED_TEST(Trajectory, SameBitsTwice) {
  const State first = end(TypeParam(), 100);
  const State second = end(TypeParam(), 100);
  EXPECT_EQ(first.positions, second.positions);
  EXPECT_EQ(first.velocities, second.velocities);
}

TYPED_TEST(Trajectory, AMaterialChangedEachStepIsThatOfAFreshMethod) {
  // No factor, colour or history outlives its step: the same bits.
  ClothSpec spec = pinned2();
  State state = start_state(spec, make_grid(spec), 1);
  TypeParam method;
  for (int n = 0; n < 12; ++n) {
    // One change a step, then back, then the step itself.
    spec.material.ks = n % 2 == 0 ? 5000 : 700;
    spec.material.density = n % 3 == 0 ? 150 : 90;
    spec.material.damping = n % 5 == 0 ? 5.4 : 0;
    spec.material.springs = {true, n % 4 != 0, true};
    if (n == 8) spec.pinned = {{4, 4, ""}};
    const Cloth cloth = make_grid(spec);
    State fresh_state = state;
    const double h = n == 10 ? 1e-3 : 2e-3;
    TypeParam fresh;
    fresh.step(cloth, Loads(), h, fresh_state);
    method.step(cloth, Loads(), h, state);
    ASSERT_EQ(state.positions, fresh_state.positions) << n;
    ASSERT_EQ(state.velocities, fresh_state.velocities) << n;
  }
}

/// Impossible starts: in a point, on a line, scrambled, at springs without length.
struct Degenerate {
  const char* name;
  ClothSpec spec;
  Cloth cloth;
  State state;
};

std::vector<Degenerate> degenerate_starts() {
  std::vector<Degenerate> starts;
  const auto add = [&](const char* name, auto&& spoil) {
    Degenerate start{name, pinned2(), {}, {}};
    start.cloth = make_grid(start.spec);
    start.state = start_state(start.spec, start.cloth, 1);
    spoil(start);
    starts.push_back(start);
  };
  add("in a point", [](Degenerate& s) { s.state.positions.setConstant(0.5); });
  add("on a line", [](Degenerate& s) { s.state.positions.rightCols(2).setZero(); });
  add("in a plane", [](Degenerate& s) { s.state.positions.col(1) = s.state.positions.col(0); });
  add("scrambled", [](Degenerate& s) { s.state.positions = random_points(100, 0.5, 7); });
  add("two in one", [](Degenerate& s) { s.state.positions.row(55) = s.state.positions.row(54); });
  add("no rest length", [](Degenerate& s) {
    for (SpringRun& run : s.cloth.springs) run.rest_length = 0;
  });
  add("no stiffness", [](Degenerate& s) {
    for (SpringRun& run : s.cloth.springs) run.stiffness = 0;
  });
  add("all pinned", [](Degenerate& s) { s.cloth.inv_mass.setZero(); });
  add("no springs", [](Degenerate& s) { s.cloth.springs.clear(); });
  return starts;
}

TYPED_TEST(Trajectory, DegenerateStartsStayFinite) {
  // At steps inside the explicit limit, 2 / 163 s at rest, with room for the scramble.
  for (Degenerate& start : degenerate_starts()) {
    TypeParam method;
    for (int n = 0; n < 30; ++n) {
      method.step(start.cloth, Loads(), 2e-3, start.state);
      ASSERT_TRUE(start.state.positions.allFinite()) << start.name << ", step " << n;
      ASSERT_TRUE(start.state.velocities.allFinite()) << start.name << ", step " << n;
    }
    EXPECT_LT(max_speed(start.state), 1e3) << start.name;
  }
}

TYPED_TEST(Trajectory, ExtremesDivergeWhereTheoryHasItAndElsewhereFallAndHang) {
  // Unreasonable steps, stiffnesses and light weights, through the simulator.
  struct Extreme {
    double ks;
    double density;
    double damping;
  };
  for (const Extreme& e : {Extreme{1e12, 1e-6, 0}, Extreme{1e12, 150, 1e6}, Extreme{0, 1e-6, 0},
                           Extreme{1e9, 0.15, 5.4}, Extreme{1e-3, 1e9, 0}, Extreme{0, 150, 1e6}}) {
    SCOPED_TRACE(std::to_string(e.ks) + " N/m, " + std::to_string(e.density) + " kg/m^2");
    Scene scene;
    scene.cloth = pinned2();
    scene.cloth.columns = scene.cloth.rows = 6;
    scene.cloth.pinned = {{0, 0, ""}};
    scene.cloth.material.ks = e.ks;
    scene.cloth.material.density = e.density;
    scene.cloth.material.damping = e.damping;
    scene.simulation.method = TypeParam::name;
    scene.simulation.substeps = 2;
    Simulator simulator(scene);
    const double h = simulator.frame_duration() / 2;
    const bool is_unstable = h * omega_max_bound(simulator.cloth()) > TypeParam().stability_limit;
    bool has_diverged = false;
    try {
      for (int frame = 0; frame < 10; ++frame) {
        simulator.step();
        ASSERT_TRUE(simulator.state().positions.allFinite()) << frame;
        // Free points fall; taut ones of one pin swing down no faster.
        const double t = simulator.state().time;
        ASSERT_LT(max_speed(simulator.state()), 2 * 9.8 * t + 0.1) << frame;
      }
    } catch (const Diverged& error) {
      has_diverged = true;
      EXPECT_NE(std::string(error.what()).find(TypeParam::name), std::string::npos);
      EXPECT_TRUE(simulator.state().positions.allFinite());
    }
    // Where the rounding error of a spring's pull exceeds the weight of a point, no method is
    // exact.
    const double rounded = e.ks * 0.2 * std::numeric_limits<double>::epsilon();
    if (rounded > simulator.cloth().mass[0] * 9.8) continue;
    EXPECT_EQ(has_diverged, is_unstable);
  }
}

}  // namespace
}  // namespace clothsim::trajectory_test
