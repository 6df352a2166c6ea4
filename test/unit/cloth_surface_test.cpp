// The surface of a cloth from the triangles of a file.

#include "clothsim/geometry/cloth_surface.h"

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/model/errors.h"
#include "clothsim/shapes/mesh_file.h"
#include "says.h"
#include "temporary_folder.h"

namespace clothsim::cloth_surface_test {
namespace {

const Vector3 along_x(1, 0, 0);

/// Two triangles of a unit square, each with vertices of its own.
MeshTriangles square() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          {},
          {{0, 1, 2}, {3, 4, 5}}};
}

std::string mistake(const MeshTriangles& given, RestLengths lengths = RestLengths::surface) {
  try {
    make_cloth_mesh(given, along_x, lengths);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "";
}

TEST(ClothSurface, JoinsVerticesAtTheSamePlace) {
  const ClothMesh mesh = make_cloth_mesh(square(), along_x, RestLengths::surface);
  EXPECT_EQ(mesh.positions.rows(), 4);
  EXPECT_EQ(mesh.triangles[1], (std::array<int, 3>{0, 2, 3}));
  EXPECT_EQ(mesh_edges(mesh.triangles).size(), 5u);
}

TEST(ClothSurface, HasTheLengthsOfTheSurface) {
  MeshTriangles given = square();
  for (Vector3& x : given.vertices) x = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()) * x;
  const ClothMesh mesh = make_cloth_mesh(given, along_x, RestLengths::surface);
  for (std::size_t t = 0; t < 2; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      EXPECT_NEAR((mesh.flat[t][(k + 1) % 3] - mesh.flat[t][k]).norm(),
                  (mesh.positions.row(b) - mesh.positions.row(a)).norm(), 1e-15);
    }
  }
}

TEST(ClothSurface, HasTheLengthsOfItsTexture) {
  MeshTriangles given = square();
  for (const Vector3& x : given.vertices) given.uv.emplace_back(0.1 * x.x(), 0.3 * x.y());
  const ClothMesh mesh = make_cloth_mesh(given, along_x, RestLengths::uv);
  EXPECT_NEAR((mesh.flat[0][1] - mesh.flat[0][0]).norm(), 0.1, 1e-15);
  EXPECT_NEAR((mesh.flat[0][2] - mesh.flat[0][1]).norm(), 0.3, 1e-15);
}

TEST(ClothSurface, WarpHasTheDirectionGiven) {
  const ClothMesh mesh = make_cloth_mesh(square(), {1, 1, 5}, RestLengths::surface);
  // The diagonal lies along the part of warp in the plane.
  const ClothMesh::Flat diagonal = mesh.flat[0][2] - mesh.flat[0][0];
  EXPECT_NEAR(diagonal.x(), std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(diagonal.y(), 0, 1e-15);
}

TEST(ClothSurface, TurnsTrianglesTheSameWay) {
  MeshTriangles given = square();
  std::swap(given.triangles[1][0], given.triangles[1][1]);
  const ClothMesh mesh = make_cloth_mesh(given, along_x, RestLengths::surface);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3 x = row(mesh.positions, a);
    EXPECT_GT((row(mesh.positions, b) - x).cross(row(mesh.positions, c) - x).z(), 0);
  }
}

TEST(ClothSurface, TexturesEachPoint) {
  MeshTriangles given = square();
  for (Vector3& x : given.vertices) x.x() *= 3;
  EXPECT_EQ(make_cloth_mesh(given, along_x, RestLengths::surface).uv.row(2),
            Eigen::RowVector2d(1, 1));
  for (std::size_t i = 0; i < 6; ++i) given.uv.emplace_back(0.1 * static_cast<double>(i), 0.5);
  EXPECT_EQ(make_cloth_mesh(given, along_x, RestLengths::surface).uv.row(3),
            Eigen::RowVector2d(0.5, 0.5));
}

TEST(ClothSurface, RefusesMistakesWithTheirPlace) {
  EXPECT_TRUE(says(mistake({}), "... no triangles"));
  EXPECT_TRUE(
      says(mistake(square(), RestLengths::uv), "... no texture coordinates ... lengths: uv"));

  MeshTriangles three = square();
  three.vertices.emplace_back(0, 0, 1);
  three.triangles.push_back({0, 2, 6});
  EXPECT_TRUE(says(mistake(three), "... edge of three triangles, 0, 1 and 2 ... points 0 and 2"));

  MeshTriangles sliver = square();
  sliver.vertices[5] = {0.5, 0.501, 0};
  EXPECT_TRUE(
      says(mistake(sliver), "... triangle 1 at [0.5, 0.500 ... degrees ... at least 1 degree"));
  sliver.vertices[5] = {0, 0, 0};
  EXPECT_TRUE(says(mistake(sliver), "... triangle 1"));

  MeshTriangles stretched = square();
  for (const Vector3& x : stretched.vertices) stretched.uv.emplace_back(x.x(), 0.001 * x.y());
  EXPECT_TRUE(says(mistake(stretched, RestLengths::uv), "... at rest, triangle 0"));

  MeshTriangles crossed = square();
  crossed.vertices.insert(crossed.vertices.end(), {{0.5, 0.2, -1}, {0.6, 0.3, 1}, {0.8, 0.3, 0.5}});
  crossed.triangles.push_back({6, 7, 8});
  EXPECT_TRUE(says(mistake(crossed), "... triangle 0 ... through triangle 2"));
}

TEST(ClothSurface, RefusesLayersAtTheSamePlace) {
  MeshTriangles layers = square();
  const auto add_layer = [&](double height) {
    const int first = static_cast<int>(layers.vertices.size());
    for (const Vector3& x : square().vertices)
      layers.vertices.push_back(x + Vector3(0.1, 0.2, height));
    layers.triangles.push_back({first, first + 1, first + 2});
    layers.triangles.push_back({first + 3, first + 4, first + 5});
  };
  add_layer(0.01);
  EXPECT_EQ(mistake(layers), "");
  add_layer(1e-5);
  EXPECT_TRUE(says(mistake(layers), "... point ... on triangle ... between unjoined parts"));
}

TEST(ClothSurface, RefusesASurfaceWithOneSide) {
  // Moebius's band of five triangles.
  MeshTriangles band;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * M_PI * i / 5;
    band.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.3 * i * (4 - i));
    band.triangles.push_back({i, (i + 1) % 5, (i + 2) % 5});
  }
  EXPECT_TRUE(says(mistake(band), "... one side"));
}

TEST(ClothSurface, ReadsFiles) {
  const test::TemporaryFolder folder("mesh");
  const auto path = folder.path() / "square.obj";
  std::ofstream(path) << "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                         "f 1/1 2/2 3/3 4/4\n";
  const ClothMesh mesh =
      make_cloth_mesh(read_mesh_triangles(path, {0.5, 1, 1}), along_x, RestLengths::surface);
  EXPECT_EQ(mesh.positions.rows(), 4);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.positions.row(1), Eigen::RowVector3d(1, 0, 0));
  EXPECT_EQ(mesh.uv.row(2), Eigen::RowVector2d(1, 1));
}

}  // namespace
}  // namespace clothsim::cloth_surface_test
