#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "clothsim/constraints/body_collisions.h"
#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/rigid_bodies.h"

namespace clothsim {

/// An overlap of two colliders, one of them a body, at a place.
struct Overlap {
  std::size_t a;
  std::size_t b;
  Vector3 place;   // [m]
  Vector3 normal;  // from b to a, unit
  double depth;    // > 0 [m]
};

/// Contact of rigid bodies with each other and with other colliders, by the same law as that of the
/// cloth (ContactImpulse), so that passes over both converge together. Friction between two
/// colliders is the geometric mean of theirs. Impulses are kept for places that have hardly moved.
/// The limits of joints are unilateral rows, too. A body with a joint has no contact with colliders
/// that it overlaps at the start, such as the rod of a ring.
class BodyContacts {
 public:
  /// Finds places of bodies, other than those of their shapes, within a distance [m] of colliders.
  using FindPlaces = std::function<std::vector<BodyTouch>(double reach)>;

  /// Detects the contacts of a step of h [s] after the bodies' free motion, and warm-starts them.
  /// `gravity`: for the bound on their impulses, see RigidBodies::strongest_force() [m/s^2].
  /// `specs`: of the scene.
  void prepare(double h, double gravity, const std::vector<ColliderSpec>& specs,
               const std::vector<MovingCollider>&, const FindPlaces&, RigidBodies&);

  /// One pass. Returns the largest change of a relative velocity [m/s].
  double solve_pass(RigidBodies&);

  /// Displacements that lead overlaps of the step back, and these `further` ones: each by
  /// overlap_share, as velocities of motions by collider. Empty: none.
  std::vector<RigidMotion> pushes(const RigidBodies&, const std::vector<Overlap>& further) const;

  /// Forgets the impulses.
  void reset();
  void write(MemoryWriter&) const;
  void read(MemoryReader&, std::size_t colliders);

 private:
  struct PairContact {
    BodyTouch touch;
    Vector3 local{0, 0, 0};       // its place in the frame of the body a [m]
    double approach = 0;          // relative normal velocity of the free motion [m/s]
    double mass = 0;              // effective, along the normal [kg]
    double tangential_mass = 0;   // effective, along the surface [kg]; 0: nothing can move
    ContactImpulse impulse = {};  // on a
  };

  struct LimitContact {
    std::size_t body;
    RigidBodies::JointLimit limit;
    double min_rate;     // least rate allowed along the direction of the limit [m/s] or [rad/s]
    double impulse = 0;  // >= 0, along it [N s] or [N m s]
  };
  struct Setup;  // found once for a scene

  std::vector<BodyTouch> find(const std::vector<MovingCollider>&, const FindPlaces&,
                              const RigidBodies&) const;
  void prepare_contacts(double scale, double gravity, const std::vector<MovingCollider>&,
                        const FindPlaces&, RigidBodies&);
  void prepare_limits(double scale, RigidBodies&);
  static void give(const LimitContact&, double impulse, RigidBodies&);
  void warm_start(double scale, double radius, PairContact&);
  static void give(const BodyTouch&, const Vector3& impulse, RigidBodies&);
  static Vector3 relative_velocity(const BodyTouch&, const RigidBodies&);

  std::shared_ptr<Setup> setup_;  // without a state
  std::vector<PairContact> contacts_;
  std::vector<PairContact> last_;
  std::vector<LimitContact> limits_;
  double h_ = 0;
};

}  // namespace clothsim
