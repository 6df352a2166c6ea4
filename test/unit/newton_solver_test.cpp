// The implicit solver and its parts.

#include "clothsim/dynamics/newton_solver.h"

#include <cmath>

#include "algebra.h"
#include "clothsim/dynamics/hessian.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/spring_system.h"
#include "clothsim/dynamics/springs.h"
#include "verification/testing.h"

namespace clothsim::newton_solver_test {
namespace {

using namespace test;

ClothSpec pinned_spec(int columns, int rows) {
  ClothSpec spec = square_spec(columns);
  spec.rows = rows;
  spec.pinned = {{0, 0, ""}, {columns - 1, rows - 1, ""}};
  return spec;
}

/// m / h^2 at free points.
Scalars weights_of(const Cloth& cloth, double h) {
  return (cloth.inv_mass.array() > 0).select(cloth.mass.array() / (h * h), 0);
}

Points free_points(const Cloth& cloth, Points points) {
  for (const int pin : cloth.pinned) points.row(pin).setZero();
  return points;
}

TEST(IncrementalPotential, GradientIsItsDerivative) {
  const Cloth cloth = make_grid(pinned_spec(4, 5));
  const Scalars weights = weights_of(cloth, 0.01);
  const Points y = shaken(cloth, 0.05, 1);
  const Points d = free_points(cloth, random_points(20, 0.02, 2));
  Points gradient(20, 3);
  potential_gradient(cloth, weights, y + d, d, gradient);
  for (const int pin : cloth.pinned) EXPECT_EQ(gradient.row(pin).norm(), 0);

  // Central differences are off by e^2 / 6 of the third derivative, k / L0 at most, and rounding.
  const double e = 1e-5;
  for (int seed = 3; seed < 13; ++seed) {
    const Points direction = free_points(cloth, random_points(20, 1, static_cast<unsigned>(seed)));
    const double slope = (incremental_potential(cloth, weights, y, d + e * direction) -
                          incremental_potential(cloth, weights, y, d - e * direction)) /
                         (2 * e);
    EXPECT_NEAR(slope, gradient.cwiseProduct(direction).sum(), 1e-6 * gradient.norm());
  }
}

/// The whole matrix of a system of springs with 3 x 3 blocks, assembled entry by entry.
Eigen::MatrixXd dense_matrix(const Cloth& cloth, const Points& x, double weight) {
  Eigen::MatrixXd matrix = weight * Eigen::MatrixXd::Identity(3 * x.rows(), 3 * x.rows());
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Vector3 d = x.row(b) - x.row(a);
    const Eigen::Matrix3d block = spring_hessian(run.stiffness, run.rest_length, d, 0);
    matrix.block<3, 3>(3 * a, 3 * a) += block;
    matrix.block<3, 3>(3 * b, 3 * b) += block;
    matrix.block<3, 3>(3 * a, 3 * b) -= block;
    matrix.block<3, 3>(3 * b, 3 * a) -= block;
  });
  return matrix;
}

/// The system of a Newton step, by springs of a cloth shaken by 5 cm.
void set_up(const Cloth& cloth, double weight, SpringSystem& system) {
  const Points x = shaken(cloth, 0.05, 1);
  system.begin(cloth);
  for (int i = 0; i < cloth.num_points(); ++i) {
    system.add_to_point(i, weight * Matrix3::Identity());
  }
  int id = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Vector3 d = x.row(b) - x.row(a);
    system.add_pair(id++, a, b, spring_hessian(run.stiffness, run.rest_length, d, 0));
  });
}

