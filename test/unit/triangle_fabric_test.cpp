// A fabric on a mesh: strains, curvatures, forces, Hessians and frequencies.

#include "clothsim/model/triangle_fabric.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/implicit_euler.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/internal_damping.h"
#include "clothsim/dynamics/membrane_stress.h"
#include "clothsim/dynamics/newton_solver.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "clothsim/dynamics/xpbd.h"
#include "unit/plain_forces.h"
#include "unit/plain_rotation.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::triangle_fabric_test {
namespace {

using namespace test;

Material material() {
  Material m = fabric_spec(2, 2, 0.1, 0.1).material;
  m.fabric->shear_stiffness = 80;
  m.fabric->poisson = 0.1;
  m.fabric->bending_stiffness = {3e-3, 1e-3};
  return m;
}

const Sheet uneven{8, 6, 0.7, 0.5, 0.4, 0.3, 0, true};

Cloth sheet(const Material& m = material(), const Sheet& shape = uneven) {
  return make_cloth(mesh_spec(triangles_of(shape), m, shape.warp));
}

TEST(TriangleFabric, HasTheMassOfItsArea) {
  const Cloth cloth = sheet();
  EXPECT_NEAR(cloth.mass.sum(), fabric_density * 0.7 * 0.5, 1e-15);
  EXPECT_TRUE((cloth.mass.array() > 0).all());
}

TEST(TriangleFabric, EvenStrainsHaveTheSameStressInEachTriangle) {
  // In the axes of the fabric, which are turned by 0.4 against those of the sheet.
  const Cloth cloth = sheet();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(0.4).toRotationMatrix();
  Eigen::Matrix2d stretch;
  stretch << 1.03, 0.02, -0.01, 0.98;
  Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
  map.topLeftCorner<2, 2>() = turn * stretch * turn.transpose();
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Vector3(1, -2, 0.5).normalized()).toRotationMatrix();
  State state{cloth.rest_positions * (rotation * map).transpose(),
              Points::Zero(cloth.num_points(), 3), 0};

  const Eigen::Matrix2d green = (stretch.transpose() * stretch - Eigen::Matrix2d::Identity()) / 2;
  const double coupling = 0.1 * std::sqrt(900.0 * 700.0);
  const Vector3 expected(900 * green(0, 0) + coupling * green(1, 1),
                         coupling * green(0, 0) + 700 * green(1, 1), 2 * 80 * green(0, 1));
  const Points stress =
      membrane_stress(cloth, state, edge_tensions(cloth, state.positions, nullptr));
  for (Eigen::Index t = 0; t < stress.rows(); ++t) {
    EXPECT_LT((stress.row(t).transpose() - expected).norm(), 1e-10 * expected.norm()) << t;
  }
  // No force on points inside.
  const Points forces = forces_at(cloth, state.positions);
  for (int i = 0; i < cloth.num_points(); ++i) {
    const Vector3 x = row(cloth.rest_positions, i);
    const bool inside = x.x() > 1e-9 && x.x() < 0.7 - 1e-9 && x.y() > 1e-9 && x.y() < 0.5 - 1e-9;
    if (inside) {
      EXPECT_LT(forces.row(i).norm(), 1e-10) << i;
    }
  }
}

TEST(TriangleFabric, EvenMeshesHaveTheCurvaturesOfQuadraticSurfaces) {
  Material m = material();
  m.fabric->bending_stiffness = {2e-3, 5e-4};
  m.springs = {false, false, true};
  for (const double warp : {0.0, 0.3, M_PI / 4, M_PI / 2}) {
    const Sheet even{41, 31, 0.4, 0.3, warp};
    const Cloth cloth = sheet(m, even);
    // z = k x^2 / 2: curvature k across the direction at angle `warp` to the threads.
    Points x = cloth.rest_positions;
    constexpr double k = 0.1;
    x.col(2) = k / 2 * x.col(0).array().square();
    const double c2 = std::pow(std::cos(warp), 2), s2 = std::pow(std::sin(warp), 2);
    const double stiffness = std::pow(std::sqrt(2e-3) * c2 + std::sqrt(5e-4) * s2, 2);
    // The first and last column of triangles have half of their kinks.
    const double energy = stiffness * k * k / 2 * 0.39 * 0.3;
    EXPECT_NEAR(elastic_energy(cloth, x), energy, 1e-9 * energy + (warp > 0 ? 0.02 * energy : 0))
        << warp;
  }
}

