// A fabric against its continuum.

#include <cmath>

#include "clothsim/dynamics/membrane_stress.h"
#include "clothsim/dynamics/springs.h"
#include "verification/fabric_testing.h"

namespace clothsim::fabric_test {
namespace {

using namespace test;

// ---- Stretch and shear

/// Energy per area of a fabric stretched by `u` and `v` along its threads and sheared by `shear`.
double energy_per_area(const ClothSpec& spec, double u, double v, double shear) {
  const Cloth cloth = make_grid(spec);
  Points x = cloth.rest_positions;
  x.col(0) = (1 + u) * cloth.rest_positions.col(0) + shear * cloth.rest_positions.col(1);
  x.col(1) = (1 + v) * cloth.rest_positions.col(1);
  return elastic_energy(cloth, x) / (spec.width * spec.height);
}

TEST(Fabric, HasTheModuliAskedForOnCellsOfAnyShape) {
  // W = (C11 u^2 + C22 v^2 + 2 C12 u v + G shear^2) / 2 up to third order, of the share e = 1e-4.
  const double e = 1e-4;
  for (const auto& [du, dv] : {std::pair(0.02, 0.02), std::pair(0.02, 0.01), std::pair(0.04, 0.01),
                               std::pair(0.01, 0.04), std::pair(0.005, 0.005)}) {
    SCOPED_TRACE(std::to_string(du) + " x " + std::to_string(dv));
    for (const auto& [columns, rows, poisson] :
         {std::tuple(9, 7, 0.0), std::tuple(2, 2, 0.3), std::tuple(3, 12, -0.4)}) {
      ClothSpec spec = fabric_spec(columns, rows, du, dv);
      Fabric& fabric = *spec.material.fabric;
      fabric.poisson = poisson;
      const auto& [c11, c22] = fabric.stretch_stiffness;
      const double g = fabric.shear_stiffness;
      EXPECT_NEAR(2 * energy_per_area(spec, e, 0, 0) / (e * e), c11, 0.001 * c11);
      EXPECT_NEAR(2 * energy_per_area(spec, 0, e, 0) / (e * e), c22, 0.001 * c22);
      EXPECT_NEAR(2 * energy_per_area(spec, 0, 0, e) / (e * e), g, 0.001 * g);
      const double both = c11 + c22 + 2 * poisson * std::sqrt(c11 * c22);
      EXPECT_NEAR(2 * energy_per_area(spec, e, e, 0) / (e * e), both, 0.001 * both);
    }
  }
}

TEST(Fabric, StretchedFreelyFollowsWithItsWidth) {
  // One edge held, the other pulled: E = C11 - C12^2 / C22, and v = -C12 / C22 u.
  for (const auto& [du, dv] :
       {std::pair(0.01, 0.01), std::pair(0.02, 0.01), std::pair(0.04, 0.01)}) {
    ClothSpec spec = fabric_spec(12, 6, du, dv);
    spec.material.fabric->poisson = 0.25;
    spec.material.fabric->bending_stiffness = {0, 0};
    const auto& [c11, c22] = spec.material.fabric->stretch_stiffness;
    const double c12 = 0.25 * std::sqrt(c11 * c22);
    const double u = 1e-4;
    // The least energy over v, a parabola through three of them.
    const double step = u;
    const double low = energy_per_area(spec, u, -step, 0);
    const double middle = energy_per_area(spec, u, 0, 0);
    const double high = energy_per_area(spec, u, step, 0);
    const double curvature = (low - 2 * middle + high) / (step * step);
    const double slope = (high - low) / (2 * step);
    EXPECT_NEAR(-slope / curvature, -c12 / c22 * u, 0.01 * c12 / c22 * u);
    const double least = middle - slope * slope / (2 * curvature);
    EXPECT_NEAR(2 * least / (u * u), c11 - c12 * c12 / c22, 0.001 * c11);
  }
}

TEST(Fabric, HasTheStressOfAnEvenStrain) {
  ClothSpec spec = fabric_spec(6, 5, 0.02, 0.01);
  Fabric& fabric = *spec.material.fabric;
  fabric.poisson = 0.2;
  const auto& [c11, c22] = fabric.stretch_stiffness;
  const double c12 = 0.2 * std::sqrt(c11 * c22), u = 2e-5, v = -1e-5, shear = 3e-5;
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, Points::Zero(cloth.num_points(), 3), 0};
  state.positions.col(0) =
      (1 + u) * cloth.rest_positions.col(0) + shear * cloth.rest_positions.col(1);
  state.positions.col(1) = (1 + v) * cloth.rest_positions.col(1);
  std::vector<double> tensions;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const double length = (state.positions.row(b) - state.positions.row(a)).norm();
    tensions.push_back(run.stiffness * (length - run.rest_length));
  });
  const Vector3 stress = membrane_stress(cloth, state, tensions).colwise().mean();
  EXPECT_NEAR(stress.x(), c11 * u + c12 * v, 1e-4 * c11 * u);
  EXPECT_NEAR(stress.y(), c12 * u + c22 * v, 1e-4 * c11 * u);
  EXPECT_NEAR(stress.z(), fabric.shear_stiffness * shear, 1e-4 * c11 * u);
}

