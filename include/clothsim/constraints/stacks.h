#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/self_touches.h"
#include "clothsim/model/cloth.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Where a collider touches a cloth: at a point of it, or within a triangle.
struct ContactPoint {
  static constexpr int no_triangle = -1;

  int triangle;
  std::array<int, 3> points;      // its corners; a point alone stands thrice
  std::array<double, 3> weights;  // of the points, where it touches; sum 1
  Vector3 normal;                 // of the surface, towards the cloth, unit
  double distance;                // from it [m]; of a point it is found anew

  Vector3 place(const Points& positions) const {
    return weights[0] * row(positions, points[0]) + weights[1] * row(positions, points[1]) +
           weights[2] * row(positions, points[2]);
  }
};

/// A collider that may hold a cloth together with another one.
struct ContactManifold {
  const MovingCollider& collider;
  double offset;  // that points keep from it [m]
  std::vector<ContactPoint> contact_points;
};

/// Bounds of the normals of a surface where it touches a cloth.
using Normals = Eigen::AlignedBox3d;

/// False where no surface with normals within the one faces any within the other.
bool can_face(const Normals& a, const Normals& b);

/// Layers of a cloth between two colliders that face each other.
///
/// Each layer needs its thickness: a point needs the offset where it touches a collider, else what
/// the points that it lies upon need, and what keeps it from them; of several chains of layers down
/// to the collider the longest. A point that needs more between both than there is, or will be at
/// the step's end, is pinched. So one rule does for any number of layers.
class Stacks {
 public:
  /// How far from each other two colliders may hold a cloth, which keeps `offset` from either [m]:
  /// with so many layers that more are a pile and no grip.
  static double max_layer_height(const Cloth& cloth, double offset) {
    constexpr int max_layers = 8;
    return 2 * (offset + max_layers * cloth.thickness);
  }

  /// Pinches the points that the jaws leave no room in a step of h [s] from `start` [m, N x 3].
  void pinch(const ContactManifold& a, const ContactManifold& b, const Cloth&, const Points& start,
             double h, const SelfTouches*, Pinches&);

 private:
  /// A point that is between the jaws.
  struct Node {
    int point;
    bool is_between;  // where both touch one place of the cloth
    Pinches::ColliderDistance a, b;
  };

  /// One point lies upon another, as seen from jaw a. By number of their nodes.
  struct Edge {
    int below, above;
    double layer_height;  // that both need between them [m]
  };

  void add_contact_points(const ContactManifold& a, const ContactManifold& b, const Points& start);
  void add_edges(const ContactManifold& a, const ContactManifold& b, const Points& start,
                 double max_distance, const SelfTouches&);
  void propagate_heights();

  /// Number of the node of a point, if it is between the jaws; else less than 0.
  int node_between(int point, const ContactManifold& a, const ContactManifold& b,
                   const Points& start, double max_distance);
  /// A point where the jaws are so near; of several the nearest counts.
  void add(int point, const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b);

  std::vector<Node> nodes_;
  std::vector<int> node_of_;  // by point: its number, or why there is none
  std::vector<Edge> edges_;
};

}  // namespace clothsim
