#include "clothsim/model/surface.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render_fixture.h"

namespace clothsim::surface_test {
namespace {

/// z = 0.1 sin(6 x) cos(5 y) over the unit square.
double height(double x, double y) { return 0.1 * std::sin(6 * x) * std::cos(5 * y); }

Vector3 slope_x(double x, double y) { return {1, 0, 0.6 * std::cos(6 * x) * std::cos(5 * y)}; }
Vector3 slope_y(double x, double y) { return {0, 1, -0.5 * std::sin(6 * x) * std::sin(5 * y)}; }

TEST(Surface, NormalsAndTangentsApproachThoseOfASmoothSurface) {
  // Second order inside the grid: four times better with half the spacing.
  double last_error = 0;
  for (const int n : {21, 41}) {
    Snapshot snapshot = flat_cloth(n, n);
    Points positions = *snapshot.positions;
    for (Eigen::Index i = 0; i < positions.rows(); ++i)
      positions(i, 2) = height(positions(i, 0), positions(i, 1));
    move_cloth(snapshot, positions);
    const Mesh mesh = cloth_mesh(snapshot);
    double error = 0;
    for (int row = 1; row < n - 1; ++row)
      for (int column = 1; column < n - 1; ++column) {
        const int i = row * n + column;
        const double x = positions(i, 0), y = positions(i, 1);
        const Vector3 normal = slope_x(x, y).cross(slope_y(x, y)).normalized();
        const Vector3 tangent = slope_x(x, y).normalized();
        error = std::max({error, (mesh.normals.row(i).transpose() - normal).norm(),
                          (mesh.tangents.row(i).transpose() - tangent).norm()});
      }
    if (n == 41) {
      EXPECT_LT(error, 0.01);
      EXPECT_GT(last_error / error, 3.3);
      EXPECT_LT(last_error / error, 4.7);
    }
    last_error = error;
  }
}

TEST(Surface, TheBitangentOfAClothPointsAlongGrowingV) {
  const Mesh mesh = cloth_mesh(flat_cloth(4, 4));
  for (Eigen::Index i = 0; i < mesh.normals.rows(); ++i) {
    const Vector3 n = mesh.normals.row(i), t = mesh.tangents.row(i);
    EXPECT_NEAR((n.cross(t) - Vector3::UnitY()).norm(), 0, 1e-12);
  }
}

TEST(Surface, MeshesOfShapesHaveUnitNormalsOutwardAndTangentsAlongU) {
  for (const Mesh& mesh : {sphere_mesh(0.3, 20, 12), plane_mesh(2, 4), box_mesh({0.1, 0.2, 0.3}),
                           box_mesh({0.1, 0.2, 0.3}, 5), capsule_mesh({0.5, 0.1}, 12, 20),
                           capsule_mesh({1e-3, 0.1}, 12, 5), cylinder_mesh({0.5, 0.1}, 12, 20),
                           cylinder_mesh({1e-3, 0.1}, 12, 5)}) {
    for (const auto& t : mesh.triangles) {
      const Vector3 a = mesh.positions.row(t[0]), b = mesh.positions.row(t[1]),
                    c = mesh.positions.row(t[2]);
      const Vector3 area = (b - a).cross(c - a);
      const Vector3 n = mesh.normals.row(t[0]) + mesh.normals.row(t[1]) + mesh.normals.row(t[2]);
      EXPECT_GE(area.dot(n), -1e-15);
      // u grows along the tangent.
      const Eigen::Vector2d d1 = mesh.uv.row(t[1]) - mesh.uv.row(t[0]);
      const Eigen::Vector2d d2 = mesh.uv.row(t[2]) - mesh.uv.row(t[0]);
      const double det = d1.x() * d2.y() - d2.x() * d1.y();
      EXPECT_GT(det, 0);
      const Vector3 along_u = (d2.y() * (b - a) - d1.y() * (c - a)) / det;
      const Vector3 tangent = mesh.tangents.row(t[0]);
      if (area.norm() > 1e-9) {
        EXPECT_GT(along_u.dot(tangent), 0);
      }
    }
    for (Eigen::Index i = 0; i < mesh.normals.rows(); ++i) {
      EXPECT_NEAR(mesh.normals.row(i).norm(), 1, 1e-12);
      EXPECT_NEAR(mesh.tangents.row(i).norm(), 1, 1e-12);
      EXPECT_NEAR(mesh.normals.row(i).dot(mesh.tangents.row(i)), 0, 1e-12);
    }
  }
}

TEST(Surface, MeshesOfShapesLieOnTheirSurface) {
  for (const Shape& shape :
       {Shape(Capsule{0.5, 0.1}), Shape(Cuboid{{0.2, 0.3, 0.4}}), Shape(Cylinder{0.4, 0.1})}) {
    const Mesh mesh = drawing_of(shape).mesh(16, 1);
    for (Eigen::Index i = 0; i < mesh.positions.rows(); ++i) {
      const Vector3 p = mesh.positions.row(i), n = mesh.normals.row(i), out = p + 1e-3 * n;
      EXPECT_NEAR(signed_distance(shape, p, p).value, 0, 1e-12);
      EXPECT_NEAR(signed_distance(shape, out, out).value, 1e-3, 1e-12);
      EXPECT_GE(mesh.uv(i, 1), 0);
      EXPECT_LE(mesh.uv(i, 1), 1 + 1e-12);
    }
  }
}

void expect_unit_and_square(const Points& normals, const Points& tangents) {
  for (Eigen::Index i = 0; i < normals.rows(); ++i) {
    EXPECT_NEAR(normals.row(i).norm(), 1, 1e-9) << i;
    EXPECT_NEAR(tangents.row(i).norm(), 1, 1e-9) << i;
    EXPECT_NEAR(normals.row(i).dot(tangents.row(i)), 0, 1e-9) << i;
  }
}

TEST(Surface, CollapsedClothsHaveFiniteNormals) {
  const Snapshot snapshot = flat_cloth(6, 6);
  const Cloth& cloth = *snapshot.cloth;
  for (const Vector3& scale : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0),
                               Vector3(1, 1e-12, 0), Vector3(1e-150, 1e-150, 0)}) {
    const Points positions = *snapshot.positions * scale.asDiagonal();
    const Points normals = vertex_normals(positions, cloth.triangles);
    expect_unit_and_square(normals, vertex_tangents(positions, cloth.uv, cloth.triangles, normals));
  }
}

TEST(Surface, AFoldThatCancelsTakesTheNormalOfItsLargestTriangle) {
  // Two triangles on top of each other, the second turned over and twice as large.
  Points positions(4, 3);
  positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0;
  const std::vector<std::array<int, 3>> equal{{0, 1, 2}, {1, 0, 3}};
  const Points normals = vertex_normals(positions, equal);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::abs(normals(i, 2)), 1, 1e-12) << i;
  EXPECT_NEAR(normals(2, 2), 1, 1e-12);
  EXPECT_NEAR(normals(3, 2), -1, 1e-12);
}

}  // namespace
}  // namespace clothsim::surface_test