/// Distance of a point of a sheet of 0.4 x 0.3 m from its border [m].
double from_border(const Vector3& x) { return std::min({x.x(), 0.4 - x.x(), x.y(), 0.3 - x.y()}); }

TEST(TriangleFabric, UnevenMeshesHaveTheCurvaturesOfQuadraticSurfaces) {
  Material m = material();
  m.fabric->bending_stiffness = {1, 1};
  m.springs = {false, false, true};
  Sheet shape{21, 16, 0.4, 0.3};
  shape.uneven = 0.2;
  const Cloth cloth = sheet(m, shape);
  const double cell = 0.02;
  Points x = cloth.rest_positions;
  constexpr double uu = 0.1, vv = -0.3, uv = 0.2;
  for (int i = 0; i < cloth.num_points(); ++i) {
    x(i, 2) = uu / 2 * x(i, 0) * x(i, 0) + vv / 2 * x(i, 1) * x(i, 1) + uv * x(i, 0) * x(i, 1);
  }
  const std::array<double, 3> expected{uu, vv, uv};
  const std::vector<PatchBend>& bends = cloth.triangle_fabric->bends;
  for (std::size_t b = 0; b < bends.size(); ++b) {
    double nearest = infinity;
    for (std::size_t k = 0; k < 3; ++k) {
      nearest = std::min(nearest, from_border(row(cloth.rest_positions, bends[b].points[k])));
    }
    if (nearest < 1.3 * cell) continue;  // its neighbours have fewer points
    EXPECT_NEAR(bends[b].of(x).z(), expected[b % 3], 0.04) << b;  // where edges are even enough
  }
  // Any constant moment is in equilibrium: its forces are sums of A times the coefficients.
  Points forces = Points::Zero(cloth.num_points(), 3);  // by each component of the moment
  for (std::size_t b = 0; b < bends.size(); ++b) {
    for (std::size_t k = 0; k < PatchBend::size; ++k) {
      forces(bends[b].points[k], static_cast<Eigen::Index>(b % 3)) +=
          bends[b].stiffness * bends[b].coefficients[k];
    }
  }
  int inside = 0;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (from_border(row(cloth.rest_positions, i)) < 2.7 * cell) continue;
    EXPECT_LT(forces.row(i).norm(), 1e-11) << i;
    ++inside;
  }
  EXPECT_GT(inside, 100);
}

TEST(TriangleFabric, AnEasedSeamIsFlat) {
  // An edge of 1 m in one panel and 1.5 m in the other.
  auto mesh = std::make_shared<ClothMesh>();
  mesh->positions.resize(4, 3);
  mesh->positions << 0, 0, 0, 1.25, 0, 0, 0.5, -1, 0, 0.75, 1, 0;
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}};
  using Flat = ClothMesh::Flat;
  mesh->flat = {{Flat(0, 0), Flat(0.4, -1), Flat(1, 0)}, {Flat(0, 0), Flat(1.5, 0), Flat(0.9, 1)}};
  mesh->uv.setZero(4, 2);
  ClothSpec spec;
  spec.mesh = mesh;
  spec.columns = 4;
  spec.rows = 1;
  spec.material = material();
  const Cloth cloth = make_cloth(spec);
  EXPECT_EQ(cloth.triangle_fabric->bends.size(), 6U);
  for (const PatchBend& bend : cloth.triangle_fabric->bends) {
    EXPECT_LT(bend.of(mesh->positions).norm(), 1e-12);
  }
}

TEST(TriangleFabric, AFreeEdgeIsStraightUnderCurvatureAlongItAndTwist) {
  Material m = material();
  m.fabric->bending_stiffness = {1, 1};
  m.springs = {false, false, true};
  Sheet shape{11, 7, 0.4, 0.3};
  shape.uneven = 0.3;
  const Cloth cloth = sheet(m, shape);
  Points x = cloth.rest_positions;
  for (const bool twisted : {false, true}) {
    for (int i = 0; i < cloth.num_points(); ++i) {
      x(i, 2) = twisted ? x(i, 0) * x(i, 1) : x(i, 0) * x(i, 0) / 2;
    }
    int count = 0;
    const std::vector<PatchBend>& bends = cloth.triangle_fabric->bends;
    for (std::size_t b = 1; b < bends.size(); b += 3) {  // curvature across the lower edge
      int at_edge = 0;
      double nearest_end = infinity;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 p = row(cloth.rest_positions, bends[b].points[k]);
        at_edge += p.y() < 1e-9;
        nearest_end = std::min(nearest_end, std::min(p.x(), 0.4 - p.x()));
      }
      if (at_edge < 2 || nearest_end < 0.05) continue;
      EXPECT_LT(std::abs(bends[b].of(x).z()), 0.1) << twisted << b;
      ++count;
    }
    EXPECT_GT(count, 4);
  }
}

