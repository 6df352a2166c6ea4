#pragma once

#include "clothsim/model/point_run.h"
#include "clothsim/shapes/collider.h"
#include "clothsim/shapes/solid.h"

namespace clothsim {

/// A pose as vector loops use it: local = turn^T (world - origin).
struct Frame {
  explicit Frame(const Pose& pose)
      : turn(pose.orientation.toRotationMatrix()), origin(pose.position) {}

  Eigen::Matrix3d turn;
  Vector3 origin;  // [m]
};

/// Options of a query to a mesh; other shapes ignore them.
struct MeshQuery {
  double near = infinity;                          // [m] see Solid::distance_within()
  Solid::Neighbourhood* neighbourhoods = nullptr;  // of the points; null: not kept
};

/// Signed distances [m] of `count` points of the world from the surface of a solid at `frame`, and
/// their normals in the world. `sides`: where the points came from, when the solid was at `before`;
/// see signed_distance(). `query`: options for a mesh.
void signed_distances(const Shape&, const Frame& frame, PointRun points, const Frame& before,
                      PointRun sides, int count, const MeshQuery& query, double* distances,
                      MutablePointRun normals);

}  // namespace clothsim
