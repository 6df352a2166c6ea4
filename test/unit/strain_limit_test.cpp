#include "clothsim/constraints/strain_limit.h"

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "verification/testing.h"

namespace clothsim::strain_limit_test {
namespace {

using namespace test;

constexpr double limit = 0.1;
constexpr double displacement_factor = 0.5;
constexpr double h = 1e-3;

ClothSpec limited(ClothSpec spec) {
  spec.material.strain_limit = limit;
  return spec;
}

/// Largest rate [1/s] at which a spring over its limit still lengthens, of its rest length.
double worst_rate(const Cloth& cloth, const State& state) {
  double worst = -1e300;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Eigen::RowVector3d d = state.positions.row(b) - state.positions.row(a);
    if (d.norm() <= (1 + limit) * run.rest_length) return;
    const double rate = d.normalized().dot(state.velocities.row(b) - state.velocities.row(a));
    worst = std::max(worst, rate / run.rest_length);
  });
  return worst;
}

TEST(StrainLimit, TakesTheElongationOutOfTheVelocities) {
  // Springs over their limit, all moving: after enough sweeps none lengthens, and momentum is the
  // same.
  const Cloth cloth = make_grid(limited(square_spec(6)));
  State state{1.12 * cloth.rest_positions, random_points(36, 1, 3), 0};
  EXPECT_GT(worst_rate(cloth, state), 1);
  const Eigen::RowVector3d momentum = state.velocities.colwise().sum();
  const double energy = state.velocities.squaredNorm();

  StrainLimit strain_limit(cloth);
  strain_limit.warm_start(h, 0, state);
  strain_limit.prepare(cloth, 0, state);  // along the current directions of the springs
  double residual = 1;
  int passes = 0;
  while (residual > 1e-12 && passes < 50000) {
    residual = strain_limit.solve_pass(state.velocities);
    ++passes;
  }
  EXPECT_LE(residual, 1e-12);
  EXPECT_LT(worst_rate(cloth, state), 1e-6);
  EXPECT_LT((state.velocities.colwise().sum() - momentum).norm(), 1e-12);
  EXPECT_LT(state.velocities.squaredNorm(), energy) << "impulses without restitution take energy";
}

TEST(StrainLimit, LeavesSlackClothAlone) {
  const Cloth cloth = make_grid(limited(square_spec(6)));
  State state{1.05 * cloth.rest_positions, random_points(36, 1, 3), 0};
  const State before = state;
  StrainLimit strain_limit(cloth);
  strain_limit.warm_start(h, displacement_factor, state);
  strain_limit.prepare(cloth, displacement_factor, state);
  EXPECT_EQ(strain_limit.solve_pass(state.velocities), 0);
  EXPECT_EQ(strain_limit.project_positions(cloth, 1e-6, 100, state.positions), 0);
  EXPECT_EQ(state.positions, before.positions);
  EXPECT_EQ(state.velocities, before.velocities);
}

TEST(StrainLimit, LooksAtSlackSpringsAgainBeforeTheyReachIt) {
  // Points that fly apart: a limit that knows the largest velocity changes by others acts from the
  // same step on, to the last bit, as one that checks all springs in each step.
  const Cloth cloth = make_grid(limited(square_spec(6)));
  const auto end_of = [&](bool is_told) {
    StrainLimit strain_limit(cloth);
    State state{cloth.rest_positions, random_points(36, 1, 3), 0};
    const Points thrown = state.velocities;
    if (is_told) strain_limit.begin_frame(0);
    int free_steps = 0;
    for (int step = 0; step < 1000; ++step) {
      state.positions += h / 10 * state.velocities;
      strain_limit.warm_start(h / 10, 0, state);
      strain_limit.prepare(cloth, 0, state);
      while (strain_limit.solve_pass(state.velocities) > 1e-12) continue;
      free_steps += state.velocities == thrown;
    }
    EXPECT_GT(free_steps, 100);
    EXPECT_LT(free_steps, 900);
    return state;
  };
  const State looked = end_of(false), told = end_of(true);
  EXPECT_EQ(told.positions, looked.positions);
  EXPECT_EQ(told.velocities, looked.velocities);
}

