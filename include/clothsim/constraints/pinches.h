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
/// What surfaces that close on a cloth, one layer or several, ask of it cannot all be met, and
/// impulses that try grow without end. So such a point goes across them in its share of what is
/// between both, and layers keep their order; where they overlap, it goes as their mean.
/// Solids press as hard as it takes: where friction can keep it from slipping out, it does, and the
/// point goes along with both, more with what holds it firmer, whatever pushes it. Else it slips.
/// So it does where the strain limit pulls it with more than its share of some weights of the whole
/// cloth: pins or other solids may be behind that, and what they pull would be torn.
class Pinches {
 public:
  /// What a point has to do with one of two colliders.
  struct ColliderDistance {
    const MovingCollider* collider;
    Vector3 normal;       // of its surface, towards the point, unit
    double distance;      // from it at the step's start [m]
    double layer_height;  // that the point and the layers between them need there [m]
    bool touches;         // no other layer is between them
  };

  /// Forgets all points, for a step of h [s]. The weight of the cloth is that under `gravity`
  /// [m/s^2].
  void start_over(double h, double gravity = min_gravity);

  /// Cosine of the angle between one normal and the other's opposite from which on surfaces face
  /// each other, and between normals from which on one layer lies upon another: out of a wider
  /// wedge impulses push sideways.
  static constexpr double facing = 0.5;

  /// Push on what is held in part, or out of an overlap of layers, of the weight of the cloth: what
  /// colliders or layers ask of it may be more than it can give.
  static constexpr double max_overlap_impulse = 0.25;

  /// Do surfaces with these normals face each other?
  static bool face_each_other(const Vector3& a, const Vector3& b);

  /// Will there be less than a point at `x` [m] needs between both at the end of a step of h [s]?
  static bool leave_no_room(const ColliderDistance& a, const ColliderDistance& b, const Vector3& x,
                            double h);

  /// Takes a point at `x` [m], unless it is taken, that two colliders leave no room.
  void add(int point, const Vector3& x, const ColliderDistance& a, const ColliderDistance& b,
           const Cloth&);

  /// Gives the points their velocities. Returns the largest change [m/s].
  double solve_pass(Points& velocities);

  /// What the strain limit has given to all points of the cloth in the step so far, N x 3 [m/s].
  void set_pulls(const Points& given);

  /// It has given what velocities, N x 3 [m/s], have changed by since the last sweep.
  void add_pulls(const Points& velocities);

  /// Puts the points back where those velocities bring them from `start`, as far as they do not
  /// slip.
  void project_positions(const Points& start, Points& positions) const;

  /// As of FaceContacts. Of two colliders the one that pushed has what a point got across them; of
  /// what it got along them each has its share. What both press against each other through the
  /// point is in no sum: nothing says how much that is.
  void add_impulses(const std::vector<MovingCollider>&, const Cloth&, double scale,
                    const Points& positions, std::vector<Wrench>& sums) const;

  bool holds(int point) const {
    return !held_.empty() && held_[static_cast<std::size_t>(point)] != 0;
  }
  bool holds_any(const std::array<int, 3>& points) const {
    return std::any_of(points.begin(), points.end(), [&](int point) { return holds(point); });
  }
  /// Velocity that a point which has been added is to have [m/s].
  const Vector3& velocity(int point) const {
    return pinches_[static_cast<std::size_t>(number_[static_cast<std::size_t>(point)])].velocity;
  }
  /// The cloth's weight in the step [N s].
  double weight(const Cloth& cloth) const { return cloth.mass.sum() * gravity_ * h_; }

  /// By point; empty: none.
  const std::vector<char>& held() const { return held_; }

  int count() const { return static_cast<int>(pinches_.size()); }
  /// Those that are pulled with more than the grip bears.
  int slipping() const;
  /// The first of them; -1: none.
  int first() const { return pinches_.empty() ? -1 : pinches_.front().point; }

 private:
  struct Pinch {
    int point;
    Vector3 velocity;  // wanted [m/s]
    Vector3 across;    // from a to b
    const MovingCollider* a;
    const MovingCollider* b;
    double share_of_b;  // of what holds it along them
    double grip;        // greatest pull along them that it bears, were it alone; 0: slides [m/s]
    std::size_t pair;   // that hold it
    Vector3 given;      // by which this has changed its velocity in the step [m/s]
    Vector3 pull;       // that the strain limit has changed it by [m/s]
    Vector3 left;       // velocity after the last sweep [m/s]
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
  std::vector<int> number_;  // by point, of those that are held
};

}  // namespace clothsim
