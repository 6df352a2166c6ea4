#include "clothsim/dynamics/xpbd_lines.h"

#include <algorithm>
#include <map>

#include "algebra.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/xpbd.h"
#include "verification/testing.h"

namespace clothsim::xpbd_lines_test {
namespace {

using namespace test;

/// A rope of `points`, held at its first.
ClothSpec rope(int points, double ks = 5000) {
  ClothSpec spec = square_spec(2, ks);
  spec.columns = points;
  spec.rows = 1;
  spec.width = 0.1 * (points - 1);
  spec.material.springs = {true, false, false};
  spec.pinned = {{0, 0, ""}};
  return spec;
}

/// A line of points and springs, and a pass over it as two dense solutions: see XpbdLines.
struct DenseLine {
  std::vector<int> points;
  Eigen::VectorXd inv_mass;
  Eigen::VectorXd target;
  Eigen::VectorXd compliance;
  Eigen::VectorXd lambda;

  void solve(Points& positions, Points& reactions) {
    const auto count = static_cast<Eigen::Index>(points.size());
    const Eigen::Index springs = count - 1;
    Points x(count, 3);
    for (Eigen::Index k = 0; k < count; ++k) {
      x.row(k) = positions.row(points[static_cast<std::size_t>(k)]);
    }
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(springs, 3 * count);  // by spring
    Eigen::VectorXd lengths(springs);
    for (Eigen::Index k = 0; k < springs; ++k) {
      const Eigen::RowVector3d d = x.row(k + 1) - x.row(k);
      lengths[k] = d.norm();
      j.block<1, 3>(k, 3 * k) = -d.normalized();
      j.block<1, 3>(k, 3 * (k + 1)) = d.normalized();
    }
    const Eigen::VectorXd w = inv_mass.replicate(1, 3).transpose().reshaped();
    Eigen::MatrixXd matrix = j * w.asDiagonal() * j.transpose();
    matrix.diagonal() += compliance;
    const Eigen::VectorXd change =
        test::solve(matrix, target - lengths - compliance.cwiseProduct(lambda));
    lambda += change;

    Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(count, count);
    Points forces = Points::Zero(count, 3);
    for (Eigen::Index k = 0; k < springs; ++k) {
      const bool is_tension = change[k] < 0;
      const double expected = std::max(target[k] - compliance[k] * lambda[k], lengths[k] / 2);
      const double density = is_tension ? -change[k] / expected : 0;
      const double impulse = is_tension ? density * lengths[k] : -change[k];
      forces.row(k) += impulse * j.block<1, 3>(k, 3 * (k + 1));
      forces.row(k + 1) -= impulse * j.block<1, 3>(k, 3 * (k + 1));
      laplacian.block<2, 2>(k, k) += density * (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
    }
    const Eigen::MatrixXd system =
        Eigen::MatrixXd::Identity(count, count) + inv_mass.asDiagonal() * laplacian;
    const Points moves = test::solve(system, inv_mass.asDiagonal() * forces);
    const Points impulses = forces - laplacian * moves;
    for (Eigen::Index k = 0; k < count; ++k) {
      const int i = points[static_cast<std::size_t>(k)];
      positions.row(i) += moves.row(k);
      if (inv_mass[k] == 0) reactions.row(i) += impulses.row(k);
    }
  }
};

TEST(XpbdLines, APassIsTheDenseSolutionOfEachLine) {
  // Ten rows, so that one bundle is full and one is not, of random masses, with held points at the
  // ends of some lines and within one, and stiffness by row. Two passes, the second one back.
  for (const int columns : {2, 3, 12}) {
    ClothSpec spec = square_spec(2, 5000);
    spec.columns = columns;
    spec.rows = 10;
    spec.width = 0.1 * (columns - 1);
    Cloth cloth = make_grid(spec);
    const int n = cloth.num_points();
    cloth.springs.clear();
    const Points random = random_points(n, 0.5, 4);
    cloth.mass = (1 + random.col(0).array()).matrix();
    cloth.inv_mass = cloth.mass.cwiseInverse();
    for (const int i :
         {0, 3 * columns - 1, 5 * columns, 6 * columns - 1, 9 * columns + columns / 2}) {
      cloth.inv_mass[i] = 0;
    }
    const double h = 0.01, damping = 0.02;
    const Points past = shaken(cloth, 0.02, 2);
    std::vector<DenseLine> expected;
    for (int row = 0; row < 10; ++row) {
      const double stiffness = 1000.0 * (row + 1);
      cloth.springs.push_back(
          {SpringFamily::structural, row * columns, 1, columns - 1, 0.1, stiffness});
      DenseLine line{{},
                     cloth.inv_mass.segment(row * columns, columns),
                     Eigen::VectorXd(columns - 1),
                     Eigen::VectorXd(columns - 1),
                     Eigen::VectorXd::Zero(columns - 1)};
      for (int k = 0; k < columns; ++k) line.points.push_back(row * columns + k);
      for (int k = 0; k + 1 < columns; ++k) {
        const double length =
            (past.row(row * columns + k + 1) - past.row(row * columns + k)).norm();
        line.target[k] = (0.1 + damping / h * length) / (1 + damping / h);
        line.compliance[k] = 1 / (stiffness * (1 + damping / h) * h * h);
      }
      expected.push_back(line);
    }
    cloth.damping = 0;
    cloth.internal_damping = {damping, 0};
    XpbdLines lines;
    lines.build(cloth, h);
    lines.begin_step();
    lines.set_targets(past, damping, h);
    Points x = shaken(cloth, 0.05, 1), reactions = Points::Zero(n, 3);
    Points dense = x, on_held = reactions;
    for (const bool back : {false, true}) {
      const Points before = x;
      lines.solve(back, x, reactions, {});
      for (DenseLine& line : expected) line.solve(dense, on_held);
      EXPECT_LT(farthest(x, dense), 1e-12) << columns;
      EXPECT_LT(farthest(reactions, on_held), 1e-12 * (1 + on_held.cwiseAbs().maxCoeff()));
      // Row 1 has no held point: its momentum stays.
      const Eigen::RowVector3d moved = cloth.mass.segment(columns, columns).transpose() *
                                       (x - before).middleRows(columns, columns);
      EXPECT_LT(moved.norm(), 1e-14);
    }
    int found = 0;
    lines.for_each([&](int a, int b, double multiplier) {
      EXPECT_EQ(b, a + 1);
      const DenseLine& line = expected[static_cast<std::size_t>(a / columns)];
      EXPECT_NEAR(multiplier, line.lambda[a % columns], 1e-11 * line.lambda.cwiseAbs().maxCoeff());
      ++found;
    });
    EXPECT_EQ(found, 10 * (columns - 1));
  }
}

TEST(XpbdLines, AStraightLineHeldAtBothEndsIsFiniteHoweverStiff) {
  // Without compliance its system is singular.
  for (const double ks : {1e3, 1e9, 1e12}) {
    for (const double density : {1e-6, 1.0}) {
      ClothSpec spec = rope(51, ks);
      spec.material.density = density;
      spec.pinned.push_back({50, 0, ""});
      const Cloth cloth = make_grid(spec);
      State state = start_state(spec, cloth, 1);
      Xpbd method;
      for (int i = 0; i < 20; ++i) method.step(cloth, Loads{}, 0.5, state);
      EXPECT_TRUE(state.positions.allFinite()) << ks << ' ' << density;
      EXPECT_LT(longest_row(state.positions), 100) << ks << ' ' << density;
    }
  }
}

TEST(XpbdLines, TautClothOfAnyStiffnessRestsInLongSteps) {
  for (const double ks : {5e4, 5e5, 5e6, 5e7}) {
    for (const double h : {1.0 / 90, 1.0 / 180, 1.0 / 360}) {
      ClothSpec spec = square_spec(25, ks);
      spec.material.density = 10;
      spec.material.damping = 1;
      spec.pinned.clear();
      for (const int side : {0, 24}) {
        for (int row = 0; row < 25; ++row) spec.pinned.push_back({side, row, ""});
      }
      const Cloth cloth = make_grid(spec);
      State state = start_state(spec, cloth, 1);
      Xpbd method;
      run(method, cloth, Loads{}, h, static_cast<int>(5 / h), state);
      EXPECT_LT(rms_velocity(state), 0.01) << ks << ' ' << h;
    }
  }
}

TEST(XpbdLines, HaveEachSpringOfAnyListOnce) {
  // Grids of all shapes, with lines of different lengths, and lists with repeated springs.
  std::vector<Cloth> cloths;
  for (const auto& [columns, rows] : {std::pair(1, 5), std::pair(2, 2), std::pair(2, 9),
                                      std::pair(3, 4), std::pair(9, 3), std::pair(20, 17)}) {
    ClothSpec spec = square_spec(2);
    spec.columns = columns;
    spec.rows = rows;
    cloths.push_back(make_grid(spec));
  }
  cloths.push_back(cloths.back());
  cloths.back().springs.push_back(cloths.back().springs[1]);
  cloths.back().springs.push_back({SpringFamily::shear, 3, 7, 200, 0.1, 3});
  cloths.back().springs.push_back({SpringFamily::shear, 0, 5, 9, 0.1, 0});  // without stiffness
  for (const Cloth& cloth : cloths) {
    std::map<std::array<int, 2>, int> expected, found;
    for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
      if (run.stiffness > 0) ++expected[{a, b}];
    });
    XpbdLines lines;
    lines.build(cloth, 0.01);
    lines.for_each([&](int a, int b, double) { ++found[{a, b}]; });
    EXPECT_EQ(found, expected) << cloth.columns << " x " << cloth.rows;
  }
}

TEST(XpbdLines, SpringsWithoutLengthHaveNoImpulse) {
  const Cloth cloth = make_grid(rope(4));
  XpbdLines lines;
  lines.build(cloth, 0.01);
  lines.begin_step();
  Points x = cloth.rest_positions, reactions = Points::Zero(4, 3);
  x.row(2) = x.row(1);
  lines.solve(false, x, reactions, {});
  EXPECT_TRUE(x.allFinite());
  // The second has none; the first, at its rest length, is coupled to none.
  lines.for_each([](int a, int, double lambda) { EXPECT_EQ(lambda != 0, a == 2) << a; });
}

TEST(XpbdLines, ALongRopeHangsAsFarAsItsWeightStretchesIt) {
  // 100 links in steps of 0.1 s: link k of n has the weight of n - k points below it. With one
  // spring after the other the weight would need dozens of steps to climb.
  const int points = 101;
  ClothSpec spec = rope(points, 2e5);
  spec.material.damping = 2;
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  for (int i = 0; i < points; ++i) state.positions.row(i) << 0, 0, -0.1 * i;
  Xpbd method;
  for (int i = 0; i < 400; ++i) method.step(cloth, Loads{}, 0.1, state);
  const double weight = 9.8 * cloth.mass[1];
  for (const int k : {0, 1, 50, 99}) {
    const double length = (row(state.positions, k + 1) - row(state.positions, k)).norm();
    const double expected = 0.1 + (points - 1 - k) * weight / cloth.springs.front().stiffness;
    EXPECT_NEAR(length, expected, 1e-6) << k;
  }
}

}  // namespace
}  // namespace clothsim::xpbd_lines_test