TEST(StrainLimit, AKickThatContactIsYetToAnswerIsNoTurn) {
  // A spring at its limit, at rest when the step began, one end now thrown across it: it must not
  // be shortened. A spring that does turn is, at h v^2 / 2 l.
  const Cloth cloth = make_grid(limited(chain_spec(2, 1, 5000)));
  const auto rate_after = [&](const Points& before) {
    State state{1.1001 * cloth.rest_positions, Points::Zero(2, 3), 0};
    state.velocities(1, 0) = 20;
    StrainLimit strain_limit(cloth);
    strain_limit.warm_start(h, 0, state);
    strain_limit.prepare(cloth, 0, state, {}, &before);
    for (int i = 0; i < 5; ++i) strain_limit.solve_pass(state.velocities);
    return state.velocities(1, 1) - state.velocities(0, 1);
  };
  const double of_excess = -0.1;  // [m/s] for its 1e-4 m over the limit
  Points before = Points::Zero(2, 3);
  EXPECT_LE(rate_after(before), 0);
  EXPECT_GT(rate_after(before), of_excess);
  const double turning = h * 20 * 20 / (2 * 1.1);
  before.row(1) << 20, 2 * turning, 0;  // it lengthens
  EXPECT_NEAR(rate_after(before), -turning, 0.01);
}

TEST(StrainLimit, ImpulsesOnlyPull) {
  // A spring over its limit whose ends already approach fast enough is not held back.
  const Cloth cloth = make_grid(limited(chain_spec(2, 1, 5000)));
  State state{1.2 * cloth.rest_positions, Points::Zero(2, 3), 0};
  state.velocities(1, 1) = -1000;
  StrainLimit strain_limit(cloth);
  strain_limit.warm_start(h, displacement_factor, state);
  strain_limit.prepare(cloth, displacement_factor, state);
  strain_limit.solve_pass(state.velocities);
  EXPECT_EQ(state.velocities(1, 1), -1000);
}

TEST(StrainLimit, KeptImpulsesCarryAHangingWeight) {
  // A mass on a string at its limit: after some steps the warm-started impulse m g h alone holds
  // it, so a sweep changes nothing. Over a step, gravity h g from its middle and the impulse
  // against it leave velocity and position unchanged.
  ClothSpec spec = limited(chain_spec(2, 1, 0, Orientation::vertical));
  spec.pinned = {{0, 1, ""}};
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, Points::Zero(2, 3), 0};
  state.positions(0, 2) = 1 - 1.1;
  VelocityVerlet method;
  StrainLimit strain_limit(cloth);
  double residual = 1;
  for (int step = 0; step < 100; ++step) {
    method.step(cloth, Loads{}, h, state);
    strain_limit.warm_start(h, displacement_factor, state);
    const Points predicted = state.velocities;
    strain_limit.prepare(cloth, displacement_factor, state);
    residual = strain_limit.solve_pass(state.velocities);
    state.positions += displacement_factor * h * (state.velocities - predicted);
    strain_limit.project_positions(cloth, 1e-6, 100, state.positions);
  }
  EXPECT_LT(residual, 1e-6 * 9.8 * h * h);
  EXPECT_NEAR(state.velocities(0, 2), 0, 1e-6 * 9.8 * h);
  EXPECT_NEAR(state.positions(0, 2), -0.1, 1e-6);

  // Without the warm start nothing holds.
  strain_limit.reset();
  method.step(cloth, Loads{}, h, state);
  strain_limit.warm_start(h, displacement_factor, state);
  EXPECT_NEAR(state.velocities(0, 2), -9.8 * h, 1e-5 * 9.8 * h);
}

