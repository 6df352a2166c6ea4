#pragma once

#include <vector>

#include "clothsim/collision/contact_impulse.h"
#include "clothsim/collision/face_contacts.h"
#include "clothsim/collision/local_cloth.h"
#include "clothsim/collision/moving_collider.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// A cloth on colliders: no penetration, no restitution, Coulomb friction.
///
/// Contact acts on velocities, as the strain limit does: a normal impulse that lets a point come
/// closer by at most its gap within a step, and a friction impulse of at most friction times the
/// normal one against sliding on the (moving) surface (Moreau 1988, "Unilateral contact and dry
/// friction in finite freedom dynamics"). So a point slips on an incline exactly when
/// tan(angle) > friction, with acceleration g (sin - friction cos). Impulses are kept from step to
/// step. A point too fast for that is stopped where its path enters the shape. Where points alone
/// do not keep a shape off the triangles between them, edges and faces have contacts too.
///
/// What a shape was put upon, rather than moved against, comes out at recovery_speed at most: by
/// the nearest way if it is not deep, else all of it in one direction.
class ColliderContacts {
 public:
  /// Finds contacts after a step from step.start to state, and gives them their last impulses.
  void begin(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// One pass over the contacts. Returns the largest change as a displacement in h [m].
  double sweep(const Cloth&, Points& velocities);

  /// Moves what is inside a collider to its surface.
  void correct(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
               Points& positions);

  /// Contacts that carry an impulse.
  int count() const;

  /// Was any of the cloth in a collider when the step began?
  bool recovers() const { return recovers_; }

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
    ContactImpulse impulse;
  };

  /// Points that leave a collider together.
  struct Escape {
    int collider;
    Vector3 direction;       // unit, in the collider's own frame
    std::vector<char> held;  // by point
  };

  int points_count() const;

  /// Adds the point contacts of a collider; `caught` are those in it at the step's start. Returns
  /// the greatest depth of one [m].
  double find_points(int index, const MovingCollider&, const Cloth&, const ContactStep&,
                     double offset, State&, std::vector<int>& caught);

  /// Sends what is caught in a collider, whose contacts are those from `first` on, out in one
  /// direction.
  void escape(int index, const MovingCollider&, const Cloth&, std::size_t first,
              const std::vector<int>& points, const std::vector<CaughtFace>& faces,
              const Points& positions);

  double h_ = 0;                   // step of the impulses [s]
  std::vector<Contact> contacts_;  // by collider, then point
  std::vector<Contact> last_;
  std::size_t next_last_ = 0;
  FaceContacts faces_;
  std::vector<Escape> escapes_;  // by collider
  bool recovers_ = false;
  LocalCloth local_;
};

}  // namespace clothsim
