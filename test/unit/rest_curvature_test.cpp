// A mesh whose triangles are curved at rest: forces, energies, Hessians and frequencies.

#include "clothsim/model/rest_curvature.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/implicit_euler.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/internal_damping.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/xpbd.h"
#include "meshes.h"
#include "unit/plain_forces.h"
#include "unit/plain_rotation.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::rest_curvature_test {
namespace {

using namespace test;

Material material() {
  Material m = fabric_spec(2, 2, 0.1, 0.1).material;
  m.fabric->shear_stiffness = 80;
  m.fabric->bending_stiffness = {3e-3, 1e-3};
  return m;
}

/// An uneven sheet rolled to an arc of `angle` [rad], with a crease of 1 rad along its middle.
MeshTriangles rolled(double angle) {
  const Sheet shape{9, 6, 0.7, 0.5, 0.4, 0.3, 0, true};
  MeshTriangles mesh = triangles_of(shape);
  const double radius = shape.width / angle;
  for (Vector3& p : mesh.vertices) {
    const double turn = p.x() / radius;
    const double up = std::max(0.0, p.y() - shape.height / 2);
    p = {(radius - up * std::sin(1.0)) * std::sin(turn), p.y() - up + up * std::cos(1.0),
         radius - (radius - up * std::sin(1.0)) * std::cos(turn)};
  }
  return mesh;
}

MeshTriangles triangles_of(const TriangleSoup& soup) {
  return {soup.vertices, {}, soup.triangles, true};
}

Cloth curved_cloth(const MeshTriangles& triangles, const Material& m = material(),
                   const std::vector<Pin>& pins = {}) {
  ClothSpec spec = curved_spec(triangles, m, 0.4);
  spec.pinned = pins;
  return make_cloth(spec);
}

/// Sheets, a ring, the smallest closed surface, whose triangles share all neighbours, and a raised
/// point of three triangles, each of which has it across two edges.
std::vector<Cloth> cloths(const Material& m = material()) {
  return {curved_cloth(rolled(0.3), m), curved_cloth(rolled(2), m),
          curved_cloth(triangles_of(torus_soup(0.2, 0.08, 9, 6)), m),
          curved_cloth({{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}},
                        {},
                        {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                        true},
                       m),
          curved_cloth({{{0, 0, 0},
                         {0.1, 0, 0},
                         {0.03, 0.1, 0},
                         {0.04, 0.03, 0.03},
                         {0.05, -0.08, 0},
                         {0.12, 0.1, 0.01},
                         {-0.06, 0.06, 0}},
                        {},
                        {{1, 3, 0}, {1, 2, 3}, {2, 0, 3}, {0, 4, 1}, {1, 5, 2}, {2, 6, 0}},
                        true},
                       m)};
}

TEST(RestCurvature, TheRestShapeHasNoForce) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  for (const Cloth& cloth : cloths()) {
    ASSERT_FALSE(cloth.triangle_fabric->curved.empty());
    for (const Points& x : {cloth.rest_positions, Points(cloth.rest_positions * turn)}) {
      EXPECT_LT(elastic_energy(cloth, x), 1e-20);
      EXPECT_LT(forces_at(cloth, x).cwiseAbs().maxCoeff(), 1e-9);
    }
    EXPECT_GT(elastic_energy(cloth, moved(cloth, 0.001)), 1e-6);
  }
}

TEST(RestCurvature, ForcesAreTheGradientOfTheEnergy) {
  for (const Cloth& cloth : cloths()) {
    for (const double most : {0.001, 0.02, 0.1}) {
      const Points x = moved(cloth, most), forces = forces_at(cloth, x);
      const auto energy = [&](const Points& at) { return elastic_energy(cloth, at); };
      EXPECT_LT(gradient_error(energy, x, -forces), 1e-6 * (1 + forces.cwiseAbs().maxCoeff()));
    }
  }
}

TEST(RestCurvature, ForcesHaveNoSumAndNoTorque) {
  for (const Cloth& cloth : cloths()) {
    const Points x = moved(cloth, 0.02), forces = forces_at(cloth, x);
    const double size = forces.rowwise().norm().sum();
    Vector3 torque = Vector3::Zero();
    for (int i = 0; i < cloth.num_points(); ++i) torque += row(x, i).cross(row(forces, i));
    EXPECT_LT(forces.colwise().sum().norm(), 1e-13 * size);
    EXPECT_LT(torque.norm(), 1e-13 * size);
  }
}

TEST(RestCurvature, FlatTrianglesOfACurvedMeshAreAsOthers) {
  const MeshTriangles flat = triangles_of(Sheet{8, 6, 0.7, 0.5, 0.4, 0.3, 0, true});
  const Cloth one = curved_cloth(flat), other = make_cloth(mesh_spec(flat, material(), 0.4));
  EXPECT_TRUE(one.triangle_fabric->curved.empty());
  EXPECT_EQ(forces_at(one, moved(one, 0.03)), forces_at(other, moved(other, 0.03)));
}

