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
/// Layers between two surfaces are light and stiff across, so that they are in equilibrium there:
/// each has its share of the gap, and all press with the same force, by compression_pressure() of
/// that share and the area of the point. So across both surfaces a pinched point has a velocity. It
/// is interpolated between both by the place of the point, so that layers keep their order; where
/// the surfaces overlap, it is their mean. Along them Coulomb's law holds with that normal force:
/// the point moves with both, more with the rougher one, as long as the friction of both suffices,
/// else it slips. In a wedge out of which friction cannot keep it the point slips, too.
class Pinches {
 public:
  /// Position of a point relative to one of two colliders.
  struct ColliderDistance {
    const MovingCollider* collider;
    Vector3 normal;       // of its surface, towards the point, unit
    double distance;      // from the surface at the step's start [m]
    double layer_height;  // distance that the point and the layers between them need [m]
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

  /// The gap between both at the end of a step of h [s], for a point at `x` [m], by the distance
  /// that the point needs: at 1 or below they leave it no room.
  static double room(const ColliderDistance& a, const ColliderDistance& b, const Vector3& x,
                     double h);

  /// Adds a point at `x` [m] that two colliders leave no room, unless it was added before. `area`:
  /// on which they press there [m^2].
  void add(int point, const Vector3& x, const ColliderDistance& a, const ColliderDistance& b,
           double area, const Cloth&);

  /// A contact of layers, all of whose points have been added: a layer presses on the next one with
  /// the normal impulses of its points, each divided over the contacts on that side of the point.
  /// First all contacts have to be added.
  void add_layer_contact(const std::array<int, 4>& points, const std::array<double, 4>& weights,
                         const Vector3& normal);
  /// The normal impulse in one of them [N s].
  double layer_normal_impulse(const std::array<int, 4>& points,
                              const std::array<double, 4>& weights, const Vector3& normal) const;

  /// Gives the points their velocities. Returns the largest change [m/s].
  double solve_pass(Points& velocities);

  /// Moves the points back to where those velocities bring them from `start`, where they do not
  /// slip.
  void project_positions(const Points& start, Points& positions) const;

  /// As FaceContacts::add_impulses(). Both colliders get the normal impulse of the layer; across
  /// them the one that pushed gets the change of momentum, along them each gets its share.
  void add_impulses(const std::vector<MovingCollider>&, const Cloth&, double scale,
                    const Points& positions, std::vector<ContactLoad>& sums) const;

  bool holds(int point) const {
    return !held_.empty() && held_[static_cast<std::size_t>(point)] != 0;
  }
  bool holds_any(const std::array<int, 3>& points) const {
    return std::any_of(points.begin(), points.end(), [&](int point) { return holds(point); });
  }
  /// Prescribed velocity of a point that has been added [m/s].
  const Vector3& velocity(int point) const { return pinch_of(point).velocity; }
  /// The cloth's weight in the step [N s].
  double weight(const Cloth& cloth) const { return cloth.mass.sum() * gravity_ * h_; }

  /// By point; empty: none.
  const std::vector<char>& held() const { return held_; }

  int count() const { return static_cast<int>(pinches_.size()); }
  /// Points that are pulled with more than friction bears.
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
    double share_of_b;      // share of b in the friction along them
    double normal_impulse;  // of the layer [N s]
    double touching;        // of both colliders, those that touch the point: 0, 1/2 or 1
    double max_friction;    // largest change of its velocity by friction [m/s]
    double settling;        // displacement across towards equilibrium [m]
    bool slips;
    Vector3 given{0, 0, 0};            // change of its velocity by the pinch in the step [m/s]
    std::array<double, 2> contacts{};  // with the layers towards a and b, sums of weights
  };

  /// Place in Pinch::contacts of a contact in which the point has this weight.
  static std::size_t side_of(const Pinch&, double weight, const Vector3& normal);
  const Pinch& pinch_of(int point) const {
    return pinches_[static_cast<std::size_t>(number_[static_cast<std::size_t>(point)])];
  }

  double h_ = 0;
  double gravity_ = min_gravity;  // [m/s^2]
  std::vector<Pinch> pinches_;
  std::vector<char> held_;
  std::vector<int> number_;  // by point: its place in pinches_
};

}  // namespace clothsim
