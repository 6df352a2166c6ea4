// Motion without spring forces: free fall, drag, and the conserved quantities of a free cloth.

#include <cmath>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "verification/testing.h"

namespace clothsim::free_motion_test {
namespace {

using namespace test;

const Loads no_gravity{Vector3::Zero()};
constexpr double g = 9.8;

/// A flat cloth in the xy-plane that turns about z through its middle at `spin` [rad/s].
State spinning(const ClothSpec& spec, const Cloth& cloth, double spin) {
  State state = start_state(spec, cloth, 1);
  const Eigen::RowVector3d middle = state.positions.colwise().mean();
  for (int i = 0; i < cloth.num_points(); ++i) {
    const Eigen::RowVector3d arm = state.positions.row(i) - middle;
    state.velocities.row(i) << -spin * arm.y(), spin * arm.x(), 0;
  }
  return state;
}

/// Share of g h^2 by which a method of two steps falls short: its first step is of order 1 and
/// h / 2 (g h) off, which x' = (4 x - x_last) / 3 turns into 3 / 2 of that. Zero for one-step
/// methods.
template <typename Method>
constexpr double start_up = std::is_same_v<Method, Bdf2> ? 0.75 : 0;

template <typename Method>
class FreeMotion : public ::testing::Test {};
TYPED_TEST_SUITE(FreeMotion, EachMethod);

TYPED_TEST(FreeMotion, FreeFallIsAParabola) {
  // z = z0 - g t^2 / 2 and v = -g t: exact for a method of order 2, else g t h / 2 off. The springs
  // stay at rest, so every point falls alike.
  const ClothSpec spec = square_spec(6);
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  const double h = 1e-3;
  const int steps = 500;
  const double t = h * steps;
  TypeParam method;
  run(method, cloth, Loads{}, h, steps, state);

  const double rounding = 1e-11;
  const double scheme = TypeParam::order == 1 ? g * t * h : start_up<TypeParam> * g * h * h;
  Points exact = cloth.rest_positions;
  exact.col(2).array() -= g * t * t / 2;
  EXPECT_LT(farthest(state.positions, exact), rounding + scheme);
  EXPECT_NEAR(state.velocities(7, 2), -g * t, rounding);
  EXPECT_LT(state.velocities.leftCols(2).norm(), rounding);
}

TYPED_TEST(FreeMotion, WhereGravityActsAloneAFallIsExact) {
  // z = z0 - g t^2 / 2 and v = -g t, in steps of a tenth of a second, too, where these are stable.
  const double longest = TypeParam::stability_limit < 10 ? 2e-3 : 0.1;
  const ClothSpec spec = square_spec(6);
  const Cloth cloth = make_grid(spec);
  for (const double h : {1e-3, longest}) {
    State state = start_state(spec, cloth, 1);
    TypeParam method;
    const int steps = static_cast<int>(std::lround(1 / h));
    run(method, cloth, Loads{{0, 0, -g}, true}, h, steps, state);
    Points exact = cloth.rest_positions;
    exact.col(2).array() -= g / 2;
    EXPECT_LT(farthest(state.positions, exact), 1e-10) << h;
    EXPECT_NEAR(state.velocities(7, 2), -g, 1e-10) << h;
  }
}

TYPED_TEST(FreeMotion, WhereGravityActsAloneAFallWithDragIsExactOrOfSecondOrder) {
  // z = -(g / c)(t - (1 - exp(-c t)) / c).
  constexpr bool is_second_order =
      TypeParam::order > 1 && !std::is_same_v<TypeParam, VelocityVerlet>;
  const double c = 5.4, t = 1;
  ClothSpec spec = square_spec(4);
  spec.material.damping = c;
  const Cloth cloth = make_grid(spec);
  const double way = (t + std::expm1(-c * t) / c) / c;
  for (const double h : {1e-3, 1e-2}) {
    State state = start_state(spec, cloth, 1);
    TypeParam method;
    run(method, cloth, Loads{{0, 0, -g}, true}, h, static_cast<int>(std::lround(t / h)), state);
    const double most = is_second_order ? g * c * c * h * h : 1e-10;
    EXPECT_NEAR(state.positions(5, 2), 1 - g * way, most) << h;
  }
}

TYPED_TEST(FreeMotion, FallWithDragNearsItsEndSpeed) {
  // m z'' = -m g - c m z': v = -(g / c)(1 - exp(-c t)). A symmetric split of drag and gravity
  // would make g / c off by the factor (c h / 2) / sinh(c h / 2) = 1 - (c h)^2 / 24 + ..., and z by
  // as much at most; order 1 by c h / 2.
  const double c = 5.4;
  const double h = 0.01;
  const int steps = 60;
  ClothSpec spec = square_spec(3);
  spec.material.damping = c;
  spec.material.ks = 0;
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  TypeParam method;
  run(method, cloth, Loads{}, h, steps, state);

  const double t = h * steps;
  const double end_speed = g / c;
  const double v = -end_speed * (1 - std::exp(-c * t));
  const double z = 1 - end_speed * (t - (1 - std::exp(-c * t)) / c);
  const double share = TypeParam::order == 1 ? c * h : c * c * h * h / 24 * 1.01;
  EXPECT_NEAR(state.velocities(4, 2), v, share * std::abs(v));
  EXPECT_NEAR(state.positions(4, 2), z, share * end_speed * t + start_up<TypeParam> * g * h * h);
}

/// Points that only drag of c [1/s] acts on.
ClothSpec drag_alone(double c) {
  ClothSpec spec = square_spec(4);
  spec.material.damping = c;
  spec.material.ks = 0;
  return spec;
}

TYPED_TEST(FreeMotion, DragAloneIsExactWhateverTheStep) {
  // v = v0 exp(-c t); nothing is left at 1e6 / s, where exp(-c h) is below the least number.
  for (const double c : {5.4, 1e6}) {
    const ClothSpec spec = drag_alone(c);
    const Cloth cloth = make_grid(spec);
    for (const double h : {1e-4, 1e-2, 0.5}) {
      State state = start_state(spec, cloth, 1);
      const Eigen::RowVector3d v0(3, -2, 1);
      state.velocities.rowwise() = v0;
      const int steps = static_cast<int>(std::lround(1 / h));
      TypeParam method;
      run(method, cloth, no_gravity, h, steps, state);
      for (int i = 0; i < cloth.num_points(); ++i) {
        EXPECT_LT((state.velocities.row(i) - v0 * std::exp(-c)).norm(), 1e-11) << "h " << h;
      }
    }
  }
}

TEST(FreeMotionVerlet, DragAloneMovesPointsExactly) {
  // x = x0 + v0 (1 - exp(-c t)) / c, for any step.
  const double c = 5.4;
  const ClothSpec spec = drag_alone(c);
  const Cloth cloth = make_grid(spec);
  for (const double h : {1e-4, 1e-2, 0.5}) {
    State state = start_state(spec, cloth, 1);
    const Eigen::RowVector3d v0(3, -2, 1);
    state.velocities.rowwise() = v0;
    VelocityVerlet method;
    run(method, cloth, no_gravity, h, static_cast<int>(std::lround(1 / h)), state);
    const Points exact = cloth.rest_positions.rowwise() + v0 * ((1 - std::exp(-c)) / c);
    EXPECT_LT(farthest(state.positions, exact), 1e-11) << "h " << h;
  }
}

TEST(FreeMotionVerlet, FallWithDragIsExactWhateverTheStep) {
  // z = -(g / c)(t - (1 - exp(-c t)) / c), v = -(g / c)(1 - exp(-c t)); c h on both sides of 0.01,
  // where the formula of the displacement changes, and so small that it all but drops out.
  const double t = 1;
  for (const double c : {5.4, 1.0, 1e-3, 1e-9}) {
    ClothSpec spec = square_spec(4);
    spec.material.damping = c;
    const Cloth cloth = make_grid(spec);
    const double gained = -std::expm1(-c * t) / c;
    const double way = c > 1e-6 ? (t - gained) / c : t * t / 2 - c * t * t * t / 6;
    for (const double h : {1e-4, 1e-2, 0.1, 0.5}) {
      State state = start_state(spec, cloth, 1);
      VelocityVerlet method;
      run(method, cloth, Loads{}, h, static_cast<int>(std::lround(t / h)), state);
      EXPECT_NEAR(state.positions(5, 2), cloth.rest_positions(5, 2) - g * way, 2e-11)
          << c << ' ' << h;
      EXPECT_NEAR(state.velocities(5, 2), -g * gained, 1e-11) << c << ' ' << h;
    }
  }
}

TYPED_TEST(FreeMotion, MomentumOfAFreeClothStays) {
  // Spring forces are equal and opposite: sum of m v stays, to the rounding of some 1e3 steps. XPBD
  // rounds positions, by 1e-16 m / 1e-3 s a step.
  const ClothSpec spec = square_spec(8, 500);
  const Cloth cloth = make_grid(spec);
  State state;
  state.positions = shaken(cloth, 0.05, 3);
  state.velocities = random_points(cloth.num_points(), 1, 4);
  const Vector3 before = momentum(cloth, state);
  TypeParam method;
  run(method, cloth, no_gravity, 1e-3, 1000, state);
  const double scale = cloth.mass.sum() * max_speed(state);
  const double rounding = std::is_same_v<TypeParam, Xpbd> ? 5e-12 : 1e-12;
  EXPECT_LT((momentum(cloth, state) - before).norm(), rounding * scale);
}

TEST(FreeMotionVerlet, AngularMomentumOfAFreeClothStays) {
  // A drift moves x along v, a kick acts along the springs: neither changes sum of m x cross v.
  const ClothSpec spec = square_spec(8, 500);
  const Cloth cloth = make_grid(spec);
  State state = spinning(spec, cloth, 10);
  state.positions += random_points(cloth.num_points(), 0.02, 3);
  state.velocities += random_points(cloth.num_points(), 1, 4);
  const Vector3 before = angular_momentum(cloth, state);
  VelocityVerlet method;
  run(method, cloth, no_gravity, 1e-3, 1000, state);
  EXPECT_LT((angular_momentum(cloth, state) - before).norm(), 1e-12 * before.norm());
}

/// A spinning cloth held together by its strain limit alone; its invariants after one turn or so.
struct Kept {
  double momentum;          // change, in mass times rim speed
  double angular_momentum;  // relative change
  int corrections = 0;
};

Kept spin_at_the_limit(double spin, double h) {
  // Springs of 5 N/m carry nothing: the limit holds m omega^2 r.
  ClothSpec spec = square_spec(10, 5);
  spec.origin = Vector3(-0.5, -0.5, 0);
  spec.material.strain_limit = 0.1;
  const Cloth cloth = make_grid(spec);
  State state = spinning(spec, cloth, spin);
  state.positions *= 1.1;
  state.velocities *= 1.1;
  state.velocities.rowwise() += Eigen::RowVector3d(0.3, -0.2, 0.1);
  const Vector3 p = momentum(cloth, state);
  const Vector3 l = angular_momentum(cloth, state);

  VelocityVerlet method;
  StrainLimit limit(cloth);
  const double displacement_factor = VelocityVerlet::displacement_factor(cloth.damping, h);
  const double solved = 4e-3 * cloth.springs.front().rest_length / 20;  // [m]
  Kept kept{};
  for (int n = 0; n < static_cast<int>(std::lround(1 / h)); ++n) {
    method.step(cloth, no_gravity, h, state);
    limit.warm_start(h, displacement_factor, state);
    const Points predicted = state.velocities;
    limit.prepare(cloth, displacement_factor, state);
    int passes = 0;
    while (limit.solve_pass(state.velocities) > solved && ++passes < 200) continue;
    state.positions += displacement_factor * h * (state.velocities - predicted);
    kept.corrections += limit.project_positions(cloth, 4e-3, 200, state.positions);
  }
  EXPECT_LT(worst_stretch(cloth, state.positions), 0.105);
  kept.momentum = (momentum(cloth, state) - p).norm() / (cloth.mass.sum() * max_speed(state));
  kept.angular_momentum = (angular_momentum(cloth, state) - l).norm() / l.norm();
  return kept;
}

TEST(StrainLimitSpin, MomentumAndAngularMomentumStay) {
  // Impulses along the springs, equal and opposite, where the step's kick acts: both stay to the
  // rounding of 1000 steps, and turning springs keep their length without repair.
  for (const double spin : {10.0, 20.0}) {
    const Kept kept = spin_at_the_limit(spin, 1e-3);
    EXPECT_EQ(kept.corrections, 0) << spin;
    EXPECT_LT(kept.momentum, 1e-12) << spin;
    EXPECT_LT(kept.angular_momentum, 1e-12) << spin;
  }
}

TEST(StrainLimitSpin, ASceneWithoutGravityKeepsMomentaAndGainsNoEnergy) {
  // Substeps and method of `auto`, with tension's inertia and repairs.
  for (const double density : {0.2, 1.0, 150.0}) {
    for (const bool limited : {false, true}) {
      Scene scene;
      scene.cloth = square_spec(10, 1000);
      scene.cloth.material.density = density;
      if (limited) scene.cloth.material.strain_limit = 0.1;
      scene.simulation.gravity.setZero();
      Simulator simulator(scene);
      const Cloth& cloth = simulator.cloth();
      simulator.set_state(spinning(scene.cloth, cloth, 10));
      const Vector3 before = angular_momentum(cloth, simulator.state());
      const double energy = kinetic_energy(cloth, simulator.state()) +
                            elastic_energy(cloth, simulator.state().positions);
      for (int frame = 0; frame < 180; ++frame) {
        simulator.step();
        const State& now = simulator.state();
        ASSERT_LT(kinetic_energy(cloth, now) + elastic_energy(cloth, now.positions), 1.01 * energy)
            << density << " kg/m^2, frame " << frame;
      }
      const Vector3 after = angular_momentum(cloth, simulator.state());
      EXPECT_LT((after - before).norm(), (limited ? 1e-3 : 1e-10) * before.norm()) << density;
    }
  }
}

TEST(StrainLimitSpin, RepairedLengthsKeepTheMomentum) {
  // A quarter of a radian a step: lengths slip past their tolerance and are repaired, which costs
  // angular momentum; linear momentum stays to rounding.
  const Kept kept = spin_at_the_limit(50, 5e-3);
  EXPECT_GT(kept.corrections, 0);
  EXPECT_LT(kept.momentum, 1e-11);
}

/// A way to fold, and the loss of angular momentum that is allowed, in sum of m r v.
struct Fold {
  const char* name;
  SelfCollision contact;
  bool strain_limit;
  double friction;
  double lost;
};

class FreeFold : public ::testing::TestWithParam<Fold> {};

TEST_P(FreeFold, KeepsItsMomentum) {
  const Fold& fold = GetParam();
  Scene scene;
  scene.cloth = square_spec(25);
  scene.cloth.self_collision = fold.contact;
  scene.cloth.friction = fold.friction;
  if (fold.strain_limit) scene.cloth.material.strain_limit = 0.1;
  scene.simulation.gravity.setZero();
  Simulator simulator(scene);
  const Cloth& cloth = simulator.cloth();

  // Both halves rise and close over the middle, askew, so that layers rub.
  State state = simulator.state();
  const Vector3 middle = state.positions.colwise().mean().transpose();
  double scale = 0;  // sum of m r v
  for (int i = 0; i < cloth.num_points(); ++i) {
    const double x = state.positions(i, 0) - middle.x();
    state.velocities.row(i) << -1.5 * x, 0.3 * x, 3 * std::abs(x);
    scale += cloth.mass[i] * (state.positions.row(i).transpose() - middle).norm() *
             state.velocities.row(i).norm();
  }
  simulator.set_state(state);
  const Vector3 p = momentum(cloth, state);
  const Vector3 l = angular_momentum(cloth, state);

  int contacts = 0;
  double lost = 0;
  for (int frame = 0; frame < 2 * 90; ++frame) {
    const StepReport report = simulator.step();
    contacts = std::max(contacts, report.contacts);
    ASSERT_EQ(report.held_back, 0) << frame;
    const State& now = simulator.state();
    ASSERT_LT((momentum(cloth, now) - p).norm(), 1e-12 * cloth.mass.sum() * max_speed(state));
    lost = std::max(lost, (angular_momentum(cloth, now) - l).norm() / scale);
    if (fold.contact == SelfCollision::surface) {
      ASSERT_EQ(count_intersections(cloth, now.positions), 0) << frame;
    }
  }
  EXPECT_GT(contacts, 5) << "it does not fold";
  RecordProperty("lost", std::to_string(1e6 * lost) + "e-6");
  EXPECT_LT(lost, fold.lost);
}

// Impulses of surfaces act along the normal at their contact: rounding is left. Repairs of the
// strain limit cost some, as above; friction costs the moment that would turn layers through their
// thickness; points push along the line on which they end the step, and overlaps are projected out.
INSTANTIATE_TEST_SUITE_P(
    Ways, FreeFold,
    ::testing::Values(Fold{"surface", SelfCollision::surface, false, 0, 1e-12},
                      Fold{"surface_limited", SelfCollision::surface, true, 0, 1e-5},
                      Fold{"surface_rubbing", SelfCollision::surface, true, 0.3, 1e-3},
                      Fold{"points", SelfCollision::points, false, 0, 1e-3},
                      Fold{"points_rubbing", SelfCollision::points, true, 0.3, 3e-3}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace clothsim::free_motion_test
