#include "clothsim/render/mesh.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// A grid of (columns + 1) x (rows + 1) vertices, uv from 0 to 1, with its triangles and lines. The
/// caller sets positions, normals and tangents.
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

Mesh capsule_mesh(const Capsule& capsule, int columns, int rows) {
  // Rows on each round end and on the cylinder between, in proportion to their lengths.
  const double arc = M_PI / 2 * capsule.radius, profile_length = 2 * arc + capsule.length;
  const int round = std::max(2, static_cast<int>(std::lround(rows * arc / profile_length)));
  const int straight = std::max(1, rows - 2 * round);

  Mesh mesh = grid_mesh(columns, 2 * round + straight);
  for (Eigen::Index i = 0; i < mesh.uv.rows(); ++i) {
    const double around = 2 * M_PI * mesh.uv(i, 0);
    const int row = static_cast<int>(i) / (columns + 1);
    const int below = std::min(row, round);                  // rows so far: lower end,
    const int along = std::clamp(row - round, 0, straight);  // cylinder,
    const int above = std::max(row - round - straight, 0);   // upper end
    const double up = M_PI / 2 * (below + above - round) / round;
    const Vector3 n(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around), std::sin(up));
    const double middle = capsule.length * (1.0 * along / straight - 0.5);
    mesh.normals.row(i) = n;
    mesh.positions.row(i) = capsule.radius * n + middle * Vector3::UnitZ();
    mesh.tangents.row(i) << -std::sin(around), std::cos(around), 0;
    mesh.uv(i, 1) =
        (arc * (below + above) / round + capsule.length * along / straight) / profile_length;
  }
  return mesh;
}

Mesh cylinder_mesh(const Cylinder& cylinder, int columns, int rows) {
  // Rings from the middle of one end over the side to the middle of the other.
  const double profile_length = 2 * cylinder.radius + cylinder.length;
  const int flat =
      std::max(1, static_cast<int>(std::lround(rows * cylinder.radius / profile_length)));
  const int straight = std::max(1, rows - 2 * flat);
  Mesh mesh;
  const auto add = [&](const Mesh& part, const auto& place) {
    const auto first = static_cast<int>(mesh.positions.rows()), count = int(part.uv.rows());
    for (Points* rows_of : {&mesh.positions, &mesh.normals, &mesh.tangents}) {
      rows_of->conservativeResize(first + count, 3);
    }
    mesh.uv.conservativeResize(first + count, 2);
    for (int i = 0; i < count; ++i) {
      const double around = 2 * M_PI * part.uv(i, 0);
      const Vector3 out(std::cos(around), std::sin(around), 0);
      const auto [radius, height, normal, along] = place(part.uv(i, 1), out);
      mesh.positions.row(first + i) = radius * out + height * Vector3::UnitZ();
      mesh.normals.row(first + i) = normal;
      mesh.tangents.row(first + i) << -std::sin(around), std::cos(around), 0;
      mesh.uv.row(first + i) << part.uv(i, 0), along / profile_length;
    }
    for (const auto& [a, b, c] : part.triangles)
      mesh.triangles.push_back({first + a, first + b, first + c});
    for (const auto& [a, b] : part.lines) mesh.lines.push_back({first + a, first + b});
  };
  struct Place {
    double radius, height;
    Vector3 normal;
    double along;  // share of the whole length
  };
  const double r = cylinder.radius, l = cylinder.length;
  add(grid_mesh(columns, flat), [&](double v, const Vector3&) {
    return Place{v * r, -l / 2, -Vector3::UnitZ(), v * r};
  });
  add(grid_mesh(columns, straight), [&](double v, const Vector3& out) {
    return Place{r, (v - 0.5) * l, out, r + v * l};
  });
  add(grid_mesh(columns, flat), [&](double v, const Vector3&) {
    return Place{(1 - v) * r, l / 2, Vector3::UnitZ(), r + l + v * r};
  });
  return mesh;
}

Mesh box_mesh(const Vector3& half_sides, int segments) {
  const Mesh face = grid_mesh(segments, segments);
  const auto count = static_cast<int>(face.uv.rows());
  Mesh mesh;
  mesh.positions.resize(6 * count, 3);
  mesh.normals.resize(6 * count, 3);
  mesh.tangents.resize(6 * count, 3);
  mesh.uv = face.uv.replicate(6, 1);
  for (int side = 0; side < 6; ++side) {
    // Normal along an axis, u and v along the two after it, turned so that u x v is the normal.
    const int axis = side / 2, sign = side % 2 == 0 ? 1 : -1;
    const Vector3 normal = sign * Vector3::Unit(axis);
    const Vector3 along_u = sign * Vector3::Unit((axis + 1) % 3),
                  along_v = Vector3::Unit((axis + 2) % 3);
    const int first = side * count;
    for (int i = 0; i < count; ++i) {
      const double u = face.uv(i, 0), v = face.uv(i, 1);
      const Vector3 at = normal + (2 * u - 1) * along_u + (2 * v - 1) * along_v;
      mesh.positions.row(first + i) = at.cwiseProduct(half_sides);
      mesh.normals.row(first + i) = normal;
      mesh.tangents.row(first + i) = along_u;
    }
    for (const auto& [a, b, c] : face.triangles) {
      mesh.triangles.push_back({first + a, first + b, first + c});
    }
    for (const auto& [a, b] : face.lines) mesh.lines.push_back({first + a, first + b});
  }
  return mesh;
}

}  // namespace clothsim
