#pragma once

#include <vector>

#include "clothsim/collision/moving_collider.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Points of a cloth on colliders: no penetration, no restitution, Coulomb friction.
///
/// Contact acts on velocities, as the strain limit does: a normal impulse that lets a point come
/// closer by at most its gap within a step, and a friction impulse of at most friction times the
/// normal one against sliding on the (moving) surface (Moreau 1988, "Unilateral contact and dry
/// friction in finite freedom dynamics"). So a point slips on an incline exactly when
/// tan(angle) > friction, with acceleration g (sin - friction cos). Impulses are kept from step to
/// step. A point too fast for that is stopped where its path enters the shape.
class ColliderContacts {
 public:
  /// Finds contacts after a step of h [s] from `start` to state, and gives them their last
  /// impulses. `reach`: the share of h that a point has moved with an impulse given in the step.
  /// `drifted`: the velocities that brought the points where they are, before the impulses that
  /// other constraints have given since.
  void begin(const std::vector<MovingCollider>&, const Cloth&, double h, double reach,
             const Points& start, const Points& drifted, State&);

  /// One pass over the contacts. Returns the largest change as a displacement in h [m].
  double sweep(Points& velocities);

  /// Puts every point that is inside a collider on its surface.
  void correct(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
               Points& positions) const;

  /// Contacts that carry an impulse.
  int count() const;

  /// Forgets the impulses.
  void reset();

  /// The impulses, of so many colliders and points. `read` throws InvalidValue for what was not
  /// written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, std::size_t colliders, const Cloth&);

 private:
  struct Contact {
    int collider;
    int point;
    Vector3 normal;            // into free space
    Vector3 surface_velocity;  // [m/s]
    double slowest;            // least normal velocity off the surface allowed [m/s], <= 0
    double friction;
    double push = 0;        // normal impulse over mass [m/s], >= 0
    Vector3 drag{0, 0, 0};  // friction impulse over mass [m/s]
  };

  double h_ = 0;                   // step of the impulses [s]
  std::vector<Contact> contacts_;  // by collider, then point
  std::vector<Contact> last_;
};

}  // namespace clothsim
