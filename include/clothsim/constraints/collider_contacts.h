#pragma once

#include <limits>
#include <tuple>
#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/face_contacts.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

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
/// the nearest way if it is not deep, else all of it in one direction. What two leave no room is
/// held between them.
class ColliderContacts {
 public:
  /// Finds contacts after a step from step.start to state, and gives them their last impulses.
  void begin(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// One pass over the contacts. Returns the largest change as a displacement in h [m].
  double sweep(const Cloth&, Points& velocities);

  /// Moves what is inside a collider to its surface.
  void correct(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
               Points& positions);

  /// Contacts that carry an impulse, and points that are pinched.
  int count() const;

  /// Points that two colliders leave no room.
  const Pinches& pinches() const { return pinches_; }

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
    // What the last pass left the point with: none needs another until it changes [m/s].
    Vector3 left = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());

    std::tuple<int, int> id() const { return {collider, point}; }
  };

  /// Points that leave a collider together.
  struct Escape {
    int collider;
    Vector3 direction;       // unit, in the collider's own frame
    std::vector<char> held;  // by point
  };

  int points_count() const;

  /// A point that was in a collider when a step began.
  struct CaughtPoint {
    int point;
    double depth;  // [m] at the step's start
  };

  /// What was in a collider when a step began.
  struct Caught {
    int collider;
    std::vector<CaughtPoint> points;
    std::vector<CaughtFace> faces;

    double depth() const;  // greatest [m], 0 where nothing was
  };

  /// Finds the contacts of all colliders in reach; one Caught for each of these.
  std::vector<Caught> find(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
                           State&);

  /// Adds the point contacts of a collider. Nothing further than `reach` [m] from it can touch it.
  void find_points(int index, const MovingCollider&, const Cloth&, const ContactStep&,
                   double offset, double reach, State&, std::vector<CaughtPoint>&);

  /// Holds what colliders leave no room, and takes it out of what they caught.
  void find_pinched(const std::vector<MovingCollider>&, const Cloth&, const Points& positions,
                    std::vector<Caught>&);

  /// Sends what is caught in a collider out in one direction.
  void escape(const Caught&, const MovingCollider&, const Cloth&, const ContactStep&,
              const Points& positions);

  /// Gives the contacts the impulses of the last step, `scale` times as large.
  void resume(const Cloth&, double scale, Points& velocities);

  double stretch_ = 0;             // of the step, see ContactStep
  double h_ = 0;                   // step of the impulses [s]
  std::vector<Contact> contacts_;  // by collider, then point
  std::vector<Contact> last_;
  std::size_t next_last_ = 0;
  FaceContacts faces_;
  Pinches pinches_;
  std::vector<Escape> escapes_;  // by collider
  bool recovers_ = false;
  LocalCloth local_;
};

}  // namespace clothsim
