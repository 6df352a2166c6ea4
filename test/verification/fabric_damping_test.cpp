// Fabrics in each method: internal damping, stable steps, Newton's matrix.

#include <cmath>

#include "algebra.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/join_cloths.h"
#include "unit/plain_forces.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::fabric_damping_test {
namespace {

using namespace test;

template <typename Method>
class FabricDampingByMethod : public ::testing::Test {};
TYPED_TEST_SUITE(FabricDampingByMethod, EachMethod);

// ---- Internal damping

/// A strip without weight, its end pushed aside by a thousandth of its length.
State bent_strip(const ClothSpec& spec, const Cloth& cloth) {
  State state = start_state(spec, cloth, 1);
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0) continue;
    const double clamp = cloth.rest_positions(1, 0) / 2;
    const double s = (state.positions(i, 0) - clamp) / strip_length;
    state.positions(i, 2) = 1e-3 * strip_length * s * s * (3 - s) / 2;  // nearly the first mode
  }
  return state;
}

TYPED_TEST(FabricDampingByMethod, InternalDampingTakesItsShareOfTheFirstMode) {
  // z'' + tau omega^2 z' + omega^2 z = 0: a swing decays by exp(-tau omega^2 t / 2). With omega =
  // 3.516 sqrt(B / rho) / L^2 of a clamped strip. Steps h of implicit Euler damp as a tau of h.
  ClothSpec spec = strip(10, 16, false);
  Fabric& fabric = *spec.material.fabric;
  fabric.stretch_stiffness = {500, 500};
  fabric.shear_stiffness = 50;
  const double omega = 3.516 * std::sqrt(fabric.bending_stiffness[0] / spec.material.density) /
                       std::pow(strip_length, 2);
  const double tau = 0.1 / omega;  // 5 % of critical
  fabric.internal_damping = {0, tau};
  const Cloth cloth = make_grid(spec);
  State state = bent_strip(spec, cloth);
  TypeParam method = converged<TypeParam>();
  const Loads none{Vector3::Zero()};
  const bool is_explicit = std::isfinite(TypeParam::stability_limit);
  const double h =
      is_explicit ? 0.5 * TypeParam::stability_limit / omega_max_bound(cloth, cloth.rest_positions)
                  : 2 * M_PI / omega / 400;
  // Peaks of the swing after one period and after four.
  const int period = static_cast<int>(2 * M_PI / omega / h + 0.5);
  const int end = cloth.columns + cloth.columns - 1;
  double first = 0, fourth = 0;
  for (int i = 0; i < 5 * period; ++i) {
    method.step(cloth, none, h, state);
    const double height = std::abs(state.positions(end, 2));
    const double periods = double(i) / period;
    if (periods > 0.8 && periods < 1.2) first = std::max(first, height);
    if (periods > 3.7 && periods < 4.3) fourth = std::max(fourth, height);
  }
  constexpr bool damps =
      std::is_same_v<TypeParam, ImplicitEuler> || std::is_same_v<TypeParam, Xpbd>;
  const double expected = (tau + (damps ? h : 0)) * omega * omega / 2;
  const double rate = std::log(first / fourth) / (3 * 2 * M_PI / omega);
  EXPECT_NEAR(rate, expected, 0.05 * expected);
}

TYPED_TEST(FabricDampingByMethod, InternalDampingLetsAClothFallAndTurnFreely) {
  // Any motion of a rigid body of a flat cloth: its centre of mass falls, its spin stays.
  ClothSpec spec = fabric_spec(6, 5, 0.02, 0.02);
  spec.material.fabric->internal_damping = {1e-3, 5e-2};
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  const Vector3 spin(0.2, -0.1, 0.5);
  const Vector3 centre = state.positions.transpose() * cloth.mass / cloth.mass.sum();
  for (int i = 0; i < cloth.num_points(); ++i) {
    state.velocities.row(i) =
        spin.cross(row(state.positions, i) - centre).transpose() + Eigen::RowVector3d(1, 0, 0);
  }
  const Vector3 before = angular_momentum(cloth, state);
  const State start = state;
  TypeParam method = converged<TypeParam>();
  const double h =
      std::isfinite(TypeParam::stability_limit)
          ? 0.5 * TypeParam::stability_limit / omega_max_bound(cloth, cloth.rest_positions)
          : 1e-3;
  const int steps = static_cast<int>(0.2 / h);
  run(method, cloth, Loads{Vector3::Zero()}, h, steps, state);
  EXPECT_LT((momentum(cloth, state) - momentum(cloth, start)).norm(),
            1e-9 * momentum(cloth, start).norm());
  EXPECT_LT((angular_momentum(cloth, state) - before).norm(), 2e-3 * before.norm());
}

