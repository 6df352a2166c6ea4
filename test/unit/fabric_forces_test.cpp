// The forces of a fabric against plain loops over its springs and stencils.

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/forces.h"
#include "clothsim/dynamics/internal_damping.h"
#include "clothsim/dynamics/springs.h"
#include "unit/plain_rotation.h"
#include "verification/fabric_testing.h"

namespace clothsim::fabric_forces_test {
namespace {

using namespace test;

Points plain_forces(const Cloth& cloth, const Loads& loads, const Points& x, const Points& v) {
  Points forces = cloth.mass * loads.gravity.transpose();
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Eigen::RowVector3d d = x.row(b) - x.row(a);
    if (d.norm() == 0) return;
    const Eigen::RowVector3d u = d.normalized();
    const double rate = u.dot(v.row(b) - v.row(a));
    const double tension =
        run.stiffness * (d.norm() - run.rest_length + cloth.internal_damping[0] * rate);
    forces.row(a) += tension * u;
    forces.row(b) -= tension * u;
  });
  for (const CellRun& run : cloth.cells) {
    for (int i = run.first; i < run.first + run.count; ++i) {
      const Vector3 one = row(x, i + run.a + run.b) - row(x, i);
      const Vector3 two = row(x, i + run.b) - row(x, i + run.a);
      const Vector3 one_rate = row(v, i + run.a + run.b) - row(v, i);
      const Vector3 two_rate = row(v, i + run.b) - row(v, i + run.a);
      const auto& [p, q, r, rest] = run.strain;
      const Vector3 by_one = 2 * p * one + r * two, by_two = 2 * q * two + r * one;
      const double strain = p * one.squaredNorm() + q * two.squaredNorm() + r * one.dot(two) - rest;
      const double rate = by_one.dot(one_rate) + by_two.dot(two_rate);
      const double stress = run.stiffness * (strain + cloth.internal_damping[0] * rate);
      forces.row(i) += stress * by_one.transpose();
      forces.row(i + run.a + run.b) -= stress * by_one.transpose();
      forces.row(i + run.a) += stress * by_two.transpose();
      forces.row(i + run.b) -= stress * by_two.transpose();
    }
  }
  const Vector3 omega = cloth.num_bends() > 0 ? plain_rotation(cloth, x, v) : Vector3::Zero();
  for_each_bend(cloth, [&](const auto& bend) {
    const Vector3 rate = bend.of(v) - omega.cross(bend.of(x));
    const Vector3 pull = bend.stiffness * (bend.of(x) + cloth.internal_damping[1] * rate);
    for (std::size_t k = 0; k < 4; ++k) {
      forces.row(bend.points[k]) -= Bend::coefficient(k) * pull.transpose();
    }
  });
  return forces;
}

ClothSpec damped_spec(int columns, int rows) {
  ClothSpec spec = fabric_spec(columns, rows, 0.02, 0.01);
  spec.material.fabric->bending_stiffness = {3e-2, 1e-2};  // as strong as springs
  spec.material.fabric->internal_damping = {0.03, 0.05};
  spec.material.fabric->poisson = -0.3;
  return spec;
}

TEST(FabricForces, EqualThePlainLoops) {
  const Loads loads{Vector3(1, -2, 3)};
  for (const auto& [columns, rows] :
       {std::pair(1, 2), std::pair(1, 9), std::pair(9, 1), std::pair(2, 2), std::pair(2, 3),
        std::pair(3, 2), std::pair(3, 3), std::pair(5, 7), std::pair(50, 52), std::pair(2, 1500),
        std::pair(3000, 2)}) {
    for (int mask = 0; mask < 16; ++mask) {
      ClothSpec spec = damped_spec(columns, rows);
      spec.material.springs = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
      if ((mask & 8) != 0) spec.material.fabric->poisson = 0;
      const Cloth cloth = make_grid(spec);
      const Points x = shaken(cloth, 0.01, 1);
      const Points v = random_points(cloth.num_points(), 0.1, 2);
      const Points expected = plain_forces(cloth, loads, x, v);
      Points forces;
      compute_forces(cloth, loads, x, forces, {}, &v);
      // Sums of up to 13 terms that cancel, each 8 times the largest stiffness.
      const double scale = expected.cwiseAbs().maxCoeff();
      EXPECT_LE(farthest(forces, expected), 1e-12 * scale)
          << columns << " x " << rows << ", families " << mask;
    }
  }
}