TEST(RestCurvature, DampingIsTheSumOverBendsLessARotation) {
  Material m = material();
  m.fabric->internal_damping = {0, 0.02};
  for (const Cloth& cloth : cloths(m)) {
    const Points x = moved(cloth, 0.02), v = moved(cloth, 0.3, 4);
    const Vector3 omega = plain_rotation(cloth, x, v);
    // A force is minus the derivative of half the power by the velocity of a point.
    const auto half_power = [&](const Points& rates) {
      double sum = 0;
      for (const PatchBend& bend : cloth.triangle_fabric->bends) {
        const Vector3 rate = bend.rate(x, rates) - omega.cross(bend.deviation(x));
        sum += 0.02 * bend.stiffness * rate.squaredNorm() / 2;
      }
      return sum;
    };
    const Points damping = forces_at(cloth, x, &v) - forces_at(cloth, x);
    EXPECT_LT(gradient_error(half_power, v, -damping), 1e-6 * damping.cwiseAbs().maxCoeff());
    Vector3 torque = Vector3::Zero();
    for (int i = 0; i < cloth.num_points(); ++i) torque += row(x, i).cross(row(damping, i));
    EXPECT_LT(damping.colwise().sum().norm(), 1e-12 * damping.norm());
    EXPECT_LT(torque.norm(), 1e-8 * damping.norm());
  }
}

TEST(RestCurvature, DampingGradientIsThatOfItsPotential) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  for (const Cloth& cloth : cloths(m)) {
    const Points x = moved(cloth, 0.03);
    const Past past = past_of(cloth, moved(cloth, 0.03, 5), moved(cloth, 0.03, 6), 1e-2);
    Points gradient = Points::Zero(cloth.num_points(), 3);
    add_damping_gradient(cloth, past, x, gradient);
    const auto potential = [&](const Points& at) { return damping_potential(cloth, past, at); };
    EXPECT_LT(gradient_error(potential, x, gradient), 1e-6 * gradient.cwiseAbs().maxCoeff());
  }
}

TEST(RestCurvature, PartsTurnWithoutDamping) {
  // One half turns about a line across the pleats, the other one rests.
  Material m = material();
  m.fabric->internal_damping = {0, 0.02};
  MeshTriangles pleats = triangles_of(Sheet{9, 13, 0.16, 0.24});
  for (Vector3& p : pleats.vertices) {
    const double along = p.x() / 0.04;
    p.z() = 0.02 * std::abs(along - std::round(along));
  }
  const Cloth cloth = curved_cloth(pleats, m);
  Points v = Points::Zero(cloth.num_points(), 3);
  for (int i = 0; i < cloth.num_points(); ++i) {
    const Vector3 x = row(cloth.rest_positions, i);
    if (x.y() > 0.12) v.row(i) = Vector3(5, 0, 0).cross(x - Vector3(0, 0.12, 0)).transpose();
  }
  const Points damped = forces_at(cloth, cloth.rest_positions, &v);
  for (int i = 0; i < cloth.num_points(); ++i) {
    const double y = cloth.rest_positions(i, 1);
    if (std::abs(y - 0.12) < 0.045) continue;  // bends that cross the axis
    EXPECT_LT(damped.row(i).norm(), 1e-12) << y;
  }
}

TEST(RestCurvature, LengthsOfTheRestShapeHaveTheAnglesOfTheStart) {
  // At twice the size in all directions, angles are the same.
  ClothSpec spec = curved_spec(rolled(2), material(), 0.4);
  ClothMesh mesh = *spec.mesh;
  for (auto& corners : mesh.flat) {
    for (auto& corner : corners) corner *= 2;
  }
  spec.mesh = std::make_shared<const ClothMesh>(mesh);
  const Cloth cloth = make_cloth(spec);
  EXPECT_LT(elastic_energy(cloth, 2 * cloth.rest_positions), 1e-20);
  EXPECT_GT(elastic_energy(cloth, cloth.rest_positions), 1);
}

TEST(RestCurvature, MirroredPanelsHaveTheSameAngles) {
  ClothSpec spec = curved_spec(rolled(2), material(), 0.4);
  ClothMesh mesh = *spec.mesh;
  for (auto& corners : mesh.flat) {
    for (auto& corner : corners) corner.x() *= -1;
  }
  spec.mesh = std::make_shared<const ClothMesh>(mesh);
  const Cloth cloth = make_cloth(spec);
  EXPECT_FALSE(cloth.triangle_fabric->curved.empty());
  EXPECT_LT(elastic_energy(cloth, cloth.rest_positions), 1e-20);
}

TEST(RestCurvature, RoundingOfAFileIsFlat) {
  for (const double size : {0.7, 0.035}) {  // cells of 0.1 m and of 5 mm
    MeshTriangles flat = triangles_of(Sheet{8, 8, size, size, 0.4, 0.1, 0, true});
    for (Vector3& p : flat.vertices) {
      p = (1e6 * Vector3(p.x(), p.y(), p.x() + p.y())).array().round() / 1e6;
    }
    EXPECT_TRUE(curved_cloth(flat).triangle_fabric->curved.empty()) << size;
  }
}