TEST(TriangleFabric, FlatSheetsHaveNoBendingUnderAnyEvenStrain) {
  const Cloth cloth = sheet();
  Eigen::Matrix3d map;
  map << 1.2, 0.3, 0, -0.1, 0.7, 0, 0.4, 0.2, 1;
  const Points x = cloth.rest_positions * map.transpose();
  for (const PatchBend& bend : cloth.triangle_fabric->bends) {
    EXPECT_LT(bend.of(x).norm(), 1e-11);
  }
}

TEST(TriangleFabric, ForcesAreMinusTheGradientOfTheEnergy) {
  const Cloth cloth = sheet();
  const Points x = moved(cloth, 0.03);
  const Points forces = forces_at(cloth, x);
  const auto energy = [&](const Points& at) { return elastic_energy(cloth, at); };
  EXPECT_LT(gradient_error(energy, x, -forces), 1e-6 * forces.cwiseAbs().maxCoeff());
}

TEST(TriangleFabric, ForcesAreTheSameWithThreads) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  const Cloth cloth = sheet(m, {60, 50, 0.7, 0.5, 0.4, 0.3, 0, true});
  const Points x = moved(cloth, 0.001), v = moved(cloth, 0.1, 4);
  Points one, four;
  compute_forces(cloth, Loads{}, x, one, {}, &v);
  compute_forces(cloth, Loads{}, x, four, Workers(4), &v);
  EXPECT_EQ(one, four);
}

TEST(TriangleFabric, ForcesHaveNoSumAndNoTorque) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  const Cloth cloth = sheet(m);
  const Points x = moved(cloth, 0.03), v = moved(cloth, 0.3, 4);
  const Points forces = forces_at(cloth, x, &v);
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < cloth.num_points(); ++i) torque += row(x, i).cross(row(forces, i));
  const double scale = forces.cwiseAbs().maxCoeff();
  EXPECT_LT(forces.colwise().sum().norm(), 1e-12 * scale);
  EXPECT_LT(torque.norm(), 1e-12 * scale);
}

TEST(TriangleFabric, DampingLeavesRotationAlone) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  const Cloth cloth = sheet(m);
  const Points x = moved(cloth, 0.03);
  Points v = x;
  const Vector3 omega(1, -2, 3);
  for (int i = 0; i < cloth.num_points(); ++i) v.row(i) = omega.cross(row(x, i)).transpose();
  const Points undamped = forces_at(cloth, x);
  EXPECT_LT((forces_at(cloth, x, &v) - undamped).norm(), 1e-12 * undamped.norm());
}

TEST(TriangleFabric, DampingOfBendsIsTheSumOverStencilsLessARotation) {
  Material m = material();
  m.fabric->internal_damping = {0, 0.02};
  const Cloth cloth = sheet(m);
  const Points x = moved(cloth, 0.03), v = moved(cloth, 0.3, 4);
  Points expected = forces_at(cloth, x);
  const Vector3 omega = test::plain_rotation(cloth, x, v);
  for (const PatchBend& bend : cloth.triangle_fabric->bends) {
    const Vector3 pull = 0.02 * bend.stiffness * (bend.of(v) - omega.cross(bend.of(x)));
    for (std::size_t k = 0; k < PatchBend::size; ++k) {
      expected.row(bend.points[k]) -= bend.coefficients[k] * pull.transpose();
    }
  }
  EXPECT_LT((forces_at(cloth, x, &v) - expected).cwiseAbs().maxCoeff(),
            1e-12 * expected.cwiseAbs().maxCoeff());
}

TEST(TriangleFabric, DampingOfBendsIsFiniteAndResistsMotionOfAnyCloth) {
  Material m = material();
  m.fabric->internal_damping = {0, 0.02};
  const Cloth cloth = sheet(m);
  const Points v = moved(cloth, 0.3, 4);
  for (const double most : {0.0, 1e-300, 1e-17, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-3}) {
    const Points x = moved(cloth, most);
    const Points damping = forces_at(cloth, x, &v) - forces_at(cloth, x);
    ASSERT_TRUE(damping.allFinite()) << most;
    EXPECT_LT(damping.cwiseProduct(v).sum(), 0) << most;
    Points relative, expected = 0 * x;
    remove_rotation(cloth, x, v, relative);
    for_each_bent_pair(cloth, [&](double weight, int i, int j) {
      const Eigen::RowVector3d pull = 0.02 * weight * (relative.row(j) - relative.row(i));
      expected.row(i) += pull;
      expected.row(j) -= pull;
    });
    // The two sum in another order, which shows where bends are as short as rounding errors.
    EXPECT_LT((damping - expected).norm(), 5e-3 * expected.norm()) << most;
  }
}

