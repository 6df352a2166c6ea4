#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "clothsim/constraints/rigid_motion.h"
#include "clothsim/model/memory.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// The colliders of a scene that are rigid bodies: their masses and velocities. The poses are those
/// of the colliders.
///
/// A step moves a body freely first, as in a parabola and with its angular momentum kept. Then
/// impulses change its velocities, and half a step of these changes displaces it: an impulse that
/// undoes the gravity of a step leaves no displacement.
class RigidBodies {
 public:
  /// None, or those of a scene that are valid.
  explicit RigidBodies(const std::vector<ColliderSpec>& = {});

  /// Displacement by an impulse, over the step and the change of velocity.
  static constexpr double displacement_factor = 0.5;

  bool empty() const { return bodies_in_scene_ == 0; }
  std::size_t count() const { return motions_.size(); }  // of colliders
  bool is_body(std::size_t collider) const {
    return collider < bodies_.size() && bodies_[collider].has_value();
  }
  /// Mass of all bodies [kg].
  double mass() const { return mass_; }
  /// Centre of mass in the shape's frame [m].
  const Vector3& center_of(std::size_t collider) const { return bodies_[collider]->center; }

  /// Sets the velocity of the centre of mass [m/s] and the angular velocity in the world [rad/s].
  void set_velocity(std::size_t collider, const Vector3& velocity, const Vector3& angular_velocity,
                    MovingCollider&);

  /// Moves all bodies freely through a step of h [s]. The other colliders have moved.
  void begin_step(double h, const Vector3& gravity, std::vector<MovingCollider>&);

  /// In a step, the motion of any collider of a scene with bodies.
  RigidMotion& motion(std::size_t collider) { return motions_[collider]; }
  const RigidMotion& motion(std::size_t collider) const { return motions_[collider]; }

  /// Least safe_depth() of a body [m].
  double least_depth() const { return least_depth_; }

  /// Bound on the speed of the surface of any body [m/s].
  double fastest_surface() const;

  /// Bound on the displacement of two surfaces towards each other in a step of h [s], at the
  /// present velocities [m].
  double longest_way(double h) const;

  /// Ends a step: displaces bodies by the changes of their velocities, and by `pushes`, whose
  /// velocities are displacements. Empty: none.
  void end_step(const std::vector<RigidMotion>& pushes, std::vector<MovingCollider>&);

  /// The velocities. `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  struct Body {
    double mass;      // [kg]
    double damping;   // [1/s]
    Vector3 center;   // of mass, in the shape's frame [m]
    Matrix3 inertia;  // about it, in the shape's frame [kg m^2]
    Matrix3 inv_inertia;
    Pose pose;         // after the free motion
    Vector3 velocity;  // the same [m/s]
    Vector3 turning;   // angular velocity, the same [rad/s]
  };

  static void move_freely(Body&, RigidMotion&, double h, const Vector3& gravity, const Pose& from);
  double speed_of_surface(std::size_t collider) const;
  static void put(const Pose&, const RigidMotion&, MovingCollider&);

  std::vector<std::optional<Body>> bodies_;  // by collider
  std::vector<RigidMotion> motions_;         // the same
  std::vector<double> radii_;                // the same: of balls that hold them; 0 for planes [m]
  std::size_t bodies_in_scene_ = 0;
  double mass_ = 0;
  double least_depth_ = std::numeric_limits<double>::infinity();
  double h_ = 0;  // of the step [s]
};

}  // namespace clothsim
