#pragma once

#include <array>
#include <string>
#include <vector>

#include "clothsim/model/cloth_mesh.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Triangles as a file lists them.
struct MeshTriangles {
  std::vector<Vector3> vertices;              // [m]
  std::vector<Eigen::Vector2d> uv;            // texture coordinates by vertex; empty: none
  std::vector<std::array<int, 3>> triangles;  // of vertices
  bool has_texture = true;                    // false: uv are lengths alone
};

/// Lengths at rest: those of the surface, or differences of texture coordinates in metres.
enum class RestLengths { surface, uv };

/// The surface of `given` at rest. Vertices at the same place become one point; points have the
/// order in which triangles name them. Triangles that face the other way than their neighbours are
/// turned over; the first of each piece keeps its side.
///
/// With the lengths of the surface the warp of each triangle is the part of `warp` in its plane, or
/// where that is none, along its first edge. Texture coordinates outside [0, 1], or none, are
/// replaced by the place along `warp` and across it.
///
/// Throws InvalidValue, without a key, and with the place: no triangles, an edge of more than two
/// triangles, a surface with one side, a sliver (an angle below 1 degree in the file or at rest),
/// two triangles that pass through each other, a point that lies on a triangle of another part.
ClothMesh make_cloth_mesh(const MeshTriangles& given, const Vector3& warp, RestLengths lengths);

/// A place in a message: [x, y, z].
std::string place_text(const Vector3&);

/// Throws InvalidValue, without a key, for two triangles that pass through each other and for a
/// point that lies on a triangle without being one of its corners, nearer than a thousandth of its
/// longest edge.
void check_apart(const ClothMesh&);

}  // namespace clothsim