TEST(TriangleFabric, DampingGradientIsThatOfItsPotential) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  const Cloth cloth = sheet(m);
  const Points x = moved(cloth, 0.03);
  const Past past = past_of(cloth, moved(cloth, 0.03, 5), moved(cloth, 0.03, 6), 1e-2);
  Points gradient = Points::Zero(cloth.num_points(), 3);
  add_damping_gradient(cloth, past, x, gradient);
  const auto potential = [&](const Points& at) { return damping_potential(cloth, past, at); };
  EXPECT_LT(gradient_error(potential, x, gradient), 1e-6 * gradient.cwiseAbs().maxCoeff());
}

TEST(TriangleFabric, NewtonFindsTheMinimumOfAStep) {
  Material m = material();
  m.fabric->internal_damping = {0.01, 0.02};
  ClothSpec spec = mesh_spec(triangles_of(uneven), m, 0.4);
  spec.pinned = {{0, 0, "", {}}, {7, 0, "", {}}};
  const Cloth cloth = make_cloth(spec);
  const Points y = moved(cloth, 0.01);
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

TEST(TriangleFabric, FrequenciesAreBelowTheirBound) {
  for (const double size : {1e-6, 0.01, 0.03}) {
    const Cloth cloth = sheet();
    const Points x = moved(cloth, size);
    const double exact = exact_omega(cloth, x), bound = omega_max_bound(cloth, x);
    EXPECT_LE(exact, bound * (1 + 1e-6)) << size;
    EXPECT_LE(bound, 1.7 * exact) << size;
    EXPECT_EQ(omega_max_bound(cloth, x, 2 * bound), 2 * bound);
  }
}

TEST(TriangleFabric, HasNoBoundOfFrequenciesAtAnyStretch) {
  const Cloth cloth = sheet();
  EXPECT_GT(omega_max_bound(cloth, 3 * cloth.rest_positions),
            3 * omega_max_bound(cloth, cloth.rest_positions));
  EXPECT_TRUE(std::isinf(omega_max_bound(cloth)));
}

TEST(TriangleFabric, XpbdConvergesToImplicitEuler) {
  Material m = material();
  m.fabric->internal_damping = {0.005, 0.01};
  ClothSpec spec = mesh_spec(triangles_of(uneven), m, 0.4);
  spec.pinned = {{0, 0, "", {}}, {7, 0, "", {}}};
  const Cloth cloth = make_cloth(spec);
  State one{moved(cloth, 0.01), Points::Zero(cloth.num_points(), 3), 0};
  for (const int pin : cloth.pinned) one.positions.row(pin) = cloth.rest_positions.row(pin);
  State two = one;
  ImplicitEuler::Parameters exact;
  exact.tolerance = 1e-10;
  ImplicitEuler(exact).step(cloth, Loads{}, 2e-3, one);
  Xpbd::Parameters many;
  many.iterations = 4000;
  Xpbd(many).step(cloth, Loads{}, 2e-3, two);
  EXPECT_LT((one.positions - two.positions).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(TriangleFabric, SpringsOfABatchShareNoPoint) {
  const Cloth cloth = sheet();
  int batch = 0;
  std::vector<bool> taken(static_cast<std::size_t>(cloth.num_points()), false);
  for (const SpringRun& run : cloth.springs) {
    EXPECT_GE(run.batch, batch);
    if (run.batch != batch) taken.assign(taken.size(), false);
    batch = run.batch;
    for (const int i : {run.first, run.first + run.offset}) {
      EXPECT_FALSE(taken[static_cast<std::size_t>(i)]);
      taken[static_cast<std::size_t>(i)] = true;
    }
  }
  EXPECT_LT(batch, 16);
}

TEST(TriangleFabric, AMeshNeedsAFabric) {
  ClothSpec spec = mesh_spec(triangles_of(uneven), material());
  spec.material.fabric.reset();
  EXPECT_THROW(make_cloth(spec), InvalidValue);
}

}  // namespace
}  // namespace clothsim::triangle_fabric_test
