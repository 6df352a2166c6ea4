#include "clothsim/shapes/signed_distances.h"

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// Arguments of all these loops, apart from the shape.
struct Run {
  const Frame& frame;
  PointRun points;
  const Frame& before;
  PointRun sides;
  int count;
  const MeshQuery& query;
  double* distances;
  MutablePointRun normals;
};

template <class S>
CLOTHSIM_TARGET_CLONES_OF_TEMPLATE void find(const S& shape, const Run& run) {
  const Eigen::Matrix3d turn = run.frame.turn;
  const Vector3 origin = run.frame.origin;
  const Vector3 side_axis = run.before.turn.col(2), side_origin = run.before.origin;
  const PointRun points = run.points, sides = run.sides;
  const MutablePointRun normals = run.normals;
  double* const distances = run.distances;
  for_each_lane(run.count, [&](int i) CLOTHSIM_INLINE {
    const double dx = points.x[i] - origin[0];
    const double dy = points.y[i] - origin[1];
    const double dz = points.z[i] - origin[2];
    const double side = side_axis[0] * (sides.x[i] - side_origin[0]) +
                        side_axis[1] * (sides.y[i] - side_origin[1]) +
                        side_axis[2] * (sides.z[i] - side_origin[2]);
    const NearSurface near =
        shape.near_surface(turn(0, 0) * dx + turn(1, 0) * dy + turn(2, 0) * dz,
                           turn(0, 1) * dx + turn(1, 1) * dy + turn(2, 1) * dz,
                           turn(0, 2) * dx + turn(1, 2) * dy + turn(2, 2) * dz, side);
    distances[i] = near.value;
    normals.x[i] = turn(0, 0) * near.x + turn(0, 1) * near.y + turn(0, 2) * near.z;
    normals.y[i] = turn(1, 0) * near.x + turn(1, 1) * near.y + turn(1, 2) * near.z;
    normals.z[i] = turn(2, 0) * near.x + turn(2, 1) * near.y + turn(2, 2) * near.z;
  });
}

/// A mesh: one point after the other, each with its neighbourhood.
void find(const MeshShape& mesh, const Run& run) {
  const Solid& solid = mesh.file->solid;
  for (int i = 0; i < run.count; ++i) {
    const Vector3 point(run.points.x[i], run.points.y[i], run.points.z[i]);
    Solid::Neighbourhood none;
    const auto [value, local] = solid.distance_within(
        run.query.near + mesh.padding, run.frame.turn.transpose() * (point - run.frame.origin),
        run.query.neighbourhoods ? run.query.neighbourhoods[i] : none);
    const Vector3 normal = run.frame.turn * local;
    run.distances[i] = value - mesh.padding;
    run.normals.x[i] = normal.x();
    run.normals.y[i] = normal.y();
    run.normals.z[i] = normal.z();
  }
}

}  // namespace

void signed_distances(const Shape& shape, const Frame& frame, PointRun points, const Frame& before,
                      PointRun sides, int count, const MeshQuery& query, double* distances,
                      MutablePointRun normals) {
  const Run run{frame, points, before, sides, count, query, distances, normals};
  std::visit([&](const auto& s) { find(s, run); }, shape);
}

}  // namespace clothsim