TEST(RestCurvature, ForcesOnOnePointAreThoseOfAll) {
  for (const Cloth& cloth : cloths()) {
    const TriangleFabric& fabric = *cloth.triangle_fabric;
    const Points x = moved(cloth, 0.02), v = moved(cloth, 0.3, 4);
    Points all = Points::Zero(cloth.num_points(), 3);
    std::vector<double> quads;
    for (int i = 0; i < cloth.num_points(); ++i) {
      for (const double value : {x(i, 0), x(i, 1), x(i, 2), 0.0}) quads.push_back(value);
    }
    add_curved_forces(fabric, QuadView{quads.data(), 4}, {}, all);
    add_curved_damping(fabric, 1, PointView(x), PointView(v), {}, {}, all);
    for (int i = 0; i < cloth.num_points(); ++i) {
      EXPECT_LT((curved_force_on(fabric, i, x, &v) - row(all, i)).norm(), 1e-13 * all.norm());
    }
  }
}

TEST(RestCurvature, CollapsedTrianglesHaveFiniteForces) {
  for (const Cloth& cloth : cloths()) {
    Points line = cloth.rest_positions;
    line.rightCols<2>().setZero();
    for (const Points& x : {Points(0 * line), line, Points(1e-9 * cloth.rest_positions)}) {
      EXPECT_TRUE(forces_at(cloth, x).allFinite());
      EXPECT_LT(forces_at(cloth, x).cwiseAbs().maxCoeff(), 1e3);
      EXPECT_TRUE(std::isfinite(elastic_energy(cloth, x)));
      EXPECT_TRUE(std::isfinite(omega_max_bound(cloth, x)));
    }
  }
}

TEST(RestCurvature, FrequenciesAreBelowTheirBound) {
  Material bends = material();  // with hardly anything else
  bends.fabric->stretch_stiffness = {1e-3, 1e-3};
  bends.fabric->shear_stiffness = 1e-3;
  for (const Material& m : {material(), bends}) {
    for (const Cloth& cloth : cloths(m)) {
      for (const double most : {0.0, 0.005, 0.02}) {
        const Points x = moved(cloth, most);
        const double exact = exact_omega(cloth, x), bound = omega_max_bound(cloth, x);
        EXPECT_LE(exact, bound * (1 + 1e-6)) << most;
        EXPECT_LE(bound, 6 * exact) << most;
      }
    }
  }
}

TEST(RestCurvature, NewtonsMatrixIsExactAtRest) {
  for (const Cloth& cloth : cloths()) {
    const Scalars weights = cloth.mass.array() / 1e-4;
    NewtonSolver::Parameters parameters;
    parameters.tolerance = 1e-9;
    NewtonSolver solver(parameters);
    Points d;
    // Errors fall by squares: 1e-6 of the displacement, then 1e-12.
    EXPECT_LE(solver.solve(cloth, weights, moved(cloth, 1e-6), d, Past{}), 3);
    EXPECT_FALSE(solver.unconverged());
  }
}

TEST(RestCurvature, NewtonFindsTheMinimumOfAStep) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  const Cloth cloth = curved_cloth(rolled(2), m, {{0, 0, "", {}}, {7, 0, "", {}}});
  const Points y = moved(cloth, 0.02);
  const Past past = past_of(cloth, State{cloth.rest_positions, 0 * cloth.rest_positions, 0}, 1e-2);
  const Scalars weights = (cloth.inv_mass.array() > 0).select(cloth.mass.array() / 1e-4, 0);
  NewtonSolver::Parameters parameters;
  parameters.tolerance = 1e-12;
  parameters.max_iterations = 100;
  NewtonSolver solver(parameters);
  Points d;
  solver.solve(cloth, weights, y, d, past);
  Points gradient(cloth.num_points(), 3);
  potential_gradient(cloth, weights, y + d, d, gradient, past);
  EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RestCurvature, XpbdConvergesToImplicitEuler) {
  for (const double damping : {0.0, 0.01}) {
    Material m = material();
    m.fabric->internal_damping = {0.005, damping};
    const Cloth cloth = curved_cloth(rolled(2), m, {{0, 0, "", {}}, {7, 0, "", {}}});
    State one{moved(cloth, 0.01), Points::Zero(cloth.num_points(), 3), 0};
    for (const int pin : cloth.pinned) one.positions.row(pin) = cloth.rest_positions.row(pin);
    State two = one;
    ImplicitEuler::Parameters exact;
    exact.tolerance = 1e-10;
    ImplicitEuler(exact).step(cloth, Loads{}, 2e-3, one);
    Xpbd::Parameters many;
    many.iterations = 4000;
    Xpbd(many).step(cloth, Loads{}, 2e-3, two);
    EXPECT_LT((one.positions - two.positions).cwiseAbs().maxCoeff(), 1e-8) << damping;
  }
}

TEST(RestCurvature, AnyNumberOfThreadsGivesTheSameBits) {
  for (const Cloth& cloth : cloths()) {
    const Points x = moved(cloth, 0.02);
    EXPECT_EQ(forces_at(cloth, x, nullptr, Workers(3)), forces_at(cloth, x));
  }
}

}  // namespace
}  // namespace clothsim::rest_curvature_test
