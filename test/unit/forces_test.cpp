#include "clothsim/dynamics/forces.h"

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/springs.h"
#include "verification/testing.h"

namespace clothsim::forces_test {
namespace {

using namespace test;

/// The same forces, spring by spring.
Points plain_forces(const Cloth& cloth, const Loads& loads, const Points& x) {
  Points forces = cloth.mass * loads.gravity.transpose();
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Eigen::RowVector3d d = x.row(b) - x.row(a);
    const double length = d.norm();
    if (length == 0) return;
    const Eigen::RowVector3d f = run.stiffness * (length - run.rest_length) * d / length;
    forces.row(a) += f;
    forces.row(b) -= f;
  });
  return forces;
}

void expect_equal_to_plain(const Cloth& cloth, const Points& x) {
  const Loads loads{Vector3(1, -2, 3)};
  const Points expected = plain_forces(cloth, loads, x);
  Points forces = Points::Constant(1, 3, 7);  // for any values it held before
  compute_forces(cloth, loads, x, forces);
  ASSERT_EQ(forces.rows(), cloth.num_points());
  // Sums of up to 13 terms in another order.
  const double scale = expected.cwiseAbs().maxCoeff();
  EXPECT_LE(farthest(forces, expected), 1e-13 * scale);
}

ClothSpec grid_spec(int columns, int rows) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  return spec;
}

TEST(Forces, EqualThePlainLoopOnRandomStates) {
  // Chains, small grids, and sizes below, at and beyond a block of 2560 points.
  for (const auto& [columns, rows] :
       {std::pair(1, 2), std::pair(2, 1), std::pair(2, 2), std::pair(3, 3), std::pair(5, 7),
        std::pair(7, 5), std::pair(129, 3), std::pair(50, 50), std::pair(64, 40), std::pair(61, 90),
        std::pair(1, 3000), std::pair(3000, 1), std::pair(2, 1500), std::pair(1500, 2)}) {
    ClothSpec spec = grid_spec(columns, rows);
    spec.pinned = {{0, 0, ""}};
    const Cloth cloth = make_grid(spec);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      expect_equal_to_plain(cloth, shaken(cloth, 0.3, seed));
      expect_equal_to_plain(cloth, random_points(cloth.num_points(), 100, seed));
    }
  }
}

TEST(Forces, EqualThePlainLoopWhereFamiliesAreOff) {
  for (const auto& [columns, rows] : {std::pair(9, 9), std::pair(1, 9), std::pair(2, 5)}) {
    for (int mask = 0; mask < 8; ++mask) {
      ClothSpec spec = grid_spec(columns, rows);
      spec.material.springs = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
      const Cloth cloth = make_grid(spec);
      expect_equal_to_plain(cloth, shaken(cloth, 0.3, 1));
    }
  }
}

TEST(Forces, EqualThePlainLoopForAnyListOfSprings) {
  // No grid: runs in any order, overlapping, of any stiffness, in more directions than a grid has.
  Cloth cloth = make_grid(square_spec(12));
  std::mt19937_64 engine(1);
  const auto draw = [&](int from, int to) {
    return std::uniform_int_distribution<int>(from, to - 1)(engine);
  };
  for (int lists = 0; lists < 50; ++lists) {
    cloth.springs.clear();
    for (int runs = draw(0, 20); runs > 0; --runs) {
      const int offset = draw(1, 140);
      const int first = draw(0, 144 - offset);
      const int count = draw(1, 144 - offset - first + 1);
      cloth.springs.push_back(
          {SpringFamily::shear, first, offset, count, 0.01 * draw(0, 3), 1000.0 * draw(0, 3)});
      if (draw(0, 2) == 1) cloth.springs.push_back(cloth.springs.back());
    }
    expect_equal_to_plain(cloth, shaken(cloth, 0.3, 1));
  }
}

TEST(Forces, HaveTheSameBitsWhereverBlocksBegin) {
  const Loads loads{Vector3(1, -2, 3)};
  const Cloth cloth = make_grid(grid_spec(67, 80));
  const Points x = shaken(cloth, 0.3, 4);
  const int n = cloth.num_points();
  Points whole;
  compute_forces(cloth, loads, x, whole);
  for (const int split : {1, 66, 67, 68, 133, 134, 135, 2559, 2560, 2561, n - 1}) {
    Points parts = Points::Constant(n, 3, 7);
    for (const auto& [begin, end] : {std::pair(split, n), std::pair(0, split)}) {
      for (ForceBlocks<double> blocks(cloth, loads, x, begin, end); blocks.next();) {
        for (int axis = 0; axis < 3; ++axis) blocks.sum(axis, &parts(blocks.first(), axis));
      }
    }
    EXPECT_EQ(parts, whole) << "split at " << split;
  }
}