TEST(Fabric, AnyShearStiffnessIsPossible) {
  // More than that of stretch, on cells of any shape, and alone.
  for (const double stretch : {0.0, 1.0, 900.0}) {
    ClothSpec spec = fabric_spec(5, 4, 0.04, 0.01);
    spec.material.fabric->stretch_stiffness = {stretch, stretch};
    spec.material.fabric->shear_stiffness = 500;
    EXPECT_NEAR(2 * energy_per_area(spec, 0, 0, 1e-4) / 1e-8, 500, 0.5);
    EXPECT_NEAR(2 * energy_per_area(spec, 1e-4, 0, 0) / 1e-8, stretch, 0.001 * stretch);
  }
}

TEST(Fabric, MassesAreThoseOfTheAreaThatPointsOwn) {
  const ClothSpec spec = fabric_spec(5, 4, 0.02, 0.01);
  const Cloth cloth = make_grid(spec);
  const double cell = 0.02 * 0.01 * spec.material.density;
  EXPECT_NEAR(cloth.mass.sum(), spec.width * spec.height * spec.material.density, 1e-15);
  EXPECT_NEAR(cloth.mass[0], cell / 4, 1e-18);
  EXPECT_NEAR(cloth.mass[1], cell / 2, 1e-18);
  EXPECT_NEAR(cloth.mass[6], cell, 1e-18);
  const Cloth chain = make_grid(fabric_spec(1, 4, 0.02, 0.01));
  EXPECT_NEAR(chain.mass[0], cell / 2, 1e-18);
  EXPECT_NEAR(chain.mass[1], cell, 1e-18);
}

// ---- Bending

/// Energy per area over the square of the curvature, of a sheet bent to a cylinder whose axis is at
/// `angle` from the weft: twice that is the bending stiffness there.
double bending_stiffness_at(double angle, double du, double dv) {
  ClothSpec spec = fabric_spec(41, 41, du, dv);
  spec.material.springs = {false, false, true};
  const Cloth cloth = make_grid(spec);
  Points x = cloth.rest_positions;
  const double curvature = 0.5;
  for (int i = 0; i < cloth.num_points(); ++i) {
    const double s = std::cos(angle) * x(i, 0) + std::sin(angle) * x(i, 1);
    x(i, 2) = curvature * s * s / 2;  // shallow: its second derivative is the curvature
  }
  return 2 * elastic_energy(cloth, x) / (spec.width * spec.height * curvature * curvature);
}

TEST(Fabric, BendsAsAskedForInAllDirections) {
  // B = B_u c^4 + B_v s^4 + 2 sqrt(B_u B_v) c^2 s^2. Stencils reach to one point from the edge: 1
  // of 40 cells are missing along a thread.
  for (const auto& [du, dv] : {std::pair(0.01, 0.01), std::pair(0.02, 0.01)}) {
    for (const double angle : {0.0, M_PI / 4, M_PI / 2, 0.4}) {
      const double c2 = std::pow(std::cos(angle), 2), s2 = 1 - c2;
      const double expected = std::pow(std::sqrt(3e-5) * c2 + std::sqrt(1e-5) * s2, 2);
      EXPECT_NEAR(bending_stiffness_at(angle, du, dv), expected, 0.03 * expected) << angle;
    }
  }
}

TEST(Fabric, BendingIsNoneOfStretch) {
  // Any affine map of the flat cloth, to rounding of 4 B / du^2 |x|^2.
  ClothSpec spec = fabric_spec(8, 6, 0.02, 0.01);
  spec.material.springs = {false, false, true};
  const Cloth cloth = make_grid(spec);
  Eigen::Matrix3d map;
  map << 1.3, 0.2, 0, -0.1, 0.7, 0, 0.4, 0.5, 1;
  EXPECT_LT(elastic_energy(cloth, cloth.rest_positions * map), 1e-20);
}

}  // namespace
}  // namespace clothsim::fabric_test
