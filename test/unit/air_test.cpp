#include "clothsim/dynamics/air.h"

#include <cmath>

#include "verification/fabric_testing.h"

namespace clothsim::air_test {
namespace {

using namespace test;

/// The same forces, triangle by triangle.
Points plain_forces(const Cloth& cloth, const std::array<double, 2>& drag, const Vector3& wind,
                    const State& state) {
  Points forces = Points::Zero(cloth.num_points(), 3);
  for (const auto& [a, b, c] : cloth.triangles) {
    const Vector3 p = row(state.positions, a);
    const Vector3 area = (row(state.positions, b) - p).cross(row(state.positions, c) - p) / 2;
    if (area.norm() == 0) continue;
    const Vector3 n = area.normalized();
    const Vector3 w =
        wind - (row(state.velocities, a) + row(state.velocities, b) + row(state.velocities, c)) / 3;
    const Vector3 across = w.dot(n) * n;
    const Vector3 along = w - across;
    const Vector3 force = air_density / 2 * area.norm() *
                          (drag[0] * across.norm() * across + drag[1] * along.norm() * along);
    for (const int i : {a, b, c}) forces.row(i) += force.transpose() / 3;
  }
  return forces;
}

TEST(Air, EqualsThePlainLoop) {
  for (const auto& [columns, rows] : {std::pair(2, 2), std::pair(5, 3), std::pair(2, 9),
                                      std::pair(40, 37), std::pair(1, 5), std::pair(5, 1)}) {
    ClothSpec spec = square_spec(2);
    spec.columns = columns;
    spec.rows = rows;
    Cloth cloth = make_grid(spec);
    cloth.drag = {1.3, 0.4};
    State state{shaken(cloth, 0.1, 1), random_points(cloth.num_points(), 2, 2), 0};
    const Vector3 wind(3, -2, 1);
    const Points expected = plain_forces(cloth, cloth.drag, wind, state);
    AirForces air;
    for (const int threads : {1, 2}) {
      const Points forces = air.compute(cloth, wind, state, Workers(threads));
      EXPECT_LE(farthest(forces, expected), 1e-13 * (1 + expected.cwiseAbs().maxCoeff()));
    }
  }
}

TEST(Air, OnASquarePlateIsTheForceOfItsCoefficients) {
  // 1 m^2 in the plane z = 1, at rest: density / 2 c |w| w across and along.
  Cloth cloth = make_grid(square_spec(11));
  const State state{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  cloth.drag = {1.17, 0.02};
  AirForces air;
  const auto total = [&](const Vector3& wind) {
    return Vector3(air.compute(cloth, wind, state).colwise().sum().transpose());
  };
  EXPECT_NEAR(total({0, 0, 5}).z(), 0.6 * 1.17 * 25, 1e-12);
  EXPECT_NEAR(total({0, 0, -5}).z(), -0.6 * 1.17 * 25, 1e-12);
  EXPECT_NEAR(total({3, 4, 0}).norm(), 0.6 * 0.02 * 25, 1e-12);
  const Vector3 slanting = total({3, 0, 4});
  EXPECT_NEAR(slanting.z(), 0.6 * 1.17 * 16, 1e-12);
  EXPECT_NEAR(slanting.x(), 0.6 * 0.02 * 9, 1e-12);
  EXPECT_NEAR(slanting.y(), 0, 1e-12);
}

TEST(Air, IsNoneOnWhatMovesWithItAndOnWhatHasNoArea) {
  Cloth cloth = make_grid(square_spec(6));
  cloth.drag = {1, 1};
  AirForces air;
  State state{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  state.velocities.rowwise() += Eigen::RowVector3d(1, 2, 3);
  EXPECT_LT(air.compute(cloth, {1, 2, 3}, state).norm(), 1e-12);
  state.positions.setConstant(0.5);
  const Points forces = air.compute(cloth, {5, 5, 5}, state);
  EXPECT_TRUE(forces.allFinite());
  EXPECT_LT(forces.norm(), 1e-12);
}

TEST(Air, GustsAreBoundedDrawnFromTheSeedAndWithoutMean) {
  const Vector3 mean(2, 0, -1);
  Vector3 sum = Vector3::Zero(), square = Vector3::Zero();
  constexpr int samples = 20000;
  for (int i = 0; i < samples; ++i) {
    const Vector3 gust = wind_at(mean, {0.5, 3}, 0.05 * i) - mean;
    EXPECT_LE(gust.cwiseAbs().maxCoeff(), 0.5);
    sum += gust;
    square += gust.cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / samples, 0, 0.01);
    // Eight waves: a root mean square of most / sqrt(2 * 8), and more as amplitudes differ.
    EXPECT_NEAR(std::sqrt(square[axis] / samples), 0.5 / std::sqrt(16), 0.02);
  }
  EXPECT_EQ(wind_at(mean, {0.5, 3}, 7), wind_at(mean, {0.5, 3}, 7));
  EXPECT_NE(wind_at(mean, {0.5, 3}, 7), wind_at(mean, {0.5, 4}, 7));
  EXPECT_EQ(wind_at(mean, {0, 3}, 7), mean);
}

TEST(Air, LetsAFallingSheetReachItsTerminalVelocity) {
  // m g = density / 2 c A v^2. It falls flat: 1 m^2 of 0.2 kg, too stiff to bend.
  Scene scene;
  scene.cloth = fabric_spec(8, 8, 1.0 / 7, 1.0 / 7);
  scene.cloth.material.fabric->bending_stiffness = {10, 10};
  scene.simulation.wind = Vector3(0, 0, 0);
  Simulator simulator(scene);
  run(simulator, 3);
  const double expected = std::sqrt(0.2 * 9.8 / (0.6 * 1.17));
  const Points& v = simulator.state().velocities;
  EXPECT_NEAR(-v.col(2).mean(), expected, 0.01 * expected);
}

}  // namespace
}  // namespace clothsim::air_test
