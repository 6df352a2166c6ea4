#include "clothsim/render/solid_mesh.h"

namespace clothsim {
namespace {

/// Cosine of the angle below which adjacent faces are drawn smooth.
constexpr double smooth = 0.77;

}  // namespace

Mesh solid_mesh(const Solid& solid, double padding) {
  const std::vector<Vector3>& vertices = solid.vertices();
  std::vector<std::array<int, 3>> triangles = solid.triangles();
  if (solid.is_sheet()) {  // the other side
    for (const auto& [a, b, c] : solid.triangles()) triangles.push_back({a, c, b});
  }
  const auto at = [&](int i) -> const Vector3& { return vertices[static_cast<std::size_t>(i)]; };
  std::vector<Vector3> areas;  // normal times twice the area
  std::vector<std::vector<int>> faces_at(vertices.size());
  for (const auto& [a, b, c] : triangles) {
    const int face = static_cast<int>(areas.size());
    areas.push_back((at(b) - at(a)).cross(at(c) - at(a)));
    for (const int i : {a, b, c}) faces_at[static_cast<std::size_t>(i)].push_back(face);
  }

  Mesh mesh;
  const auto count = static_cast<Eigen::Index>(3 * triangles.size());
  for (Points* rows : {&mesh.positions, &mesh.normals, &mesh.tangents}) rows->resize(count, 3);
  mesh.uv.resize(count, 2);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vector3 flat = areas[t].isZero(0) ? Vector3::UnitZ() : areas[t].stableNormalized();
    Eigen::Index axis = 0;
    flat.cwiseAbs().maxCoeff(&axis);
    // u x v points out of the face.
    const double sign = flat[axis] < 0 ? -1 : 1;
    const Vector3 along_u = sign * Vector3::Unit((axis + 1) % 3);
    const Vector3 along_v = Vector3::Unit((axis + 2) % 3);
    const int first = static_cast<int>(3 * t);
    for (int k = 0; k < 3; ++k) {
      const int vertex = triangles[t][static_cast<std::size_t>(k)];
      Vector3 normal = Vector3::Zero();
      for (const int face : faces_at[static_cast<std::size_t>(vertex)]) {
        const Vector3& area = areas[static_cast<std::size_t>(face)];
        if (area.dot(flat) > smooth * area.norm()) normal += area;
      }
      normal = normal.isZero(0) ? flat : Vector3(normal.stableNormalized());
      const Eigen::Index i = first + k;
      mesh.positions.row(i) = at(vertex) + padding * normal;
      mesh.normals.row(i) = normal;
      mesh.tangents.row(i) = (along_u - normal.dot(along_u) * normal).normalized();
      mesh.uv.row(i) << at(vertex).dot(along_u), at(vertex).dot(along_v);
      mesh.lines.push_back({first + k, first + (k + 1) % 3});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace clothsim
