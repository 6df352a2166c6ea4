#pragma once

#include "clothsim/model/point_run.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// A pose as vector loops take it: local = turn^T (world - origin).
struct Frame {
  explicit Frame(const Pose& pose)
      : turn(pose.orientation.toRotationMatrix()), origin(pose.position) {}

  Eigen::Matrix3d turn;
  Vector3 origin;  // [m]
};

/// Signed distances [m] of `count` points of the world from the surface of a solid at `frame`, and
/// their normals in the world. `sides`: where the points came from, when the solid was at `before`;
/// see signed_distance(). Of a mesh far away, distances nearer to 0 than that.
void signed_distances(const Shape&, const Frame& frame, PointRun points, const Frame& before,
                      PointRun sides, int count, double* distances, MutablePointRun normals);

}  // namespace clothsim