TEST(FabricForces, HaveTheSameBitsWhereverBlocksBegin) {
  const Loads loads{};
  const Cloth cloth = make_grid(damped_spec(67, 80));
  const Points x = shaken(cloth, 0.005, 4);
  const Points v = random_points(cloth.num_points(), 0.1, 2);
  const int n = cloth.num_points();
  Points whole, relative;
  compute_forces(cloth, loads, x, whole, {}, &v);
  remove_rotation(cloth, x, v, relative);
  for (const int split : {1, 66, 67, 133, 134, 135, 2559, 2560, 2561, n - 1}) {
    Points parts = Points::Constant(n, 3, 7);
    for (const auto& [begin, end] : {std::pair(split, n), std::pair(0, split)}) {
      for (ForceBlocks<double> blocks(cloth, loads, x, begin, end, &relative); blocks.next();) {
        for (int axis = 0; axis < 3; ++axis) blocks.sum(axis, &parts(blocks.first(), axis));
      }
    }
    EXPECT_EQ(parts, whole) << "split at " << split;
  }
}

TEST(FabricForces, InSinglePrecisionAreOffByItsRoundings) {
  const Loads loads{};
  const Cloth cloth = make_grid(damped_spec(20, 30));
  const Points x = shaken(cloth, 0.005, 4).rowwise() + Eigen::RowVector3d(100, -200, 50);
  const Points v = random_points(cloth.num_points(), 0.1, 2);
  const int n = cloth.num_points();
  Points expected, relative;
  compute_forces(cloth, loads, x, expected, {}, &v);
  remove_rotation(cloth, x, v, relative);
  double stiffest = 0;
  for (const PairBand& band : cloth.pairs) {
    stiffest = std::max(stiffest, band.bend.cwiseAbs().maxCoeff());
    if (band.spring.size() > 0) stiffest = std::max(stiffest, band.spring.maxCoeff());
  }
  for (ForceBlocks<float> blocks(cloth, loads, x, 0, n, &relative); blocks.next();) {
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::VectorXf f(blocks.count());
      blocks.sum(axis, f.data());
      const double off = (f.cast<double>() - expected.col(axis)).cwiseAbs().maxCoeff();
      EXPECT_LT(off, 12 * 4 * 6e-8 * stiffest * 0.4);  // of 0.4 m
      EXPECT_GT(off, 0);
    }
  }
}

TEST(FabricForces, AreMinusTheGradientOfTheEnergyAndOfDamping) {
  // Central differences, to some 1e-6 of the largest force.
  const Cloth cloth = make_grid(damped_spec(4, 5));
  const Points start = shaken(cloth, 0.002, 2);
  Points x = shaken(cloth, 0.002, 3);
  const Points turning = random_points(cloth.num_points(), 0.1, 2);
  const Past past = past_of(cloth, State{start, turning, 0}, 0.01);
  Points forces, gradient = Points::Zero(cloth.num_points(), 3);
  compute_forces(cloth, Loads{Vector3::Zero()}, x, forces);
  add_damping_gradient(cloth, past, x, gradient);
  const double h = 1e-7;
  const auto difference = [&](int i, int axis, const auto& potential) {
    const double at = x(i, axis);
    x(i, axis) = at + h;
    const double more = potential();
    x(i, axis) = at - h;
    const double less = potential();
    x(i, axis) = at;
    return (more - less) / (2 * h);
  };
  for (int i = 0; i < cloth.num_points(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double elastic = difference(i, axis, [&] { return elastic_energy(cloth, x); });
      EXPECT_NEAR(forces(i, axis), -elastic, 1e-6 * forces.cwiseAbs().maxCoeff());
      const double damping = difference(i, axis, [&] { return damping_potential(cloth, past, x); });
      EXPECT_NEAR(gradient(i, axis), damping, 1e-6 * gradient.cwiseAbs().maxCoeff());
    }
  }
}

