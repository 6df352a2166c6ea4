// A cloth that crosses itself when its state is set: reported, and untangled on request.

#include "clothsim/constraints/untangle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "clothsim/geometry/intersections.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim::untangle_test {
namespace {

/// A towel of 0.4 m on the ground.
Scene towel() {
  Scene scene;
  scene.cloth.width = scene.cloth.height = 0.4;
  scene.cloth.columns = scene.cloth.rows = 25;
  scene.cloth.origin = {0, 0, 0.01};
  scene.cloth.thickness = 0.002;
  scene.cloth.material.density = 0.3;
  scene.cloth.self_collision = SelfCollision::surface;
  ColliderSpec ground;
  ground.name = "ground";
  ground.shape = Plane();
  scene.colliders = {ground};
  return scene;
}

/// Its right half folded onto the left one, `gap(u, y)` above it [m], u [m] away from the fold.
Points folded(const Simulator& simulator, const std::function<double(double, double)>& gap) {
  Points positions = simulator.cloth().rest_positions;
  for (int i = 0; i < positions.rows(); ++i) {
    const double u = positions(i, 0) - 0.2;
    if (u <= 0) continue;
    positions(i, 0) = 0.2 - u;
    positions(i, 2) += gap(u, positions(i, 1));
  }
  return positions;
}

/// A wave that takes a quarter of the towel through the other half, 16 mm deep.
Points crossed(const Simulator& simulator) {
  return folded(simulator, [](double u, double y) {
    return 0.004 + 0.02 * std::sin(2 * M_PI * y / 0.4) * u / 0.2;
  });
}

void set(const Points& positions, Simulator& simulator) {
  State state = simulator.state();
  state.positions = positions;
  simulator.set_state(state);
}

int crossings(const Simulator& simulator) {
  return count_intersections(simulator.cloth(), simulator.state().positions);
}

std::vector<MovingCollider> colliders_of(const Scene& scene) {
  return {scene.colliders.begin(), scene.colliders.end()};
}

TEST(Untangle, TakesAFoldApartThatCrossesItself) {
  const Scene scene = towel();
  const Simulator simulator(scene);
  Points positions = crossed(simulator);
  const Points before = positions;
  const int pairs = count_intersections(simulator.cloth(), positions);
  ASSERT_GT(pairs, 50);

  const Untangled result = untangle(simulator.cloth(), colliders_of(scene), positions);
  EXPECT_EQ(result.before, pairs);
  EXPECT_EQ(result.left, 0);
  EXPECT_EQ(count_intersections(simulator.cloth(), positions), 0);
  EXPECT_LT(longest_displacement(before, positions), 0.02);  // about as deep as it was
  EXPECT_GE(positions.col(2).minCoeff(), -1e-12);            // not into the ground
  // The wave's low part is above the other half again, and the rest is not below.
  const int high = 5 * 25 + 24, low = 18 * 25 + 24;  // of the free edge
  EXPECT_GT(positions(high, 2), 0.02);
  EXPECT_GT(positions(low, 2), positions(low - 24, 2));
}

TEST(Untangle, MovesNothingWhereNothingCrosses) {
  const Simulator simulator(towel());
  Points positions = folded(simulator, [](double, double) { return 0.004; });
  const Points before = positions;
  const Untangled result = untangle(simulator.cloth(), {}, positions);
  EXPECT_EQ(result.before, 0);
  EXPECT_EQ(positions, before);
}

/// Folds whose upper half waves, bulges or dips through the lower one, and noise of a camera.
TEST(Untangle, TakesRandomCrossingsApart) {
  const Scene scene = towel();
  const Simulator simulator(scene);
  int crossed = 0, apart = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 engine(seed);
    const auto draw = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(engine);
    };
    const double depth = draw(0.005, 0.012), phase = draw(0, 2 * M_PI), along = draw(0.1, 0.3);
    const double waves = std::floor(draw(1, 4));
    Points positions = folded(simulator, [&](double u, double y) {
      switch (seed % 3) {
        case 0:
          return 0.004 +
                 std::min(1.0, u / 0.03) * depth * std::sin(2 * M_PI * waves * y / 0.4 + phase);
        case 1:
          return 0.004 -
                 2 * depth * std::exp(-(std::pow(u - 0.1, 2) + std::pow(y - along, 2)) / 0.002);
        default:
          return 0.004 - depth * std::max(0.0, u - 0.14) / 0.06;  // the whole free edge
      }
    });
    for (double& x : positions.reshaped()) x += draw(-0.001, 0.001);

