#pragma once

#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// A rectangle of the grid of a cloth, some cells wide and high.
struct Patch {
  int columns;              // of points
  int rows;                 // of points
  std::vector<int> points;  // along rows, borders too
  std::vector<int> cells;   // along rows, counted as SurfaceMesh does
};

/// Cuts a cloth into patches of `size` x `size` cells, smaller ones at the last row and column.
std::vector<Patch> cut_into_patches(const Cloth&, int size);

/// How patches move against each other.
///
/// Each is followed as a rigid body, so that a cloth that turns as a whole does not seem to
/// move within itself: what no isometry changes, no distance shows. Where it crumples, the ways of
/// its points tell more.
class PatchMotions {
 public:
  /// The motion of `patches` between two sets of positions [m, N x 3, finite].
  void follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
              const Workers& = {});

  /// The most by which the distance of a point on p to one on q may have changed [m]. Both may be
  /// the same patch.
  double between(int p, int q) const;

 private:
  struct Motion {
    Vector3 from;  // centre
    Vector3 to;
    Eigen::Matrix3d rotation;
    double radius;  // farthest point from the centre, at the start [m]
    double strain;  // farthest that a point has gone from where the rigid body has it [m]
    Box ways;       // of its points [m]
  };

  std::vector<Motion> motions_;
};

}  // namespace clothsim