TYPED_TEST(FabricDampingByMethod, InternalDampingTakesNoSpinOfABentCloth) {
  // A sheet bent to a third of a cylinder turns about the cylinder's axis. Methods that lose spin
  // by their own steps lose no more with damping.
  const auto kept_with = [](double tau) {
    ClothSpec spec = fabric_spec(9, 5, 0.02, 0.02);
    spec.material.fabric->internal_damping = {0, tau};
    const Cloth cloth = make_grid(spec);
    State state = start_state(spec, cloth, 1);
    const double radius = 3 * spec.width / (2 * M_PI);
    for (int i = 0; i < cloth.num_points(); ++i) {
      const double angle = cloth.rest_positions(i, 0) / radius;
      state.positions(i, 0) = radius * std::sin(angle);
      state.positions(i, 2) = -radius * std::cos(angle);
    }
    const Vector3 spin(0, 10, 0);
    for (int i = 0; i < cloth.num_points(); ++i) {
      state.velocities.row(i) = spin.cross(row(state.positions, i)).transpose();
    }
    const double before = angular_momentum(cloth, state).norm();
    TypeParam method = converged<TypeParam>();
    const double h =
        std::isfinite(TypeParam::stability_limit)
            ? 0.5 * TypeParam::stability_limit / omega_max_bound(cloth, cloth.rest_positions)
            : 1e-3;
    run(method, cloth, Loads{Vector3::Zero()}, h, static_cast<int>(0.3 / h), state);
    return angular_momentum(cloth, state).norm() / before;
  };
  const double undamped = kept_with(0), damped = kept_with(0.05);
  EXPECT_GE(damped, undamped - 2e-3);
  EXPECT_LE(damped, 1 + 2e-3);
}

TYPED_TEST(FabricDampingByMethod, InternalDampingTurnsNoClothThatHangsByOneCorner) {
  // Nothing has a torque about the vertical through the pin: angular momentum about it stays 0.
  // Implicit steps and xpbd have their own torque, second order in h.
  ClothSpec spec = fabric_spec(9, 8, 0.02, 0.02);
  spec.pinned = {{0, 0, ""}};
  spec.material.fabric->internal_damping = {1e-4, 2e-2};
  const Cloth cloth = make_grid(spec);
  State state = start_state(spec, cloth, 1);
  const Vector3 pin = row(state.positions, 0);
  const auto turning = [&](const Points& velocities) {
    double sum = 0, scale = 0;
    for (int i = 1; i < cloth.num_points(); ++i) {
      const Vector3 arm = row(state.positions, i) - pin;
      sum += cloth.mass[i] * arm.cross(row(velocities, i)).z();
      scale += cloth.mass[i] * arm.norm() * velocities.row(i).norm();
    }
    return std::abs(sum) / scale;
  };
  const bool is_explicit = std::isfinite(TypeParam::stability_limit);
  TypeParam method = converged<TypeParam>();
  const double h =
      is_explicit ? 0.5 * TypeParam::stability_limit / omega_max_bound(cloth, cloth.rest_positions)
                  : 1 / 360.0;
  for (int second = 0; second < 3; ++second) {
    run(method, cloth, Loads{}, h, static_cast<int>(1 / h), state);
    EXPECT_LT(turning(state.velocities), is_explicit ? 1e-9 : 5e-3) << second;
  }
}

// ---- Several cloths

/// A grid, a flat mesh without damping and one that is curved at rest.
std::vector<NamedCloth> three_cloths() {
  ClothSpec grid = fabric_spec(5, 4, 0.02, 0.02);
  grid.pinned = {{0, 0, ""}};
  grid.material.fabric->internal_damping = {1e-4, 2e-2};
  Material material = grid.material;
  material.fabric->internal_damping = {0, 0};
  const ClothSpec flat = mesh_spec(triangles_of({6, 4, 0.1, 0.06, 0.3, 0.2}), material);
  MeshTriangles bent = triangles_of({7, 5, 0.12, 0.08, 0.5, 0.2});
  for (Vector3& p : bent.vertices) p.z() = 0.02 * std::sin(60 * p.x());
  material.fabric->internal_damping = {3e-4, 5e-3};
  material.fabric->bending_stiffness = {2e-4, 1e-4};
  ClothSpec curved = curved_spec(bent, material);
  curved.pinned = {{3, 0, ""}};
  return {{"grid", grid}, {"flat", flat}, {"curved", curved}};
}

