#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "clothsim/constraints/contact_slots.h"
#include "clothsim/constraints/face_contacts.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/sleep_bounds.h"
#include "clothsim/constraints/stacks.h"
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
/// step. A point too fast for that slides on along the surface from where its path enters it. Where
/// points alone do not keep a shape off the triangles between them, edges and faces have contacts
/// too.
///
/// What a shape was put upon, rather than moved against, comes out at recovery_speed at most: by
/// the nearest way if it is not deep, else all of it in one direction; where pins hold it in, less
/// and less fast. What two leave no room is held between them.
class ColliderContacts {
 public:
  /// Finds contacts after a step from step.start to state, and gives them their last impulses.
  void prepare(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// May steps go on with what prepare() found to be near? Not while colliders push out or pinch.
  bool is_settled() const;

  /// The same as prepare() in another step of the same length, of the points near then and of the
  /// triangles that touched alone.
  void refresh(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// One pass over the contacts. Returns the largest change as a displacement in h [m].
  double solve_pass(Points& velocities);

  /// Moves what is inside a collider to its surface.
  void project_positions(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                         Points& positions);

  /// The same after refresh(), of the points near alone.
  void project_near(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                    Points& positions);

  /// The same once more in a step that does not pinch it, after others have moved it on from
  /// `start`.
  void project_again(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                     Points& positions);

  /// Adds what the cloth, at `positions`, gave each collider in the step, times `scale`: impulse
  /// [N s] and its moment about the origin of the collider's frame [N m s], in the world. All that
  /// changed velocities counts, also where it led out what a collider was put upon. What
  /// project_positions() moves does not.
  void add_impulses(const std::vector<MovingCollider>&, const Cloth&, double scale,
                    const Points& positions, std::vector<Wrench>& sums) const;

  /// Contacts that carry an impulse, and points that are pinched.
  int count() const;

  /// Do triangles touch with more than corners?
  bool has_faces() const { return faces_.size() > 0; }

  /// Points that two colliders leave no room.
  const Pinches& pinches() const { return pinches_; }
  Pinches& pinches() { return pinches_; }

  /// Have triangles contacts of their own with any of these, or do two pinch the cloth?
  bool has_edges(const std::vector<MovingCollider>&, const Cloth&) const;

  /// Was any of the cloth in a collider when the step began?
  bool recovers() const { return recovers_; }

  /// Did so of late any of it?
  bool is_leaving() const { return leaving_ > 0; }
  /// How much of its speed is left to what leaves one, see ContactStep.
  double recovery_factor() const { return recovery_factor_after(leaving_); }
  /// Has it come out as fast as at first: what holds it in has moved.
  void try_anew() { leaving_ = 0; }

  /// Forgets the impulses.
  void reset();

  /// The impulses, of so many colliders and points. `read` throws InvalidValue for what was not
  /// written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, std::size_t colliders, const Cloth&);

 private:
  /// What a collider has to do with the cloth.
  struct ColliderCache {
    ContactSlots slots;
    SleepBounds sleep_bounds;
    std::vector<Span> near;    // blocks that may touch it before more are sought, ascending
    std::vector<Span> inside;  // those that may be in it as a step ends
    double friction = 0;
    double keeps = 0;                // that points keep from its surface [m]
    double within = 0;               // which `near` are [m]
    double moved = 0;                // by its surface in this step, at most [m]
    bool has_faces = false;          // whether triangles may touch it in this step
    bool is_clear = false;           // no free point was in it as the last step ended
    bool is_close = false;           // whether this step looks at its points one by one
    std::optional<Vector3> way_out;  // of what leaves it together, in its own frame, unit
    std::vector<char> leaves;        // by point, with way_out
    std::vector<Solid::Neighbourhood> neighbourhoods;  // of points, on a mesh

    Asked asked(const MovingCollider&, const Cloth&, double near);
  };

  /// What was in a collider when a step began: points and how deep [m], and triangles.
  struct Penetration {
    int collider;
    std::vector<std::pair<int, double>> points;
    std::vector<PenetratingFace> faces;

    double depth() const;  // greatest [m], 0 where nothing was
  };

  /// Finds the contacts of all colliders; one Penetration for each in reach.
  std::vector<Penetration> find(const std::vector<MovingCollider>&, const Cloth&,
                                const ContactStep&, State&);
  void find_at(ColliderCache&, const MovingCollider&, const Cloth&, const ContactStep&,
               double speed, double drift, State&, Penetration&);

  /// Finds the contacts of the points near a collider, but for those that need a close look.
  static void find_points(ColliderCache&, const MovingCollider&, const Cloth&, const ContactStep&,
                          const State&);
  /// Ends the search for contacts of points, and gives these impulses `scale` times the last ones.
  void warm_start(const Cloth&, double scale, State&);

  /// Tells the cache where the collider is in this step.
  void follow(ColliderCache&, const MovingCollider&, const Points& positions) const;

  /// Can triangles come within `distance` [m] of the collider?
  bool is_near_faces(const ColliderCache&, const Clearance&, double distance) const;

  /// Finds the contact of a point anew if the step may have taken it through the shape, or if it
  /// was in it when the step began.
  void look_closely(ColliderCache&, int point, const ContactSlots::Detector&, const ContactStep&,
                    State&, Penetration&);

  /// Holds what colliders leave no room, and takes it out of what they caught.
  void find_pinched(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
                    std::vector<Penetration>&);
  void pinch(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
             const std::vector<Penetration>&);
  /// Bounds of where a collider touches, and of the normals there.
  struct Touched {
    Normals normals;
    Eigen::AlignedBox3d places;  // [m] of points, with the corners of triangles
  };
  Touched touched_by(int number, const Cloth&, const Points& positions);
  ContactManifold manifold_of(int number, const MovingCollider&, const Cloth&);

  /// Sends what is caught in a collider out in one direction.
  void escape(const Penetration&, const MovingCollider&, const Cloth&, const ContactStep&,
              const Points& positions);

  /// What was in a collider has been moved out by `way` [m] at most.
  void moved_out(std::size_t collider, double way);
  /// Moves what is in any collider out.
  void project_all(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                   Points& positions);
  /// Moves what is in one collider out. Returns the longest way of a point [m].
  double project_at(ColliderCache&, const MovingCollider&, const Cloth&, const Points& start,
                    Points& positions);

  /// The same of the points of a span that need a close look. `free`: those of the span that move,
  /// 0 where they do not or have been moved. Returns the longest way of a point [m].
  double project_closely(ColliderCache&, const Span&, const ContactSlots::Detector&, const Cloth&,
                         const Points& start, Points& positions, double* free);

  /// The same of a point that needs a close look; nothing for one that does not.
  std::optional<double> project_closely(ColliderCache&, int point, const ContactSlots::Detector&,
                                        const Points& start, Points& positions);

  /// The same of triangles.
  double project_faces(ColliderCache&, const MovingCollider&, const Cloth&, const Points& start,
                       Points& positions);

  ColliderCache& cache(int collider) { return caches_[static_cast<std::size_t>(collider)]; }

  double stretch_ = 0;                 // of the step, see ContactStep
  double h_ = 0;                       // step of the impulses [s]
  std::vector<ColliderCache> caches_;  // by collider
  MotionBound motion_bound_;
  FaceContacts faces_;
  Pinches pinches_;
  Stacks stacks_;
  bool has_pinched_ = false;          // in the step before
  bool is_restored_pinched_ = false;  // likewise, as it was written
  bool recovers_ = false;
  double leaving_ = 0;          // time of steps in which it did, less others [s]
  double recovery_factor_ = 1;  // of the step
  LocalCloth local_;            // about a collider whose faces count
};

}  // namespace clothsim