TEST(StrainLimit, SolvingAloneIsSweepingAndMoving) {
  // solve() gives the result of plain passes; the points move by the changes of velocities.
  ClothSpec spec = limited(square_spec(8));
  spec.pinned = {{0, 0, ""}, {7, 0, ""}};
  const Cloth cloth = make_grid(spec);
  StrainLimit alone(cloth);
  VelocityVerlet method;
  State a{1.05 * cloth.rest_positions, random_points(64, 1, 3), 0};
  for (const int pin : cloth.pinned) a.velocities.row(pin).setZero();
  constexpr double enough = 1e-11;
  int repairs = 0;
  for (int step = 0; step < 60; ++step) {
    method.step(cloth, Loads{}, h, a);
    alone.warm_start(h, displacement_factor, a);
    const State predicted = a;
    StrainLimit by_passes = alone;
    const int passes = alone.solve(cloth, displacement_factor, enough, 4, 2000, a).count;
    EXPECT_GE(passes, 4);
    EXPECT_LT(passes, 2000) << step;
    const Points moved =
        predicted.positions + displacement_factor * h * (a.velocities - predicted.velocities);
    ASSERT_LT((a.positions - moved).cwiseAbs().maxCoeff(), 1e-15) << step;

    State b = predicted;
    by_passes.prepare(cloth, displacement_factor, b);
    int plain = 0;
    while (by_passes.solve_pass(b.velocities) > enough && plain < 20000) ++plain;
    ASSERT_LT(h * (a.velocities - b.velocities).cwiseAbs().maxCoeff(), 1000 * enough) << step;

    // The record of its own moves lets it skip no repair that is needed.
    b.positions = a.positions;
    const int needed = by_passes.project_positions(cloth, 1e-3, 100, b.positions);
    EXPECT_EQ(alone.project_positions(cloth, 1e-3, 100, a.positions), needed) << step;
    EXPECT_LE(needed == 100 ? 0 : worst_stretch(cloth, a.positions), limit + 1e-3 + 1e-12);
    repairs += needed;
  }
  EXPECT_GT(repairs, 0) << "the scene asks for none";
}

TEST(StrainLimit, PassesAreAsManyAsAChainIsLong) {
  // A pull at the end of a chain reaches the other end after as many plain passes as the square of
  // its springs; with momentum after as many as their number.
  const auto passes = [](int springs, bool plain) {
    ClothSpec spec = limited(chain_spec(springs + 1, 1, 0, Orientation::vertical));
    spec.pinned = {{0, springs, ""}};
    const Cloth cloth = make_grid(spec);
    State state{(1.1 + 1e-9) * cloth.rest_positions, Points::Zero(springs + 1, 3), 0};
    StrainLimit strain_limit(cloth);
    VelocityVerlet().step(cloth, Loads{}, h, state);
    strain_limit.warm_start(h, displacement_factor, state);
    constexpr double enough = 1e-9;
    if (!plain) {
      return strain_limit.solve(cloth, displacement_factor, enough, 1, 100000, state).count;
    }
    strain_limit.prepare(cloth, displacement_factor, state);
    int count = 1;
    while (strain_limit.solve_pass(state.velocities) > enough && count < 100000) ++count;
    return count;
  };
  for (const int springs : {20, 40, 80}) {
    EXPECT_LT(passes(springs, false), 8 * springs);
    EXPECT_GT(passes(springs, true), springs * springs / 2);
  }
}

TEST(StrainLimit, MomentumGoesOnFromStepToStep) {
  // The same step over and over, with few passes each, until the chain stands still. For n springs
  // that takes 2.0 n^2 passes with momentum within each step's six passes alone, and 2.9 n^2 with
  // one pass a step, which has none.
  const auto passes = [](int springs, int a_step) {
    ClothSpec spec = limited(chain_spec(springs + 1, 1, 0, Orientation::vertical));
    spec.pinned = {{0, springs, ""}};
    const Cloth cloth = make_grid(spec);
    StrainLimit strain_limit(cloth);
    for (int count = a_step;; count += a_step) {
      State state{(1.1 + 1e-9) * cloth.rest_positions, Points::Zero(springs + 1, 3), 0};
      VelocityVerlet().step(cloth, Loads{}, h, state);
      strain_limit.warm_start(h, displacement_factor, state);
      strain_limit.solve(cloth, displacement_factor, 0, a_step, a_step, state);
      if (h * longest_row(state.velocities) < 1e-8 || count > 100000) return count;
    }
  };
  for (const int springs : {20, 40, 80}) {
    EXPECT_LT(passes(springs, 6), 1.3 * springs * springs);
    EXPECT_GT(passes(springs, 1), 2.5 * springs * springs);
  }
}