    const Untangled result = untangle(simulator.cloth(), colliders_of(scene), positions);
    crossed += result.before > 0;
    apart += count_intersections(simulator.cloth(), positions) == 0;
  }
  EXPECT_EQ(crossed, 20);
  EXPECT_GE(apart, 18);
}

TEST(Untangle, LeavesPinsWhereTheyAre) {
  Scene scene = towel();
  scene.cloth.pinned = {{24, 18, ""}, {0, 18, ""}};  // both in the crossing part
  const Simulator simulator(scene);
  Points positions = crossed(simulator);
  const Points before = positions;
  untangle(simulator.cloth(), {}, positions);
  for (const int pin : simulator.cloth().pinned) {
    EXPECT_EQ(positions.row(pin), before.row(pin)) << pin;
  }
}

TEST(Untangle, AsksWhetherItIsInterrupted) {
  const Simulator simulator(towel());
  Points positions = crossed(simulator);
  const Points before = positions;
  const Untangled result = untangle(simulator.cloth(), {}, positions, [] { return true; });
  EXPECT_EQ(result.left, result.before);
  EXPECT_EQ(positions, before);
}

TEST(GivenCrossings, AreToldUntilTheyAreGone) {
  Simulator simulator(towel());
  EXPECT_EQ(simulator.given_crossings(), 0);
  set(crossed(simulator), simulator);
  EXPECT_EQ(simulator.given_crossings(), crossings(simulator));
  ASSERT_GT(simulator.given_crossings(), 0);

  const StepReport report = simulator.step();
  EXPECT_EQ(report.crossings, crossings(simulator));
  EXPECT_TRUE(report.reasons.has(Reason::crosses_itself));
  EXPECT_NE(report.reasons.text().find(std::to_string(report.crossings) + " pairs of triangles"),
            std::string::npos);

  simulator.reset();
  EXPECT_EQ(simulator.given_crossings(), 0);
  EXPECT_FALSE(simulator.step().reasons.has(Reason::crosses_itself));
}

TEST(GivenCrossings, AreNoneOfAClothThatMayCrossItself) {
  Scene scene = towel();
  scene.cloth.self_collision = SelfCollision::off;
  Simulator simulator(scene);
  set(crossed(simulator), simulator);
  EXPECT_EQ(simulator.given_crossings(), 0);

  // From the change on, self contact is kept.
  LiveSpec live = live_values(simulator.scene());
  live.self_collision = SelfCollision::surface;
  simulator.set(live);
  EXPECT_EQ(simulator.given_crossings(), crossings(simulator));
  EXPECT_GT(simulator.given_crossings(), 0);
}

TEST(GivenCrossings, AreSavedAndRestored) {
  Simulator simulator(towel());
  const auto apart = simulator.save();
  set(crossed(simulator), simulator);
  const auto saved = simulator.save();
  const int pairs = simulator.given_crossings();
  simulator.restore(*apart);
  EXPECT_EQ(simulator.given_crossings(), 0);
  simulator.restore(*saved);
  EXPECT_EQ(simulator.given_crossings(), pairs);
}

TEST(GivenCrossings, AreTakenApartWhereTheSceneAsksForIt) {
  Scene scene = towel();
  scene.cloth.untangle = true;
  Simulator simulator(scene);
  set(crossed(simulator), simulator);
  EXPECT_EQ(simulator.given_crossings(), 0);
  for (int frame = 0; frame < 180; ++frame) {
    simulator.step();
    ASSERT_EQ(crossings(simulator), 0) << "in frame " << frame;
  }
}

TEST(GivenCrossings, AreTakenApartOnceAsked) {
  Simulator simulator(towel());
  set(crossed(simulator), simulator);
  const int pairs = simulator.given_crossings();
  const Untangled result = simulator.untangle();
  EXPECT_EQ(result.before, pairs);
  EXPECT_EQ(result.left, 0);
  EXPECT_EQ(simulator.given_crossings(), 0);
  EXPECT_EQ(simulator.step().crossings, 0);
}

TEST(GivenCrossings, ToLookForThemChangesNoBits) {
  const Scene scene = towel();
  Scene asks = scene;
  asks.cloth.untangle = true;
  Simulator one(scene), other(asks);
  const Points start = folded(one, [](double, double) { return 0.006; });
  set(start, one);
  set(start, other);
  for (int frame = 0; frame < 20; ++frame) {
    one.step();
    other.step();
  }
  EXPECT_EQ(one.state().positions, other.state().positions);
}

}  // namespace
}  // namespace clothsim::untangle_test
