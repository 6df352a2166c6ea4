#include "clothsim/render/mesh.h"

#include <cmath>

namespace clothsim {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// A grid of (columns + 1) x (rows + 1) vertices, uv from 0 to 1, with its triangles and lines.
/// Positions, normals and tangents are left to the caller.
Mesh grid_mesh(int columns, int rows) {
  const int stride = columns + 1;
  const int count = stride * (rows + 1);
  Mesh mesh;
  mesh.positions.resize(count, 3);
  mesh.normals.resize(count, 3);
  mesh.tangents.resize(count, 3);
  mesh.uv.resize(count, 2);
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c <= columns; ++c) {
      const int i = r * stride + c;
      mesh.uv.row(i) << double(c) / columns, double(r) / rows;
      if (c < columns) mesh.lines.push_back({i, i + 1});
      if (r < rows) mesh.lines.push_back({i, i + stride});
      if (c < columns && r < rows) {
        mesh.triangles.push_back({i, i + 1, i + stride + 1});
        mesh.triangles.push_back({i, i + stride + 1, i + stride});
      }
    }
  }
  return mesh;
}

}  // namespace

Mesh sphere_mesh(double radius, int columns, int rows) {
  Mesh mesh = grid_mesh(columns, rows);
  for (Eigen::Index i = 0; i < mesh.uv.rows(); ++i) {
    const double around = 2 * M_PI * mesh.uv(i, 0);
    const double up = M_PI * (mesh.uv(i, 1) - 0.5);
    const Vector3 n(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
    mesh.normals.row(i) = n;
    mesh.positions.row(i) = radius * n;
    mesh.tangents.row(i) << -std::sin(around), std::cos(around), 0;
  }
  return mesh;
}

Mesh plane_mesh(double extent, int segments) {
  Mesh mesh = grid_mesh(segments, segments);
  mesh.positions.col(0) = extent * (mesh.uv.col(0).array() - 0.5);
  mesh.positions.col(1) = extent * (mesh.uv.col(1).array() - 0.5);
  mesh.positions.col(2).setZero();
  mesh.normals.rowwise() = Vector3::UnitZ().transpose();
  mesh.tangents.rowwise() = Vector3::UnitX().transpose();
  mesh.uv = mesh.positions.leftCols<2>();
  return mesh;
}

Mesh box_mesh(const Vector3& half_sides) {
  Mesh mesh;
  mesh.positions.resize(24, 3);
  mesh.normals.resize(24, 3);
  mesh.tangents.resize(24, 3);
  mesh.uv.resize(24, 2);
  for (int face = 0; face < 6; ++face) {
    // Normal along an axis, u and v along the two after it, turned so that u x v is the normal.
    const int axis = face / 2, sign = face % 2 == 0 ? 1 : -1;
    const Vector3 normal = sign * Vector3::Unit(axis);
    const Vector3 along_u = sign * Vector3::Unit((axis + 1) % 3),
                  along_v = Vector3::Unit((axis + 2) % 3);
    for (int corner = 0; corner < 4; ++corner) {
      const int i = 4 * face + corner, u = corner & 1, v = corner >> 1;
      const Vector3 at = normal + (2 * u - 1) * along_u + (2 * v - 1) * along_v;
      mesh.positions.row(i) = at.cwiseProduct(half_sides);
      mesh.normals.row(i) = normal;
      mesh.tangents.row(i) = along_u;
      mesh.uv.row(i) << u, v;
    }
    const int i = 4 * face;
    mesh.triangles.insert(mesh.triangles.end(), {{i, i + 1, i + 3}, {i, i + 3, i + 2}});
    mesh.lines.insert(mesh.lines.end(), {{i, i + 1}, {i + 1, i + 3}, {i + 3, i + 2}, {i + 2, i}});
  }
  return mesh;
}

Mesh make_mesh(const Shape& shape, int segments, double extent) {
  return std::visit(
      Overloaded{[&](const Sphere& s) { return sphere_mesh(s.radius, segments, segments); },
                 [&](const Plane&) { return plane_mesh(extent, segments); }},
      shape);
}

}  // namespace clothsim