TEST(FabricForces, HaveNoSumAndNoTorque) {
  const Cloth cloth = make_grid(damped_spec(9, 7));
  const Points x = shaken(cloth, 0.005, 4), v = random_points(cloth.num_points(), 1, 2);
  Points forces;
  compute_forces(cloth, Loads{Vector3::Zero()}, x, forces, {}, &v);
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < cloth.num_points(); ++i) torque += row(x, i).cross(row(forces, i));
  const double scale = forces.cwiseAbs().maxCoeff();
  EXPECT_LT(forces.colwise().sum().norm(), 1e-12 * scale);
  EXPECT_LT(torque.norm(), 1e-12 * scale);
}

TEST(FabricForces, OfDampingLeaveRotationAlone) {
  const Cloth cloth = make_grid(damped_spec(9, 7));
  const Points x = shaken(cloth, 0.005, 4);
  Points v = x;
  const Vector3 omega(1, -2, 3);
  for (int i = 0; i < cloth.num_points(); ++i) v.row(i) = omega.cross(row(x, i)).transpose();
  Points undamped, forces;
  compute_forces(cloth, Loads{}, x, undamped);
  compute_forces(cloth, Loads{}, x, forces, {}, &v);
  EXPECT_LT(farthest(forces, undamped), 1e-12 * undamped.cwiseAbs().maxCoeff());
}

TEST(FabricForces, OfDampingHaveTheSameBitsWithThreads) {
  const Cloth cloth = make_grid(damped_spec(67, 80));
  const Points x = shaken(cloth, 0.005, 4), v = random_points(cloth.num_points(), 0.1, 2);
  Points one, four;
  compute_forces(cloth, Loads{}, x, one, {}, &v);
  compute_forces(cloth, Loads{}, x, four, Workers(4), &v);
  EXPECT_EQ(one, four);
}

TEST(FabricForces, OfDampingAreFiniteAndResistMotionOfAnyCloth) {
  // Flat, bent by rounding errors, along one line, or about one direction: directions of bends that
  // say little of a rotation.
  ClothSpec spec = damped_spec(9, 7);
  spec.material.fabric->internal_damping = {0, 0.05};
  const Cloth cloth = make_grid(spec);
  const Points v = random_points(cloth.num_points(), 1, 2);
  for (const double height : {0.0, 1e-300, 1e-17, 1e-12, 1e-9, 1e-6, 1e-3}) {
    for (const bool is_cylinder : {false, true}) {
      Points x = shaken(cloth, is_cylinder ? 0 : height, 4);
      for (int i = 0; is_cylinder && i < cloth.num_points(); ++i) {
        x(i, 2) += height * std::cos(30 * x(i, 0));
      }
      Points undamped, forces;
      compute_forces(cloth, Loads{}, x, undamped);
      compute_forces(cloth, Loads{}, x, forces, {}, &v);
      ASSERT_TRUE(forces.allFinite()) << height;
      EXPECT_LT((forces - undamped).cwiseProduct(v).sum(), 0) << height;
    }
  }
}

TEST(FabricForces, OfAFlatClothAtRestAreItsWeightAlone) {
  const Cloth cloth = make_grid(damped_spec(10, 8));
  Points forces;
  compute_forces(cloth, Loads{}, cloth.rest_positions, forces);
  EXPECT_LT(farthest(forces, cloth.mass * Loads{}.gravity.transpose()), 1e-10);
}

}  // namespace
}  // namespace clothsim::fabric_forces_test