TYPED_TEST(FabricDampingByMethod, EachOfSeveralClothsHasItsOwnInternalDamping) {
  const std::vector<NamedCloth> cloths = three_cloths();
  const ClothSpec joined = join_cloths(cloths);
  const auto moved = [](const ClothSpec& spec, const State& start, double h) {
    const Cloth cloth = make_cloth(spec);
    TypeParam method = converged<TypeParam>();
    State state = start;
    run(method, cloth, Loads{}, h, 40, state);
    return state.positions;
  };
  const Cloth all = make_cloth(joined);
  State start = start_state(joined, all, 1);
  start.positions = shaken(all, 2e-3, 3);
  for (const int pin : all.pinned) start.positions.row(pin) = all.rest_positions.row(pin);
  const double h = std::isfinite(TypeParam::stability_limit)
                       ? 0.3 * TypeParam::stability_limit / omega_max_bound(all, start.positions)
                       : 2e-3;
  const Points together = moved(joined, start, h);
  for (std::size_t i = 0; i < cloths.size(); ++i) {
    const auto part = [&, &of = joined.parts[i]](const Points& points) {
      return Points(points.middleRows(of.first_point, of.num_points()));
    };
    const State own{part(start.positions), part(start.velocities), 0};
    const Points alone = moved(join_cloths({cloths[i]}), own, h);
    EXPECT_GT((alone - own.positions).norm(), 1e-3);
    EXPECT_LT((part(together) - alone).norm(), 1e-6 * (alone - own.positions).norm()) << i;
  }
}

// ---- Spectrum

TEST(FabricSteps, TheBoundOfSeveralClothsIsTheLargestOfEach) {
  const std::vector<NamedCloth> cloths = three_cloths();
  const auto bound = [](const ClothSpec& spec, double least) {
    const Cloth cloth = make_cloth(spec);
    return omega_max_bound(cloth, 1.05 * cloth.rest_positions, least);
  };
  double largest = 0;
  for (const NamedCloth& cloth : cloths) {
    largest = std::max(largest, bound(join_cloths({cloth}), 0));
  }
  const ClothSpec all = join_cloths(cloths);
  EXPECT_EQ(bound(all, 0), largest);
  EXPECT_EQ(bound(all, 1.1 * largest), 1.1 * largest);
  EXPECT_NEAR(bound(all, 0.9 * largest), largest, 1e-12 * largest);
}

TEST(FabricSteps, TheBoundIsNeverBelowTheExactFrequency) {
  for (const double poisson : {0.0, 0.6, -0.6}) {
    ClothSpec spec = fabric_spec(6, 5, 0.02, 0.01);
    spec.material.fabric->shear_stiffness = 600;
    spec.material.fabric->poisson = poisson;
    spec.pinned = {{0, 0, ""}};
    const Cloth cloth = make_grid(spec);
    for (const double size : {1e-4, 3e-3, 0.05}) {  // from almost flat to crumpled and torn
      for (const double scale : {0.7, 1.0, 1.5}) {
        const Points x = scale * shaken(cloth, size, 2);
        const double exact = exact_omega(cloth, x), bound = omega_max_bound(cloth, x);
        EXPECT_GE(bound, exact) << poisson << ' ' << size << ' ' << scale;
        EXPECT_EQ(omega_max_bound(cloth, x, 1.1 * bound), 1.1 * bound);
        EXPECT_NEAR(omega_max_bound(cloth, x, 0.9 * bound), bound, 1e-12 * bound);
      }
    }
    const Points flat = cloth.rest_positions;
    EXPECT_LT(omega_max_bound(cloth, flat), 1.6 * exact_omega(cloth, flat)) << poisson;
    EXPECT_TRUE(std::isinf(omega_max_bound(cloth)));
  }
}

TEST(FabricSteps, ExplicitStepsAreStableUpToTheBound) {
  // Bends as stiff as springs, and damping that takes as much of the limit as they do.
  for (const auto& damping : {std::array<double, 2>{0, 0}, {0, 1e-4}, {1e-4, 0}, {3e-5, 3e-5}}) {
    ClothSpec spec = fabric_spec(8, 8, 0.01, 0.01);
    spec.material.fabric->stretch_stiffness = {200, 200};
    spec.material.fabric->bending_stiffness = {5e-3, 5e-3};
    spec.material.fabric->internal_damping = damping;
    const Cloth cloth = make_grid(spec);
    const auto energy_after = [&](double share) {
      State state{shaken(cloth, 1e-7, 3), Points::Zero(cloth.num_points(), 3), 0};
      VelocityVerlet method;
      run(method, cloth, Loads{Vector3::Zero()},
          share * 2 / omega_max_bound(cloth, cloth.rest_positions), 3000, state);
      return total_energy(cloth, Loads{Vector3::Zero()}, state);
    };
    const double start = elastic_energy(cloth, shaken(cloth, 1e-7, 3));
    EXPECT_LT(energy_after(0.98), 100 * start) << damping[0] << " " << damping[1];
    EXPECT_FALSE(energy_after(1.8) < 1e6 * start) << damping[0] << " " << damping[1];
  }
}