TEST(Forces, InSinglePrecisionAreOffByItsRoundings) {
  // Far from the origin too: positions count from the cloth.
  const Loads loads{Vector3(1, -2, 3)};
  const Cloth cloth = make_grid(grid_spec(67, 80));
  const int n = cloth.num_points();
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(1000, -2000, 500)}) {
    const Points x = shaken(cloth, 0.3, 4).rowwise() + place.transpose();
    Points expected;
    compute_forces(cloth, loads, x, expected);
    const double extent = (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff();
    const double stiffness = cloth.springs.front().stiffness;
    for (const int split : {0, 68, 2561}) {
      for (const auto& [begin, end] : {std::pair(0, split), std::pair(split, n)}) {
        for (ForceBlocks<float> blocks(cloth, loads, x, begin, end); blocks.next();) {
          for (int axis = 0; axis < 3; ++axis) {
            Eigen::VectorXf f(blocks.count());
            blocks.sum(axis, f.data());
            const double off =
                (f.cast<double>() - expected.col(axis).segment(blocks.first(), blocks.count()))
                    .cwiseAbs()
                    .maxCoeff();
            // Twelve springs, each with a rounding of the places of its ends and of its factor.
            EXPECT_LT(off, 12 * 4 * 6e-8 * stiffness * extent) << split;
            EXPECT_GT(off, 0);
          }
        }
      }
    }
  }
}

TEST(Forces, CoincidentPointsGiveNoForceAndNoNan) {
  const Cloth cloth = make_grid(square_spec(6));
  // All points in one place.
  Points x = Points::Constant(cloth.num_points(), 3, 0.25);
  Points forces;
  compute_forces(cloth, Loads{}, x, forces);
  EXPECT_EQ(forces, Points(cloth.mass * Loads{}.gravity.transpose()));
  // Some of the points.
  x = shaken(cloth, 0.1, 5);
  x.row(1) = x.row(0);
  x.row(8) = x.row(7);
  x.row(14) = x.row(2);
  expect_equal_to_plain(cloth, x);
  compute_forces(cloth, Loads{}, x, forces);
  EXPECT_TRUE(forces.allFinite());
  // A denormal distance has a direction, or none; never NaN.
  x.row(1) = x.row(0);
  x(1, 0) += 1e-310;
  x.row(0).setZero();
  x.row(1) << 1e-310, 0, 0;
  compute_forces(cloth, Loads{}, x, forces);
  EXPECT_TRUE(forces.allFinite());
}

TEST(Forces, AreMinusTheGradientOfTheEnergy) {
  // f = -dE/dx by central differences: error C h^2 + eps E / h, about 1e-6 of the largest force.
  ClothSpec spec = square_spec(5);
  const Cloth cloth = make_grid(spec);
  const Loads loads{Vector3(0.3, -1, -9.8)};
  Points x = shaken(cloth, 0.05, 2);
  Points forces;
  compute_forces(cloth, loads, x, forces);
  const auto energy = [&] {
    return elastic_energy(cloth, x) + gravitational_energy(cloth, loads.gravity, x);
  };
  const double h = 1e-6;
  const double scale = forces.cwiseAbs().maxCoeff();
  for (int i = 0; i < cloth.num_points(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double at = x(i, axis);
      x(i, axis) = at + h;
      const double more = energy();
      x(i, axis) = at - h;
      const double less = energy();
      x(i, axis) = at;
      EXPECT_NEAR(forces(i, axis), (less - more) / (2 * h), 1e-6 * scale);
    }
  }
}

TEST(Forces, ClothAtRestFeelsItsWeightAlone) {
  const Cloth cloth = make_grid(square_spec(10));
  Points forces;
  compute_forces(cloth, Loads{}, cloth.rest_positions, forces);
  EXPECT_LT(farthest(forces, cloth.mass * Loads{}.gravity.transpose()), 1e-10);
}

}  // namespace
}  // namespace clothsim::forces_test