TEST(SpringSystem, SolvesWhatADenseMatrixSolves) {
  // Also when used again for a cloth with other springs, of as many points.
  SpringSystem system;
  std::vector<ClothSpec> specs = {square_spec(5), square_spec(5), square_spec(3)};
  specs[1].material.springs = {true, false, true};
  specs[2].columns = 12;
  specs[2].rows = 2;
  for (const ClothSpec& spec : specs) {
    const Cloth cloth = make_grid(spec);
    const int n = cloth.num_points();
    const double weight = 3;
    set_up(cloth, weight, system);
    const Points rhs = random_points(n, 1, 2);
    const Eigen::MatrixXd matrix = dense_matrix(cloth, shaken(cloth, 0.05, 1), weight);
    const Eigen::VectorXd expected = solve(matrix, rhs.transpose().reshaped());
    Points by_factors, by_gradients, either;
    ASSERT_TRUE(system.solve_by_factors(rhs, by_factors));
    EXPECT_LT((by_factors.transpose().reshaped() - expected).norm(), 1e-9 * expected.norm());
    ASSERT_TRUE(system.solve_by_gradients(rhs, 0, 1000, by_gradients));
    const Eigen::VectorXd error = by_gradients.transpose().reshaped() - expected;
    EXPECT_LT(std::sqrt(error.dot(matrix * error)),
              2e-3 * std::sqrt(expected.dot(matrix * expected)));
    ASSERT_TRUE(system.solve(rhs, 0, either));
    EXPECT_LT((either - by_factors).norm(), 0.01 * expected.norm());
    EXPECT_FALSE(system.solve_by_gradients(rhs, 0, 2, either));
  }
}

TEST(SpringSystem, FactorisesWhereGradientsTakeLonger) {
  // A strip of three columns, whose factors are narrow, a thousandth as heavy as stiff.
  ClothSpec spec = square_spec(3);
  spec.rows = 51;
  const Cloth cloth = make_grid(spec);
  SpringSystem system;
  set_up(cloth, 1e-3 * spec.material.ks, system);
  const Points rhs = random_points(cloth.num_points(), 1, 2);
  Points either, by_factors, by_gradients;
  ASSERT_TRUE(system.solve(rhs, 0, either));
  ASSERT_TRUE(system.solve_by_factors(rhs, by_factors));
  ASSERT_TRUE(system.solve_by_gradients(rhs, 0, 1000, by_gradients));
  EXPECT_EQ(either, by_factors);
  EXPECT_NE(either, by_gradients);
}

TEST(SpringSystem, SolvesEachPieceAsIfAlone) {
  // Shear springs alone join the points of a chessboard's black squares, and of its white ones.
  ClothSpec spec = square_spec(12);
  spec.material.springs = {false, true, false};
  const Cloth cloth = make_grid(spec);
  SpringSystem system;
  set_up(cloth, 0.1 * spec.material.ks, system);
  ASSERT_EQ(system.pieces().size(), 2u);
  Points rhs = random_points(cloth.num_points(), 1, 2), both, one;
  ASSERT_TRUE(system.solve_by_gradients(rhs, 0, 1000, both));
  const SpringSystem::Piece& white = system.pieces()[1];
  for (int r = white.begin; r < white.end; ++r) {
    rhs.row(system.points()[static_cast<std::size_t>(r)]) *= 1e-6;
  }
  ASSERT_TRUE(system.solve_by_gradients(rhs, 0, 1000, one));
  for (int r = 0; r < cloth.num_points(); ++r) {
    const int i = system.points()[static_cast<std::size_t>(r)];
    const double scale = r < white.begin ? 1 : 1e-6;
    EXPECT_LT((one.row(i) - scale * both.row(i)).norm(), 1e-12 * scale * both.norm()) << i;
  }
}

TEST(SpringSystem, SolvesForNoForce) {
  const Cloth cloth = make_grid(square_spec(3));
  SpringSystem system;
  system.begin(cloth);
  for (int i = 0; i < 9; ++i) system.add_to_point(i, Matrix3::Identity());
  Points solution;
  EXPECT_TRUE(system.solve(Points::Zero(9, 3), 0, solution));
  EXPECT_EQ(solution, Points::Zero(9, 3));
}

TEST(SpringSystem, SaysWhenTheMatrixIsNotPositiveDefinite) {
  const Cloth cloth = make_grid(square_spec(3));
  SpringSystem system;
  Points solution;
  const auto solves = [&](double diagonal) {
    system.begin(cloth);
    for (int i = 0; i < 9; ++i)
      system.add_to_point(i, (i == 4 ? diagonal : 1) * Matrix3::Identity());
    return system.solve(random_points(9, 1, 3), 0, solution);
  };
  EXPECT_TRUE(solves(1));
  EXPECT_FALSE(solves(-1));
  EXPECT_FALSE(solves(std::nan("")));
}

