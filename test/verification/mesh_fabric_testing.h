#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "clothsim/geometry/cloth_surface.h"
#include "clothsim/model/make_cloth.h"
#include "verification/fabric_testing.h"

namespace clothsim::test {

/// A flat rectangle of triangles in the plane z = 0, its points in rows.
struct Sheet {
  int columns = 8;
  int rows = 6;
  double width = 0.7;   // [m]
  double height = 0.5;  // [m]
  double warp = 0;      // angle from x to the warp
  double uneven = 0;    // largest displacement of inner points, of a cell
  int straight = 0;     // columns on the left whose points are not displaced
  bool shuffled = false;
};

/// Its triangles, with diagonals at random where it is uneven.
inline MeshTriangles triangles_of(const Sheet& sheet, unsigned seed = 1) {
  std::mt19937 engine(seed);
  const auto random = [&] { return std::uniform_real_distribution<>(-1, 1)(engine); };
  const double dx = sheet.width / (sheet.columns - 1), dy = sheet.height / (sheet.rows - 1);
  MeshTriangles mesh;
  for (int row = 0; row < sheet.rows; ++row) {
    for (int column = 0; column < sheet.columns; ++column) {
      const bool inside_x = column >= std::max(1, sheet.straight) && column + 1 < sheet.columns;
      const bool inside_y = row > 0 && row + 1 < sheet.rows;
      const double x = column * dx + (inside_x ? sheet.uneven * dx * random() : 0);
      const double y = row * dy + (inside_x && inside_y ? sheet.uneven * dy * random() : 0);
      mesh.vertices.emplace_back(x, y, 0);
    }
  }
  for (int row = 0; row + 1 < sheet.rows; ++row) {
    for (int column = 0; column + 1 < sheet.columns; ++column) {
      const int i = row * sheet.columns + column, up = i + sheet.columns;
      if (sheet.uneven > 0 && random() > 0) {
        mesh.triangles.push_back({i, i + 1, up});
        mesh.triangles.push_back({i + 1, up + 1, up});
      } else {
        mesh.triangles.push_back({i, i + 1, up + 1});
        mesh.triangles.push_back({i, up + 1, up});
      }
    }
  }
  if (sheet.shuffled) std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), engine);
  return mesh;
}

/// The cloth of a sheet, of `material`; pinned at points in [from, to] along x.
inline ClothSpec mesh_spec(const MeshTriangles& triangles, const Material& material,
                           double warp = 0) {
  ClothSpec spec;
  spec.material = material;
  spec.mesh = std::make_shared<const ClothMesh>(
      make_cloth_mesh(triangles, Vector3(std::cos(warp), std::sin(warp), 0), RestLengths::surface));
  spec.columns = static_cast<int>(spec.mesh->positions.rows());
  spec.rows = 1;
  return spec;
}

/// The same, with the start as the shape at rest.
inline ClothSpec curved_spec(const MeshTriangles& triangles, const Material& material,
                             double warp = 0) {
  ClothSpec spec = mesh_spec(triangles, material, warp);
  ClothMesh mesh = *spec.mesh;
  mesh.curved.assign(mesh.triangles.size(), 1);
  spec.mesh = std::make_shared<const ClothMesh>(std::move(mesh));
  return spec;
}

}  // namespace clothsim::test
