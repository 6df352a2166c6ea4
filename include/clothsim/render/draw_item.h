#pragma once

#include <array>
#include <optional>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/render/gpu_mesh.h"
#include "clothsim/render/shading.h"

namespace clothsim {

/// Lines of one colour: `count` of the mesh's lines from the `first` one on.
struct LineRange {
  int first;
  int count;
  int family;  // index into Wireframe's families and colours
};

/// Id of the cloth in the mask, or of the first of several. Those of colliders start at 2, and
/// those of further cloths after the last collider's.
constexpr int cloth_id = 1;

/// The pose of a mesh.
struct Placement {
  Eigen::Matrix3d rotation;  // from its frame to the world's axes
  Vector3 origin;            // [m] in the world
};

/// An object to draw, a mesh or a part of one: its pose and look. Points to data of others.
struct DrawItem {
  const GpuMesh* mesh;
  const Points* positions;  // [m] of the mesh's vertices, in its frame
  const std::vector<std::array<int, 3>>* triangles;
  IndexRange own_points;         // those of the object
  IndexRange own_triangles;      // the same
  std::vector<LineRange> lines;  // in drawing order
  const Shading* shading;
  int id;  // in the mask
  bool is_cloth;
  Eigen::Matrix3d rotation;             // from the mesh's frame to the world's axes
  Vector3 translation;                  // [m] of the mesh's origin from the camera
  std::optional<Placement> before;      // at the last picture; empty: not visible then
  std::optional<double> sphere_radius;  // [m] of a sphere about the mesh's origin
  bool is_unbounded = false;
  double dip = 0;  // [m] bound on the depth of the cloth's triangles below this object's surface
};

}  // namespace clothsim
