#include "clothsim/shapes/mass_properties.h"

#include <gtest/gtest.h>

#include <cmath>

#include "clothsim/shapes/mesh_file.h"
#include "meshes.h"

namespace clothsim::mass_properties_test {
namespace {

using namespace test;

/// The mass properties of the points of a lattice within a shape: those of the shape up to the
/// spacing.
MassProperties sampled(const Shape& shape, double reach, int steps) {
  MassProperties result;
  Matrix3 second = Matrix3::Zero();
  Vector3 first = Vector3::Zero();
  double count = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; j < steps; ++j) {
      for (int k = 0; k < steps; ++k) {
        const Vector3 p = reach * (2 * (Vector3(i, j, k).array() + 0.5) / steps - 1).matrix();
        if (signed_distance(shape, p, p).value > 0) continue;
        first += p;
        second += p * p.transpose();
        ++count;
      }
    }
  }
  result.center = first / count;
  const Matrix3 spread = second / count - result.center * result.center.transpose();
  result.inertia = spread.trace() * Matrix3::Identity() - spread;
  return result;
}

void expect_near(const MassProperties& a, const MassProperties& b, double tolerance) {
  EXPECT_LT((a.center - b.center).norm(), tolerance) << a.center.transpose();
  EXPECT_LT((a.inertia - b.inertia).norm(), tolerance) << a.inertia;
}

TEST(MassProperties, AreThoseOfAllPointsWithin) {
  const std::vector<Shape> shapes = {Sphere{0.3}, Cuboid{{0.2, 0.4, 0.5}}, Cylinder{0.5, 0.2},
                                     Capsule{0.3, 0.15}};
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(shape.index());
    const auto exact = mass_properties(shape);
    ASSERT_TRUE(exact);
    expect_near(*exact, sampled(shape, 0.4, 160), 4e-4);
  }
}

TEST(MassProperties, OfAMeshAreThoseOfTheSameBoxAwayFromTheOrigin) {
  const Vector3 size(0.2, 0.3, 0.5), offset(0.4, -0.1, 0.2);
  const auto of_mesh = mass_properties(mesh_shape(moved(box_soup(size), offset)));
  ASSERT_TRUE(of_mesh);
  MassProperties expected = *mass_properties(Cuboid{size});
  expected.center = offset;
  expect_near(*of_mesh, expected, 1e-14);
}

TEST(MassProperties, AreNoneWithoutAVolume) {
  EXPECT_FALSE(mass_properties(Plane{}));
  TriangleSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  MeshShape sheet;
  sheet.file = std::make_shared<const MeshFile>(
      MeshFile{Solid(soup, Bounds::sheet), "file:///sheet", {1, 1, 1}});
  EXPECT_FALSE(mass_properties(sheet));
}

}  // namespace
}  // namespace clothsim::mass_properties_test
