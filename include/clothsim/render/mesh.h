#pragma once

#include <array>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/shapes/capsule.h"
#include "clothsim/shapes/cylinder.h"

namespace clothsim {

/// Triangles with the attributes of their vertices. N is the number of vertices.
struct Mesh {
  Points positions;                             // [m], N x 3
  Points normals;                               // unit, N x 3
  Points tangents;                              // unit, along growing u, N x 3
  Eigen::Matrix<double, Eigen::Dynamic, 2> uv;  // N x 2, v upwards in the image
  std::vector<std::array<int, 3>> triangles;    // counter-clockwise seen from outside
  std::vector<std::array<int, 2>> lines;        // the grid the triangles come from
};

/// Sphere of columns x rows faces. Vertices lie on the sphere.
Mesh sphere_mesh(double radius, int columns, int rows);

/// Square z = 0 with normal +z of segments x segments faces.
Mesh plane_mesh(double extent, int segments);

/// Capsule of columns x at least `rows` faces, of about one size along.
Mesh capsule_mesh(const Capsule&, int columns, int rows);

/// Cylinder of columns x at least `rows` faces, its ends separate from its side.
Mesh cylinder_mesh(const Cylinder&, int columns, int rows);

/// Box about the origin with segments x segments faces on each side.
Mesh box_mesh(const Vector3& half_sides, int segments = 1);

}  // namespace clothsim
