#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Points of a cloth that two colliders leave no room.
///
/// Contacts with two surfaces that close on one or several layers cannot all be met, and their
/// impulses would grow without bound. Instead a pinched point gets a velocity. Across the surfaces
/// it is interpolated between both by the place of the point, so that layers keep their order;
/// where the surfaces overlap, it is their mean. Where friction can keep the point from slipping
/// out, it also moves along with both, more with the surface that holds it more firmly, whatever
/// acts on it: solids press as hard as needed. Else it slips. It also slips where the strain limit
/// pulls it with more than its share of some weights of the whole cloth: pins or other solids may
/// cause that pull, and the cloth would tear.
class Pinches {
 public:
  /// Position of a point relative to one of two colliders.
  struct ColliderDistance {
    const MovingCollider* collider;
    Vector3 normal;       // of its surface, towards the point, unit
    double distance;      // from the surface at the step's start [m]
    double layer_height;  // distance that the point and the layers between them need [m]
    int layers;           // between them
    bool touches;         // no other layer is between them
  };

  /// Forgets all points, for a step of h [s]. The weight of the cloth is that under `gravity`
  /// [m/s^2].
  void start_over(double h, double gravity = min_gravity);

  /// Cosine of the angle between one normal and the other's opposite from which on surfaces face
  /// each other, and between normals from which on one layer lies upon another: out of a wider
  /// wedge impulses push sideways.
  static constexpr double facing = 0.5;

  /// Largest impulse on features that are held in part, or out of an overlap of layers, in weights
  /// of the cloth: colliders or layers may demand more than the cloth can give.
  static constexpr double max_overlap_impulse = 0.25;

  /// Do surfaces with these normals face each other?
  static bool face_each_other(const Vector3& a, const Vector3& b);

  /// At the end of a step of h [s], will the gap between both be at most the distance that a point
  /// at `x` [m] needs?
  static bool leave_no_room(const ColliderDistance& a, const ColliderDistance& b, const Vector3& x,
                            double h);

  /// Adds a point at `x` [m] that two colliders leave no room, unless it was added before.
  void add(int point, const Vector3& x, const ColliderDistance& a, const ColliderDistance& b,
           const Cloth&);

  /// Gives the points their velocities. Returns the largest change [m/s].
  double solve_pass(Points& velocities);

  /// Sets the velocity changes by the strain limit of all points of the cloth in the step so far, N
  /// x 3 [m/s].
  void set_pulls(const Points& given);

  /// Adds the changes of velocities by the pinches in the step [m/s].
  void add_velocities(Points& sum) const {
    for (const Pinch& p : pinches_) sum.row(p.point) += p.given.transpose();
  }

  /// Adds the changes of `velocities`, N x 3 [m/s], by the strain limit since the last pass.
  void add_pulls(const Points& velocities);

  /// Moves the points back to where those velocities bring them from `start`, where they do not
  /// slip.
  void project_positions(const Points& start, Points& positions) const;

  /// As FaceContacts::add_impulses(). Across both colliders the one that pushed gets the impulse;
  /// along them each gets its share. The impulse with which both press against each other through
  /// the point is in no sum: it is indeterminate.
  void add_impulses(const std::vector<MovingCollider>&, const Scalars& masses,
                    const Points& positions, std::vector<Wrench>& sums) const;

  bool holds(int point) const {
    return !held_.empty() && held_[static_cast<std::size_t>(point)] != 0;
  }
  bool holds_any(const std::array<int, 3>& points) const {
    return std::any_of(points.begin(), points.end(), [&](int point) { return holds(point); });
  }
  /// Prescribed velocity of a point that has been added [m/s].
  const Vector3& velocity(int point) const {
    return pinches_[static_cast<std::size_t>(number_[static_cast<std::size_t>(point)])].velocity;
  }
  /// The cloth's weight in the step [N s].
  double weight(const Cloth& cloth) const { return cloth.mass.sum() * gravity_ * h_; }

  /// By point; empty: none.
  const std::vector<char>& held() const { return held_; }

  int count() const { return static_cast<int>(pinches_.size()); }
  /// Points that are pulled with more than the grip bears.
  int slipping() const;
  /// The first point; -1: none.
  int first() const { return pinches_.empty() ? -1 : pinches_.front().point; }

 private:
  struct Pinch {
    int point;
    Vector3 velocity;  // wanted [m/s]
    Vector3 across;    // from a to b
    const MovingCollider* a;
    const MovingCollider* b;
    double share_of_b;  // share of b in the grip along them
    double grip;        // largest pull along them that it bears alone; 0: slides [m/s]
    std::size_t pair;   // of colliders that hold it
    Vector3 given;      // change of its velocity by the pinch in the step [m/s]
    Vector3 pull;       // change of its velocity by the strain limit [m/s]
    Vector3 left;       // velocity after the last pass [m/s]
    bool slips;
  };

  /// Two colliders that hold points.
  struct ColliderPair {
    const MovingCollider* a;
    const MovingCollider* b;
    int points;  // that stick
  };

  std::size_t pair_of(const MovingCollider&, const MovingCollider&);
  Vector3 slip(Pinch&) const;

  double h_ = 0;
  double gravity_ = min_gravity;  // [m/s^2]
  std::vector<Pinch> pinches_;
  std::vector<ColliderPair> collider_pairs_;
  std::vector<char> held_;
  std::vector<int> number_;  // by point: its place in pinches_
};

}  // namespace clothsim
