// Cloth so stiff and light that its springs need many more steps than its motion does: steps reuse
// the near pairs of earlier steps, which must have no effect on the result.

#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::stiff_light_test {
namespace {

using namespace test;

/// A towel that falls from upright: 0.5 m, 0.3 kg/m^2.
Scene towel(int side, double thickness) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.width = scene.cloth.height = 0.5;
  scene.cloth.material.density = 0.3;
  scene.cloth.material.ks = 1000;
  scene.cloth.thickness = thickness;
  scene.cloth.self_collision = SelfCollision::surface;
  return scene;
}

/// Points along a side, half its thickness [m] and a seed.
class Towel : public ::testing::TestWithParam<std::tuple<int, double, std::uint64_t>> {};

TEST_P(Towel, FoldsWithoutACrossingAndRests) {
  const auto& [side, thickness, seed] = GetParam();
  Scene scene = towel(side, thickness);
  scene.simulation.seed = seed;
  Simulator simulator(scene);
  double stretch = 0, lowest = 0, speed = 1;
  while (simulator.state().time < 2 || (speed > 1e-3 && simulator.state().time < 8)) {
    simulator.step();
    const Points& x = simulator.state().positions;
    ASSERT_EQ(count_intersections(simulator.cloth(), x), 0) << simulator.state().time;
    stretch = std::max(stretch, worst_stretch(simulator.cloth(), x));
    lowest = std::min(lowest, x.col(2).minCoeff());
    speed = rms_velocity(simulator.state());
  }
  EXPECT_LT(speed, 1e-3);
  EXPECT_LT(stretch, 0.105);
  EXPECT_EQ(lowest, 0) << "in the ground";
  EXPECT_EQ(deepest_penetration(simulator), 0);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Towel,
                         ::testing::Values(std::tuple(30, 1e-3, 1), std::tuple(30, 5e-4, 2),
                                           std::tuple(40, 1e-3, 3), std::tuple(40, 5e-4, 4),
                                           std::tuple(50, 1e-3, 5)));

TEST(StiffLight, ATowelGoesOnToTheSameBitsFromItsMemoryAndWithTwoThreads) {
  Scene scene = towel(30, 1e-3);
  Simulator first(scene);
  run(first, 0.6);
  Simulator second(scene);
  second.set_state(first.state(), first.memory());
  scene.simulation.threads = 2;
  Simulator third(scene);
  third.set_state(first.state(), first.memory());
  run(first, 0.3);
  run(second, 0.3);
  run(third, 0.3);
  EXPECT_EQ(first.state().positions, second.state().positions);
  EXPECT_EQ(first.state().velocities, second.state().velocities);
  EXPECT_EQ(first.state().positions, third.state().positions);
  EXPECT_EQ(first.state().velocities, third.state().velocities);
}

/// Shape for the cloth to fall on; its contacts involve points alone.
class OnSmoothShapes : public ::testing::TestWithParam<ColliderSpec> {};

TEST_P(OnSmoothShapes, ItMovesAsWithASearchInEachStep) {
  // Points alone touch: one pass solves them, and with named substeps each step searches.
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 20;
  scene.cloth.width = scene.cloth.height = 0.4;
  scene.cloth.origin = {-0.2, -0.2, 0.02};
  scene.cloth.material.density = 0.3;
  scene.cloth.material.ks = 1000;
  scene.cloth.material.strain_limit.reset();
  scene.colliders = {GetParam()};
  Simulator seldom(scene);
  const int substeps = seldom.step().substeps;
  seldom.reset();
  scene.simulation.method = "verlet";
  scene.simulation.substeps = substeps;
  Simulator always(scene);
  ASSERT_GT(substeps, 40);
  for (int frame = 0; frame < 45; ++frame) {
    if (seldom.step().substeps != always.step().substeps) break;
    ASSERT_LT(farthest(seldom.state().positions, always.state().positions), 1e-9) << frame;
  }
  EXPECT_GT(seldom.state().time, 0.09) << "it fell for 64 ms";
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, OnSmoothShapes,
    ::testing::Values(ColliderSpec{"ground", Plane{}, {}, 0.5, ""},
                      ColliderSpec{"ball", Sphere{1}, {{0, 0, -1}, {1, 0, 0, 0}}, 0.3, ""}));

/// Density [kg/m^2], wind [m/s], and distance of the ball [m].
class BlownAgainstABall : public ::testing::TestWithParam<std::tuple<double, double, double>> {};

TEST_P(BlownAgainstABall, ItsTrianglesStopThere) {
  // At rest as the frame begins, and too far away to reach the ball at that speed. The ball is
  // small enough to pass between points.
  const auto& [density, wind, distance] = GetParam();
  for (const double radius : {0.001, 0.003, 0.01}) {
    Scene scene;
    scene.cloth.columns = scene.cloth.rows = 14;
    scene.cloth.width = scene.cloth.height = 0.52;
    scene.cloth.orientation = Orientation::vertical;
    scene.cloth.origin = {-0.253, 0, -0.249};  // the ball is before the inside of a triangle
    scene.cloth.material.density = density;
    scene.cloth.material.ks = 50000;
    scene.simulation.gravity.setZero();
    scene.simulation.wind = Vector3(0, wind, 0);
    scene.colliders = {ColliderSpec{"ball", Sphere{radius}, {}, 0.3, ""}};
    scene.colliders[0].pose.position.y() = distance + radius;
    Simulator simulator(scene);
    for (int frame = 0; frame < 4; ++frame) {
      simulator.step();
      EXPECT_EQ(deepest_penetration(simulator), 0) << radius << ' ' << frame;
      const Points& x = simulator.state().positions;
      // Corner of the cell about the ball.
      EXPECT_LT(x(6 * 14 + 6, 1), distance + radius + 0.06) << radius << ' ' << frame;
    }
    EXPECT_GT(simulator.state().positions.col(1).maxCoeff(), distance + 2 * radius)
        << "it has not come there";
  }
}

INSTANTIATE_TEST_SUITE_P(Gusts, BlownAgainstABall,
                         ::testing::Combine(::testing::Values(0.05, 0.2),
                                            ::testing::Values(10.0, 30.0),
                                            ::testing::Values(0.006, 0.02, 0.045)));

}  // namespace
}  // namespace clothsim::stiff_light_test
