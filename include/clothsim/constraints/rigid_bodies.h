#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "clothsim/constraints/rigid_motion.h"
#include "clothsim/model/memory.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// The colliders of a scene that are rigid bodies: their masses and velocities. The poses are those
/// of the colliders. A body may have several colliders, its parts: the first one, with the mass,
/// leads, and its frame is that of the body.
///
/// A step moves a body freely first: in a parabola with its angular momentum kept, or along its
/// joint. Then impulses change its velocities, and half a step of these changes displaces it: an
/// impulse that undoes the gravity of a step leaves no displacement.
class RigidBodies {
 public:
  /// None, or those of a scene that are valid.
  explicit RigidBodies(const std::vector<ColliderSpec>& = {});

  /// Displacement by an impulse, over the step and the change of velocity.
  static constexpr double displacement_factor = 0.5;

  bool empty() const { return bodies_in_scene_ == 0; }
  std::size_t count() const { return motions_.size(); }  // of colliders
  /// Does a collider belong to a body that impulses move now?
  bool is_body(std::size_t collider) const {
    return collider < bodies_.size() && of(collider) && !of(collider)->held;
  }
  /// Does a collider lead a body, whether it is held or not?
  bool leads(std::size_t collider) const {
    return collider < bodies_.size() && bodies_[collider].has_value();
  }
  bool has_joint(std::size_t collider) const { return of(collider) && of(collider)->joint; }
  bool are_of_one(std::size_t collider, std::size_t other) const {
    return leader_[collider] == leader_[other];
  }
  /// The leader of the collider's body; any other collider itself.
  std::size_t leader(std::size_t collider) const { return leader_[collider]; }
  /// Two colliders touch in this step, perhaps through the cloth.
  void touch(std::size_t collider, std::size_t other);
  /// Mass of the bodies that either of two colliders carries: those that it touches in this step or
  /// the last one, directly or through other bodies [kg].
  double mass_touching(std::size_t collider, std::size_t other) const;
  /// Largest force at one of the `places` where two colliders touch [N], beyond the impulse that
  /// stops their approach: fingers that close on a body leave no room. `gravity`: [m/s^2].
  double strongest_force(std::size_t collider, std::size_t other, int places, double gravity) const;
  /// Mass of all bodies [kg].
  double mass() const { return mass_; }
  /// Centre of mass in the frame of a leader [m].
  const Vector3& center_of(std::size_t leader) const { return bodies_[leader]->center; }

  /// A held body is kinematic, as a collider without mass is.
  void hold(std::size_t leader, bool held) { bodies_[leader]->held = held; }
  bool is_held(std::size_t leader) const { return bodies_[leader]->held; }

  /// Puts all bodies at their first velocities, their joints at 0. Their leaders are at their start
  /// poses.
  void start(const std::vector<ColliderSpec>&, std::vector<MovingCollider>&);

  /// Sets the velocity of the centre of mass [m/s] and the angular velocity in the world [rad/s],
  /// as far as a joint allows, for the present pose of the leader.
  void set_velocity(std::size_t leader, const Vector3& velocity, const Vector3& angular_velocity,
                    std::vector<MovingCollider>&);

  /// The pose nearest to one that the joint of a body and its limits allow.
  Pose nearest_allowed(std::size_t leader, const Pose&) const;
  /// Distance from it [m] or [rad], the larger number.
  double distance_from_joint(std::size_t leader, const Pose&) const;

  /// The pose of a collider of a body whose leader is at `pose`.
  Pose pose_of(std::size_t collider, const Pose& pose) const {
    return leader_[collider] == collider ? pose : pose * offsets_[collider];
  }

  /// Sets the pose of a held body, without a velocity unless it keeps that of the memory.
  void set_held(std::size_t leader, const Pose&, bool keeps_velocity);

  /// Moves all bodies freely through a step of h [s]. The other colliders have moved.
  void begin_step(double h, const Vector3& gravity, std::vector<MovingCollider>&);

  /// In a step, the motion of any collider of a scene with bodies.
  RigidMotion& motion(std::size_t collider) { return motions_[leader_[collider]]; }
  const RigidMotion& motion(std::size_t collider) const { return motions_[leader_[collider]]; }

  /// A side of the range of a joint.
  struct JointLimit {
    Wrench direction;  // of the free motion, inwards: a unit force or torque
    double gap = 0;    // to the limit, where impulses act [m] or [rad]
    double mass = 0;   // of the free motion [kg] or [kg m^2]
  };
  /// The limits of a body's joint after its free motion: none, or the lower and the upper one.
  std::vector<JointLimit> joint_limits(std::size_t leader) const;

  /// Least safe_depth() of a body's shape [m].
  double least_depth() const { return least_depth_; }

  /// Bound on the speed of the surface of any body [m/s].
  double fastest_surface() const;

  /// Bound on the displacement of two surfaces towards each other in a step of h [s], at the
  /// present velocities [m].
  double longest_displacement(double h) const;

  /// Ends a step: displaces bodies by the changes of their velocities, and by `pushes`, whose
  /// velocities are displacements, by leader. Empty: none.
  void end_step(const std::vector<RigidMotion>& pushes, std::vector<MovingCollider>&);

  /// The velocities, joints and groups. `read` throws InvalidValue for data that is not from
  /// `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  struct Body {
    double mass;      // [kg]
    double damping;   // [1/s]
    Vector3 center;   // of mass, in the leader's frame [m]
    Matrix3 inertia;  // about it, in the same frame [kg m^2]
    Matrix3 inv_inertia;
    std::optional<Joint> joint;
    Pose start;  // where the displacement of the joint is 0
    bool held = false;
    double joint_inertia = 0;   // of a hinge, about its axis [kg m^2]
    double displacement = 0;    // of the joint [m] or [rad]
    double at_impulses = 0;     // the same after the free motion
    Pose pose = {};             // after the free motion
    Vector3 velocity{0, 0, 0};  // the same [m/s]
    Vector3 turning{0, 0, 0};   // angular velocity, the same [rad/s]
  };

  const std::optional<Body>& of(std::size_t collider) const { return bodies_[leader_[collider]]; }
  void add_body(std::size_t leader, const ColliderSpec&);
  static Pose on_joint(const Body&, double displacement);
  static double nearest_displacement(const Body&, const Pose&);
  static void move_freely(Body&, RigidMotion&, double h, const Vector3& gravity, const Pose& from);
  static void slide(Body&, RigidMotion&, double h, const Vector3& gravity);
  static void swing(Body&, RigidMotion&, double h, const Vector3& gravity, const Pose& from);
  static void end_motion(Body&, RigidMotion&, double h, const RigidMotion& push, Pose& pose);
  double speed_of_surface(std::size_t collider) const;
  void put(std::size_t leader, const Pose&, std::vector<MovingCollider>&) const;

  std::vector<std::optional<Body>> bodies_;  // by leader
  std::vector<std::size_t> leader_;          // by collider
  std::vector<Pose> offsets_;                // by collider: in the frame of the leader
  std::vector<RigidMotion> motions_;         // by leader
  std::vector<double> radii_;  // by collider: of balls about the motion's centre that hold them;
                               // 0 for planes [m]
  std::vector<std::size_t> group_;       // by leader: the first of the bodies that touch
  std::vector<std::size_t> last_group_;  // the same in the last step
  std::size_t bodies_in_scene_ = 0;
  double mass_ = 0;
  double least_depth_ = infinity;
  double h_ = 0;  // of the step [s]
};

}  // namespace clothsim