TEST(NewtonSolver, LeavesNoForce) {
  // From steps short against the fastest swing to a hundred times longer, near rest and far from
  // it.
  const Cloth cloth = make_grid(pinned_spec(7, 6));
  const double omega = std::sqrt(8 * 5000 / cloth.mass[0]);
  NewtonSolver::Parameters parameters;
  parameters.tolerance = 1e-10;
  parameters.max_iterations = 500;
  NewtonSolver solver(parameters);
  for (const double omega_h : {0.1, 1.0, 10.0, 100.0}) {
    for (const double size : {0.01, 0.3}) {
      if (omega_h * size > 10) continue;  // crumpled, at a step with little inertia: too slow
      const Scalars weights = weights_of(cloth, omega_h / omega);
      const Points y = shaken(cloth, size, 1);
      Points d;
      const int iterations = solver.solve(cloth, weights, y, d);
      EXPECT_FALSE(solver.unconverged());
      EXPECT_LT(iterations, 500) << "omega h " << omega_h << ", size " << size;

      // The residual is the last step's share of the stiffest spring.
      Points gradient(y.rows(), 3);
      potential_gradient(cloth, weights, y + d, d, gradient);
      Points before(y.rows(), 3);
      potential_gradient(cloth, weights, y, 0 * d, before);
      EXPECT_LT(gradient.norm(), 1e-7 * before.norm()) << omega_h << ' ' << size;
      EXPECT_LT(incremental_potential(cloth, weights, y, d),
                incremental_potential(cloth, weights, y, 0 * d));
      for (const int pin : cloth.pinned) EXPECT_EQ(d.row(pin).norm(), 0);
    }
  }
}

TEST(NewtonSolver, KeepsMomentumHoweverFewTheSteps) {
  const Cloth cloth = make_grid(square_spec(6));
  const Scalars weights = weights_of(cloth, 0.05);
  const Points y = shaken(cloth, 0.3, 1);
  for (const int most : {1, 2, 5}) {
    NewtonSolver::Parameters parameters;
    parameters.max_iterations = most;
    Points d;
    NewtonSolver solver(parameters);
    EXPECT_LE(solver.solve(cloth, weights, y, d), most);
    EXPECT_TRUE(solver.unconverged());
    EXPECT_GT(d.norm(), 1e-3);
    EXPECT_LT((d.transpose() * weights).norm(), 1e-9 * weights.sum() * d.norm());
  }
}

TEST(NewtonSolver, KeepsTheMomentumOfAFreePieceBesideAPinnedOne) {
  ClothSpec spec = square_spec(8);
  spec.material.springs = {false, true, false};  // two pieces, see above
  spec.pinned = {{0, 0, ""}};
  const Cloth cloth = make_grid(spec);
  const Scalars weights = weights_of(cloth, 0.01);
  Points d;
  NewtonSolver solver{NewtonSolver::Parameters()};
  solver.solve(cloth, weights, shaken(cloth, 0.02, 1), d);
  Vector3 moved[2] = {Vector3::Zero(), Vector3::Zero()};
  for (int i = 0; i < cloth.num_points(); ++i) moved[(i / 8 + i % 8) % 2] += weights[i] * row(d, i);
  EXPECT_GT(moved[0].norm(), 1e-5 * weights.sum() * d.norm());  // the pin's piece
  EXPECT_LT(moved[1].norm(), 1e-12 * weights.sum() * d.norm());
}

TEST(NewtonSolver, ASpringOfItsRestLengthStays) {
  const Cloth cloth = make_grid(square_spec(4));
  Points d;
  NewtonSolver solver{NewtonSolver::Parameters()};
  EXPECT_EQ(solver.solve(cloth, weights_of(cloth, 0.01), cloth.rest_positions, d), 1);
  EXPECT_LT(d.norm(), 1e-14);
}

TEST(NewtonSolver, SaysNotANumberWhereThereIsNone) {
  const Cloth cloth = make_grid(square_spec(4));
  Points y = cloth.rest_positions;
  y(5, 1) = std::nan("");
  Points d;
  NewtonSolver solver{NewtonSolver::Parameters()};
  solver.solve(cloth, weights_of(cloth, 0.01), y, d);
  EXPECT_FALSE(d.allFinite());
}

}  // namespace
}  // namespace clothsim::newton_solver_test