TEST(StrainLimit, CorrectShortensToItsTolerance) {
  // From far over the limit; pins hold, the centre of mass of a free cloth stays.
  const double tolerance = 1e-4;
  for (const bool pinned : {false, true}) {
    ClothSpec spec = limited(square_spec(8));
    if (pinned) spec.pinned = {{0, 0, ""}, {7, 0, ""}};
    const Cloth cloth = make_grid(spec);
    State state{shaken(cloth, 0.03, 4), Points::Zero(64, 3), 0};
    ASSERT_GT(worst_stretch(cloth, state.positions), 0.2);
    const Points before = state.positions;
    StrainLimit strain_limit(cloth);
    const int passes = strain_limit.project_positions(cloth, tolerance, 20000, state.positions);
    EXPECT_GT(passes, 0);
    EXPECT_LE(worst_stretch(cloth, state.positions), limit + tolerance + 1e-12);
    const Points moved = state.positions - before;
    if (pinned) {
      EXPECT_EQ(moved.row(0).norm() + moved.row(7).norm(), 0);
    } else {
      EXPECT_LT(moved.colwise().sum().norm(), 1e-13);
    }
  }
}

TEST(StrainLimit, CorrectStopsAtItsSweepsAndSaysSo) {
  const Cloth cloth = make_grid(limited(square_spec(8)));
  State state{1.5 * cloth.rest_positions, Points::Zero(64, 3), 0};
  StrainLimit strain_limit(cloth);
  EXPECT_EQ(strain_limit.project_positions(cloth, 1e-6, 3, state.positions), 3);
  EXPECT_GT(worst_stretch(cloth, state.positions), limit);
}

TEST(StrainLimit, DegenerateSpringsGiveNoNan) {
  // Coincident points have no direction; a spring between two pins cannot be shortened.
  ClothSpec spec = limited(square_spec(4));
  spec.pinned = {{0, 0, ""}, {1, 0, ""}};
  const Cloth cloth = make_grid(spec);
  for (const double scale : {0.0, 2.0}) {
    State state{scale * cloth.rest_positions, random_points(16, 1, 1), 0};
    state.velocities.topRows(2).setZero();
    state.positions.row(9) = state.positions.row(10);
    StrainLimit strain_limit(cloth);
    for (int step = 0; step < 3; ++step) {
      strain_limit.warm_start(h, displacement_factor, state);
      strain_limit.prepare(cloth, displacement_factor, state);
      strain_limit.solve_pass(state.velocities);
      strain_limit.project_positions(cloth, 1e-3, 50, state.positions);
    }
    EXPECT_TRUE(state.positions.allFinite());
    EXPECT_TRUE(state.velocities.allFinite());
    EXPECT_EQ(state.velocities.topRows(2).norm(), 0);
  }
}

TEST(StrainLimit, ZeroLimitIsInextensible) {
  ClothSpec spec = square_spec(5);
  spec.material.strain_limit = 0.0;
  const Cloth cloth = make_grid(spec);
  State state{1.02 * cloth.rest_positions, Points::Zero(25, 3), 0};
  StrainLimit strain_limit(cloth);
  strain_limit.project_positions(cloth, 1e-4, 20000, state.positions);
  EXPECT_LE(worst_stretch(cloth, state.positions), 1e-4 + 1e-12);
}

TEST(StrainLimit, RepairsLeaveNoSpringOverItsLimitWhereverTheyLead) {
  // A few points far off, in a cloth of many patches: repairs spread from there, and each spring
  // that they lengthen must be found.
  ClothSpec spec;
  spec.columns = 90;
  spec.rows = 40;
  spec.material.strain_limit = 0.02;
  const Cloth cloth = make_grid(spec);
  const double tolerance = 0.004;
  Points positions = 1.02 * cloth.rest_positions;
  for (const int point : {5, 1000, 1001, 2345, 3599}) positions.row(point).z() += 0.012;
  const Points start = positions;

  StrainLimit strain_limit(cloth);
  const int passes = strain_limit.project_positions(cloth, tolerance, 5000, positions);
  EXPECT_GT(passes, 10);
  EXPECT_LT(passes, 5000);
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double length = (positions.row(b) - positions.row(a)).norm();
    EXPECT_LE(length, (1.02 + tolerance) * run.rest_length * (1 + 1e-12)) << a << ' ' << b;
  });
  const auto moved = (positions - start).rowwise().norm();
  EXPECT_GT((moved.array() > 0).count(), 10);
  EXPECT_LT((moved.array() > 0).count(), cloth.num_points() / 2) << "not a local repair";
}

}  // namespace
}  // namespace clothsim::strain_limit_test
