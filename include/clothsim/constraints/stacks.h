#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/self_touches.h"
#include "clothsim/model/cloth.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// A contact of a collider with a cloth: at a point of it, or within a triangle.
struct ContactPoint {
  static constexpr int no_triangle = -1;

  int triangle;
  std::array<int, 3> points;      // corners of the triangle; a single point three times
  std::array<double, 3> weights;  // of the points at the contact; sum 1
  Vector3 normal;                 // of the surface, towards the cloth, unit
  double distance;                // from the surface [m]; for a point it is measured again
  double nearer = 0;              // Cloth::nearer_by() of its points [m]

  Vector3 place(const Points& positions) const {
    return weights[0] * row(positions, points[0]) + weights[1] * row(positions, points[1]) +
           weights[2] * row(positions, points[2]);
  }
};

/// A collider that may hold a cloth together with another one, and its contacts.
struct ContactManifold {
  const MovingCollider& collider;
  double offset;  // distance that points keep from it, those of the thickest cloth [m]
  std::vector<ContactPoint> contact_points;
};

/// Bounds of the normals of a surface where it touches a cloth.
using Normals = Eigen::AlignedBox3d;

/// False where no normal within one of the bounds faces any within the other.
bool can_face(const Normals& a, const Normals& b);

/// Layers of a cloth between two colliders that face each other.
///
/// Each layer needs its thickness. The layer_height of a point is the offset where it touches a
/// collider, else that of the point it lies upon plus the distance that both keep; of several
/// chains of layers down to the collider the longest counts. A point is pinched if it needs more
/// between both colliders than there is, or will be at the step's end. So one rule covers any
/// number of layers, in a gap of up to max_layer_height().
class Stacks {
 public:
  /// Largest distance [m] between two colliders that hold a cloth with `offset` from each: in a
  /// wider gap the layers are a pile, which no grip holds.
  static double max_layer_height(const Cloth& cloth, double offset) {
    constexpr int max_layers = 8;
    return 2 * (offset + max_layers * cloth.thickness);
  }

  /// Pinches the points that both colliders leave no room in a step of h [s] from `start` [m, N x
  /// 3].
  void pinch(const ContactManifold& a, const ContactManifold& b, const Cloth&, const Points& start,
             double h, const SelfTouches*, Pinches&);

 private:
  /// A point between the colliders.
  struct Node {
    int point;
    bool is_between;  // both touch the cloth at one place
    Pinches::ColliderDistance a, b;
  };

  /// One point lies upon another, as seen from collider a: numbers of their nodes.
  struct Edge {
    int below, above;
    double layer_height;  // distance that both keep [m]
  };

  void add_contact_points(const ContactManifold& a, const ContactManifold& b, const Points& start);
  void add_edges(const ContactManifold& a, const ContactManifold& b, const Points& start,
                 double max_distance, const SelfTouches&);
  void propagate_heights();

  /// Number of the node of a point, if it is between the colliders; else less than 0.
  int node_between(int point, const ContactManifold& a, const ContactManifold& b,
                   const Points& start, double max_distance);
  /// Adds a point at these distances; of several the nearest counts.
  void add(int point, const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b);

  std::vector<Node> nodes_;
  std::vector<int> node_of_;  // by point: its node, or why there is none
  std::vector<Edge> edges_;
};

}  // namespace clothsim