// ---- Newton's method

/// Bends as stiff as springs, strongly damped.
Cloth damped_and_pinned(double dv = 0.02, double poisson = 0) {
  ClothSpec spec = fabric_spec(5, 4, 0.02, dv);
  spec.material.fabric->poisson = poisson;
  spec.pinned = {{0, 0, ""}, {4, 3, ""}};
  spec.material.fabric->bending_stiffness = {1e-2, 2e-2};
  spec.material.fabric->internal_damping = {2e-3, 4e-3};
  return make_grid(spec);
}

TEST(FabricSteps, NewtonsStepIsThatOfTheExactHessian) {
  // Stretched everywhere, so that nothing is clamped: one iteration from d = 0 is -H^-1 g with H by
  // central differences of the gradient. The past is flat and has no rotation, which H leaves out.
  for (const double poisson : {0.0, 0.4, -0.4}) {
    const Cloth cloth = damped_and_pinned(0.01, poisson);
    const int n = cloth.num_points();
    const Points y = 1.2 * shaken(cloth, 5e-4, 1);
    const Past past =
        past_of(cloth, State{1.1 * cloth.rest_positions, Points::Zero(n, 3), 0}, 1e-2);
    Scalars weights = (cloth.inv_mass.array() > 0).select(cloth.mass.array() / 1e-8, 0);
    const auto gradient_at = [&](const Points& d) {
      Points gradient(n, 3);
      potential_gradient(cloth, weights, y + d, d, gradient, past);
      return Eigen::VectorXd(gradient.reshaped());
    };
    Eigen::MatrixXd hessian(3 * n, 3 * n);
    const double e = 1e-7;
    for (int k = 0; k < 3 * n; ++k) {
      Points d = Points::Zero(n, 3);
      d(k % n, k / n) = e;
      hessian.col(k) = (gradient_at(d) - gradient_at(-d)) / (2 * e);
      const bool held = cloth.inv_mass[k % n] == 0;
      if (held) {
        hessian.col(k).setZero();
        hessian.row(k).setZero();
        hessian(k, k) = 1;
      }
    }
    for (const int pin : cloth.pinned) {
      for (int axis = 0; axis < 3; ++axis) hessian.row(axis * n + pin).setZero();
      for (int axis = 0; axis < 3; ++axis) hessian(axis * n + pin, axis * n + pin) = 1;
    }
    const Eigen::VectorXd expected = -solve(hessian, gradient_at(Points::Zero(n, 3)));
    NewtonSolver::Parameters once;
    once.max_iterations = 1;
    Points d;
    NewtonSolver(once).solve(cloth, weights, y, d, past);
    EXPECT_LT((d.reshaped() - expected).norm(), 1e-5 * expected.norm()) << poisson;
  }
}

TEST(FabricSteps, NewtonConvergesThoughItsHessianLeavesOutTheRotationOfDamping) {
  const Cloth cloth = damped_and_pinned();
  const int n = cloth.num_points();
  const Points y = 1.2 * shaken(cloth, 2e-4, 1);
  const Past past =
      past_of(cloth, State{1.1 * shaken(cloth, 2e-4, 2), Points::Zero(n, 3), 0}, 1e-2);
  const Scalars weights = (cloth.inv_mass.array() > 0).select(cloth.mass.array() / 1e-6, 0);
  const auto gradient_after = [&](int iterations) {
    NewtonSolver::Parameters parameters;
    parameters.tolerance = 1e-14;
    parameters.max_iterations = iterations;
    Points d, gradient;
    NewtonSolver(parameters).solve(cloth, weights, y, d, past);
    potential_gradient(cloth, weights, y + d, d, gradient, past);
    return gradient.norm();
  };
  EXPECT_LT(gradient_after(9), 1e-6 * gradient_after(1));
}

}  // namespace
}  // namespace clothsim::fabric_damping_test
