#include "clothsim/dynamics/spectrum.h"

#include <cmath>

#include "algebra.h"
#include "clothsim/dynamics/springs.h"
#include "verification/testing.h"

namespace clothsim::spectrum_test {
namespace {

using namespace test;

/// The largest frequency of M^-1/2 K M^-1/2 at `x`, with K the exact Hessian of the springs,
/// k (u u^T + (1 - L0 / l)(I - u u^T)), over the free points.
double exact_omega_max(const Cloth& cloth, const Points& x) {
  const int n = cloth.num_points();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Vector3 d = (x.row(b) - x.row(a)).transpose();
    const double length = d.norm();
    if (length == 0) return;
    const Eigen::Matrix3d uu = d * d.transpose() / (length * length);
    const Eigen::Matrix3d block =
        run.stiffness * (uu + (1 - run.rest_length / length) * (Eigen::Matrix3d::Identity() - uu));
    k.block<3, 3>(3 * a, 3 * a) += block;
    k.block<3, 3>(3 * b, 3 * b) += block;
    k.block<3, 3>(3 * a, 3 * b) -= block;
    k.block<3, 3>(3 * b, 3 * a) -= block;
  });
  Eigen::VectorXd scale(3 * n);
  for (int i = 0; i < n; ++i) scale.segment<3>(3 * i).setConstant(std::sqrt(cloth.inv_mass[i]));
  k = scale.asDiagonal() * k * scale.asDiagonal();
  return std::sqrt(std::max(0.0, eigenvalues(k).maxCoeff()));
}

TEST(Spectrum, NeverBelowTheExactFrequency) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    ClothSpec spec = square_spec(5, 300);
    spec.columns = 3 + static_cast<int>(seed % 3);
    if (seed % 2 == 0) spec.pinned = {{0, 0, ""}, {2, 4, ""}};
    const Cloth cloth = make_grid(spec);
    // From almost flat, over crumpled, to torn apart, and compressed.
    for (const double size : {1e-3, 0.1, 1.0, 100.0}) {
      const Points x = shaken(cloth, size, seed);
      EXPECT_GE(omega_max_bound(cloth, x), exact_omega_max(cloth, x)) << size << " " << seed;
      EXPECT_GE(omega_max_bound(cloth) * (1 + 1e-14), omega_max_bound(cloth, x));
      EXPECT_GE(omega_max_bound(cloth, 0.3 * x), exact_omega_max(cloth, 0.3 * x));
    }
  }
}

TEST(Spectrum, IsTheLeastAskedForWhereThatIsHigher) {
  const Cloth cloth = make_grid(square_spec(9, 300));
  const Points x = shaken(cloth, 0.05, 1);
  const double bound = omega_max_bound(cloth, x);
  EXPECT_EQ(omega_max_bound(cloth, x, 1.01 * bound), 1.01 * bound);
  for (const double share : {0.1, 0.9, 0.999}) {
    EXPECT_NEAR(omega_max_bound(cloth, x, share * bound), bound, 1e-12 * bound);
  }
}

TEST(Spectrum, IsCloseForAFlatGrid) {
  // Exactly 8 k / m on an endless grid of all families, and some percent less on a small one.
  const Cloth cloth = make_grid(square_spec(18, 300));
  const double exact = exact_omega_max(cloth, cloth.rest_positions);
  const double bound = omega_max_bound(cloth, cloth.rest_positions);
  EXPECT_NEAR(exact * exact * cloth.mass[0] / 300, 8, 0.1);
  EXPECT_GE(bound, exact);
  EXPECT_LE(bound, 1.06 * exact);
}

TEST(Spectrum, OneSpringIsExact) {
  // Both ends free: omega^2 = 2 k / m; one pinned: the bound stays that of a free pair.
  const Cloth cloth = make_grid(chain_spec(2, 1, 50));
  EXPECT_NEAR(omega_max_bound(cloth, cloth.rest_positions), std::sqrt(2 * 50.0), 1e-12);
  EXPECT_NEAR(exact_omega_max(cloth, cloth.rest_positions), std::sqrt(2 * 50.0), 1e-12);
}

TEST(Spectrum, GoesWithTheRootOfStiffnessOverMass) {
  ClothSpec spec = square_spec(6);
  const Points x = shaken(make_grid(spec), 0.05, 1);
  const double once = omega_max_bound(make_grid(spec), x);
  spec.material.ks *= 4;
  EXPECT_NEAR(omega_max_bound(make_grid(spec), x), 2 * once, 1e-9 * once);
  spec.material.density *= 4;
  EXPECT_NEAR(omega_max_bound(make_grid(spec), x), once, 1e-9 * once);
}

TEST(Spectrum, IsFiniteWherePointsCoincide) {
  const Cloth cloth = make_grid(square_spec(6));
  EXPECT_EQ(omega_max_bound(cloth, Points::Zero(cloth.num_points(), 3)), 0);
  Points x = cloth.rest_positions;
  x.row(1) = x.row(0);
  EXPECT_TRUE(std::isfinite(omega_max_bound(cloth, x)));
  EXPECT_GE(omega_max_bound(cloth, x), exact_omega_max(cloth, x));
}

}  // namespace
}  // namespace clothsim::spectrum_test
