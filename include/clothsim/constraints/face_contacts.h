#pragma once

#include <array>
#include <optional>
#include <tuple>
#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/corners.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/triangle_blocks.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/face_distance.h"

namespace clothsim {

/// A triangle that was in a collider when a step began.
struct CaughtFace {
  int triangle;
  std::size_t contact;  // in FaceContacts
  double depth;         // [m] at the step's start
};

/// Edges and faces of a cloth on colliders that are not smooth against its triangles. As in
/// ColliderContacts, but each contact acts on the three corners of a triangle, in the shares that
/// its point has of them, and moves each by its inverse mass. What a corner touches is left to the
/// contact of that point. So is all of a triangle with a corner that is held in the solid, which
/// nothing could bring out. Next to a held corner a triangle may sink in by up to a tenth of its
/// longest edge.
class FaceContacts {
 public:
  /// Keeps the contacts of the last step as those to resume.
  void start_over();

  /// Adds the contacts of the next collider, number `index`. `margin`: how far away one may be that
  /// matters within the step [m]. Triangles that the step took through the shape are moved back.
  void find(int index, const MovingCollider&, const Cloth&, const ContactStep&, double margin,
            LocalCloth&, State&, std::vector<CaughtFace>&);

  /// Gives the contacts the impulses of the last step, `scale` times as large.
  void resume(const Cloth&, double scale, Points& velocities);

  /// Calls visit(triangle, weights of its corners, normal, distance [m]) for each contact with a
  /// collider.
  template <typename Visit>
  void for_each_on(int collider, Visit&& visit) const {
    for (const Contact& c : contacts_) {
      if (c.id.collider == collider) visit(c.id.triangle, c.weights, c.impulse.normal, c.distance);
    }
  }

  /// Acts on no corner that is held. What such corners lack of their distance from the collider, as
  /// layers that have to be thinner do, their triangles may lack by their shares.
  void leave_to(const Pinches&, const std::vector<MovingCollider>&, const Cloth&,
                const ContactStep&);

  /// One pass over the contacts. Returns the largest change of a velocity [m/s].
  double sweep(const Cloth&, Points& velocities);

  /// Moves the corners of triangles that are in the collider out, in local.to, and marks them as
  /// `moved`. Triangles with a point that is `held` (empty: none) are left alone.
  void correct(const MovingCollider&, const Cloth&, double h, const std::vector<char>& held,
               LocalCloth&, std::vector<char>& moved);

  /// Turns a contact to another direction out of the solid.
  void redirect(std::size_t contact, const Vector3& normal) {
    contacts_[contact].impulse.normal = normal;
    contacts_[contact].impulse.slowest = contacts_[contact].lever * recovery_speed;
  }

  /// As of ContactSlots, to each collider's sum, about its frame's origin.
  void add_impulses(const std::vector<MovingCollider>&, const Cloth&, double scale,
                    const Points& positions, std::vector<Wrench>& sums) const;

  int count() const;  // that carry an impulse
  void reset();
  void write(MemoryWriter&) const;
  void read(MemoryReader&, std::size_t colliders, const Cloth&);

 private:
  struct Id {
    int collider;
    int triangle;
    int feature;  // what touches: an edge, 0 to 2, or the face, 3

    bool operator<(const Id& other) const {
      return std::tie(collider, triangle, feature) <
             std::tie(other.collider, other.triangle, other.feature);
    }
  };

  struct Contact {
    Id id;
    CornerWeights weights;  // of the corners
    CornerWeights moves;    // of the corners, by an impulse; 0 of those that are pinched
    double yield;           // velocity there over impulse, 1 at a point alone
    double lever;           // velocity there over the fastest corner's
    double distance;        // from the surface, where impulses act [m]
    ContactImpulse impulse;
  };

  const Contact* last_of(const Id&);

  /// Adds a contact at `distance`, if it matters in this step.
  void add(const Id&, const MovingCollider&, const Cloth&, const ContactStep&,
           const FaceDistance& distance, bool swept, double depth, LocalCloth&, State&);

  TriangleBlocks blocks_;
  std::vector<Contact> contacts_;  // ascending ids
  std::vector<Contact> last_;
  std::size_t next_last_ = 0;
};

}  // namespace clothsim
