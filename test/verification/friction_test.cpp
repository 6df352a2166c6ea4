// Coulomb friction against its exact cases: incline and belt.

#include <cmath>

#include "verification/testing.h"

namespace clothsim::friction_test {
namespace {

using namespace test;

constexpr double g = 9.8;

ColliderSpec plane(double friction, const Eigen::Quaterniond& orientation = {1, 0, 0, 0}) {
  ColliderSpec spec;
  spec.name = "plane";
  spec.shape = Plane{};
  spec.pose.orientation = orientation;
  spec.friction = friction;
  return spec;
}

/// A small cloth without drag that lies on the plane z = 0.
Scene lying(double friction) {
  Scene scene;
  scene.cloth = square_spec(5);
  scene.cloth.material.strain_limit = 0.1;
  scene.cloth.origin = Vector3(0, 0, surface_offset);
  scene.colliders = {plane(friction)};
  return scene;
}

/// Gravity in the frame of a plane tilted by `angle` about y.
Vector3 tilted_gravity(double angle) { return g * Vector3(std::sin(angle), 0, -std::cos(angle)); }

class Incline : public ::testing::TestWithParam<double> {};

TEST_P(Incline, SlipsJustBeyondCoulombsThresholdAndNotBelow) {
  // On a plane, and on the face of a box. Slips iff tan(angle) > mu: a millionth below, it rests to
  // rounding, a millionth above, it gains g (sin - mu cos) t.
  const double mu = GetParam();
  ColliderSpec box = plane(mu);
  box.shape = Cuboid{{4, 4, 1}};
  box.pose.position.z() = -0.5;
  for (const ColliderSpec& below : {plane(mu), box}) {
    for (const double share : {0.99, 1 - 1e-6, 1 + 1e-6, 1.01}) {
      SCOPED_TRACE(share);
      const double angle = std::atan(mu * share);
      Scene scene = lying(mu);
      scene.colliders = {below};
      scene.simulation.gravity = tilted_gravity(angle);
      Simulator simulator(scene);
      run(simulator, 1);
      const State& state = simulator.state();
      if (share < 1) {
        EXPECT_LT(farthest(state.positions, simulator.cloth().rest_positions), 1e-12);
        continue;
      }
      const double v = g * (std::sin(angle) - mu * std::cos(angle)) * state.time;
      EXPECT_LT((state.velocities.col(0).array() - v).abs().maxCoeff(), 1e-3 * v);
    }
  }
}

TEST_P(Incline, SlidesWithCoulombsAcceleration) {
  // a = g (sin(angle) - mu cos(angle)) at twice the threshold; x = a t^2 / 2.
  const double mu = GetParam();
  const double angle = std::atan(2 * mu);
  Scene scene = lying(mu);
  scene.simulation.gravity = tilted_gravity(angle);
  Simulator simulator(scene);
  run(simulator, 1);
  const double a = g * (std::sin(angle) - mu * std::cos(angle));
  const double t = simulator.state().time;
  const Points moved = simulator.state().positions - simulator.cloth().rest_positions;
  for (int i = 0; i < moved.rows(); ++i) {
    EXPECT_NEAR(simulator.state().velocities(i, 0), a * t, 0.01 * a * t);
    EXPECT_NEAR(moved(i, 0), a * t * t / 2, 0.01 * a * t * t / 2);
  }
  EXPECT_LT(moved.rightCols(2).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_P(Incline, PlaneTurnedInTheWorldActsAsGravityTurned) {
  // A chain that lies across a plane turned about its own line, y.
  const double mu = GetParam();
  const double angle = std::atan(2 * mu);
  Scene scene;
  scene.cloth = chain_spec(4, 0.1, 5000);
  scene.cloth.material.strain_limit = 0.1;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Vector3::UnitY()));
  scene.colliders = {plane(mu, turn)};
  scene.cloth.origin = surface_offset * (turn * Vector3::UnitZ());
  Simulator simulator(scene);
  run(simulator, 1);
  const double a = g * (std::sin(angle) - mu * std::cos(angle));
  const double t = simulator.state().time;
  const Vector3 downhill = turn * Vector3::UnitX();
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(simulator.state().velocities.row(i).dot(downhill), a * t, 0.01 * a * t);
  }
}

INSTANTIATE_TEST_SUITE_P(Coefficients, Incline, ::testing::Values(0.1, 0.3, 0.5, 1.0));

TEST(Belt, CarriesTheClothUpToItsOwnSpeed) {
  // Friction accelerates by mu g until the speeds agree: v = min(mu g t, V).
  const double mu = 0.3;
  const double speed = 2;
  Simulator simulator(lying(mu));
  for (int frame = 1; frame <= 90; ++frame) {
    Pose pose = simulator.collider_pose(0);
    pose.position.x() += speed * simulator.frame_duration();
    simulator.move_collider(0, pose);
    simulator.step();
    const double expected = std::min(mu * g * simulator.state().time, speed);
    for (int i = 0; i < simulator.cloth().num_points(); ++i) {
      ASSERT_NEAR(simulator.state().velocities(i, 0), expected, 0.01 * speed) << "frame " << frame;
    }
  }
  EXPECT_NEAR(simulator.state().velocities.col(0).mean(), speed, 1e-9);
}

TEST(Belt, TurntableCarriesTheClothRound) {
  // On a plane that turns with w, friction holds a point at radius r while w^2 r < mu g. A light
  // cloth is stiff against friction and turns as one: until it reaches w it slips by the angle
  // w^2 / (2 alpha), where alpha = mu g sum r / sum r^2.
  const double w = 1;
  const double mu = 0.5;
  Scene scene = lying(mu);
  scene.cloth.material.density = 1;
  scene.cloth.origin = Vector3(-0.5, -0.5, surface_offset);
  Simulator simulator(scene);
  for (int frame = 1; frame <= 90; ++frame) {
    Pose pose;
    pose.orientation = Eigen::AngleAxisd(w * frame * simulator.frame_duration(), Vector3::UnitZ());
    simulator.move_collider(0, pose);
    simulator.step();
  }
  const Points& rest = simulator.cloth().rest_positions;
  const Scalars radius = rest.leftCols(2).rowwise().norm();
  const double slip = w * w / (2 * mu * g * radius.sum() / radius.squaredNorm());
  const Eigen::AngleAxisd turn(w * simulator.state().time - slip, Vector3::UnitZ());
  for (int i = 0; i < rest.rows(); ++i) {
    const Vector3 x = simulator.state().positions.row(i).transpose();
    const Vector3 v = simulator.state().velocities.row(i).transpose();
    EXPECT_LT((x - turn * rest.row(i).transpose()).norm(), 0.02 * slip);
    EXPECT_LT((v - w * Vector3::UnitZ().cross(x)).norm(), 1e-3 * w);
  }
}

TEST(Belt, ASphereThatTurnsCarriesTheClothThatHangsOverItAlong) {
  // Wrapped round the top of a sphere that turns about z, the cloth goes round with it. Drag holds
  // it back, far less than friction can.
  const double w = 0.5;
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 21;
  scene.cloth.origin = Vector3(-0.5, -0.5, 0.31);
  scene.colliders = {{"ball", Sphere{0.3}, {}, 1, ""}};
  Simulator simulator(scene);
  run(simulator, 3);
  const auto step_round = [&](int frames) {
    for (int frame = 1; frame <= frames; ++frame) {
      Pose pose = simulator.collider_pose(0);
      pose.orientation =
          Eigen::AngleAxisd(w * simulator.frame_duration(), Vector3::UnitZ()) * pose.orientation;
      simulator.move_collider(0, pose);
      simulator.step();
    }
  };
  step_round(180);
  const Points before = simulator.state().positions;
  step_round(180);
  const Eigen::AngleAxisd turn(2 * w, Vector3::UnitZ());  // of two seconds
  int lying = 0;
  for (int i = 0; i < before.rows(); ++i) {
    const Vector3 x = before.row(i).transpose();
    if (x.norm() > 0.31 || x.z() < 0.2) continue;
    ++lying;
    EXPECT_LT((simulator.state().positions.row(i).transpose() - turn * x).norm(), 0.01);
  }
  EXPECT_GT(lying, 20);
}

}  // namespace
}  // namespace clothsim::friction_test
