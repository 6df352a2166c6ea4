// The kernels of a mesh's forces beside plain loops over triangles and stencils.

#include "clothsim/dynamics/triangle_forces.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/model/triangle_fabric.h"
#include "unit/plain_forces.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::triangle_forces_test {
namespace {

using namespace test;

/// `positions` and `velocities` as in compute_forces().
Points plain_forces(const Cloth& cloth, const Loads& loads, const Points& positions,
                    const Points* velocities) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  Points forces = cloth.mass * loads.gravity.transpose();
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const Vector3 pulls = triangle_pulls(cloth, t, positions, velocities);
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = cloth.triangles[t][k], b = cloth.triangles[t][(k + 1) % 3];
      const Eigen::RowVector3d pull =
          2 * pulls[static_cast<Eigen::Index>(k)] * (positions.row(b) - positions.row(a));
      forces.row(a) += pull;
      forces.row(b) -= pull;
    }
  }
  std::vector<Vector3> rotations(fabric.pieces.size(), Vector3::Zero());
  if (velocities) rotations = bend_rotations(cloth, positions, *velocities, {});
  for (const PatchBend& bend : fabric.bends) {
    const int piece = fabric.piece_of(bend.points[0]);
    Vector3 pull = bend.of(positions);
    if (velocities) {
      const Vector3& omega = rotations[static_cast<std::size_t>(piece)];
      pull += fabric.internal_damping_at(bend.points[0])[1] *
              (bend.of(*velocities) - omega.cross(bend.of(positions)));
    }
    for (std::size_t k = 0; k < PatchBend::size; ++k) {
      forces.row(bend.points[k]) -= bend.stiffness * bend.coefficients[k] * pull.transpose();
    }
  }
  return forces;
}

/// Two sheets, the points of one with even numbers and those of the other with odd ones.
MeshTriangles interleaved(const Sheet& sheet) {
  const MeshTriangles one = triangles_of(sheet);
  MeshTriangles both;
  for (const Vector3& vertex : one.vertices) {
    both.vertices.push_back(vertex);
    both.vertices.emplace_back(vertex + Vector3::UnitZ());
  }
  for (const auto& [i, j, k] : one.triangles) {
    both.triangles.push_back({2 * i, 2 * j, 2 * k});
    both.triangles.push_back({2 * i + 1, 2 * j + 1, 2 * k + 1});
  }
  return both;
}

TEST(TriangleForces, EqualThePlainLoops) {
  // 1, 2, 6, 8, 10 and 70 triangles: blocks of eight that are full or not.
  MeshTriangles alone;
  alone.vertices = {Vector3(0, 0, 0), Vector3(0.1, 0, 0), Vector3(0, 0.1, 0)};
  alone.triangles.push_back({0, 1, 2});
  const std::vector<MeshTriangles> meshes{alone,
                                          triangles_of({2, 2}),
                                          triangles_of({2, 4}),
                                          triangles_of({3, 3}),
                                          triangles_of({2, 6}),
                                          triangles_of({8, 6, 0.7, 0.5, 0.4, 0.3, 0, true}),
                                          interleaved({6, 5, 0.5, 0.4, 0.4, 0.3})};
  Loads loads;
  loads.gravity = {1, -2, -9.8};
  for (const MeshTriangles& mesh : meshes) {
    for (const double bending : {0.0, 1e-3}) {
      for (const auto& damping :
           std::vector<std::array<double, 2>>{{0, 0}, {0.01, 0}, {0, 0.02}, {0.01, 0.02}}) {
        Material material = fabric_spec(2, 2, 0.1, 0.1).material;
        material.fabric->bending_stiffness = {bending, 3 * bending};
        material.fabric->internal_damping = damping;
        const Cloth cloth = make_cloth(mesh_spec(mesh, material, 0.4));
        const Points x = moved(cloth, 0.02), v = moved(cloth, 0.3, 4);
        const Points* const velocities = is_damped(cloth) ? &v : nullptr;
        Points forces;
        compute_forces(cloth, loads, x, forces, {}, &v);
        const Points expected = plain_forces(cloth, loads, x, velocities);
        EXPECT_LT((forces - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff())
            << mesh.triangles.size() << " triangles, bending " << bending << ", damping "
            << damping[0] << ' ' << damping[1];
      }
    }
  }
}

TEST(TriangleForces, AreTheSameForAnyMeshBeforeInTheThread) {
  // The kernels keep numbers of the largest mesh so far.
  const Material material = fabric_spec(2, 2, 0.1, 0.1).material;
  const Cloth small = make_cloth(mesh_spec(triangles_of({3, 3}), material));
  const Points x = moved(small, 0.02), v = moved(small, 0.3, 4);
  const Points before = forces_at(small, x, &v);
  const Cloth large = make_cloth(mesh_spec(triangles_of({20, 20}), material));
  forces_at(large, moved(large, 0.02), nullptr);
  EXPECT_EQ(forces_at(small, x, &v), before);
}

TEST(TriangleForces, OfACurvedClothAreTheSameWithThreads) {
  Material material = fabric_spec(2, 2, 0.1, 0.1).material;
  material.fabric->bending_stiffness = {1e-3, 1e-3};
  material.fabric->internal_damping = {0.01, 0.02};
  MeshTriangles mesh = triangles_of({60, 50, 0.7, 0.5, 0.4, 0.2});
  for (Vector3& vertex : mesh.vertices) vertex.z() = 0.02 * std::sin(20 * vertex.x());
  const Cloth cloth = make_cloth(curved_spec(mesh, material));
  ASSERT_GT(cloth.triangle_fabric->curved.size(), 5000u);
  const Points x = moved(cloth, 1e-3), v = moved(cloth, 0.1, 4);
  EXPECT_EQ(forces_at(cloth, x, &v, Workers(4)), forces_at(cloth, x, &v));
}

}  // namespace
}  // namespace clothsim::triangle_forces_test
