#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "clothsim/constraints/body_contacts.h"
#include "clothsim/constraints/collider_exit.h"
#include "clothsim/constraints/contact_coupling.h"
#include "clothsim/constraints/contact_slots.h"
#include "clothsim/constraints/face_contacts.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/rigid_bodies.h"
#include "clothsim/constraints/sleep_bounds.h"
#include "clothsim/constraints/stacks.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Contact of a cloth with colliders: no penetration, no restitution, Coulomb friction.
///
/// Contact acts on velocities, as the strain limit does: a normal impulse that lets a point come
/// closer by at most its gap within a step, and a friction impulse of at most friction times the
/// normal one against sliding on the (moving) surface (Moreau 1988, "Unilateral contact and dry
/// friction in finite freedom dynamics"). So a point slips on an incline exactly when tan(angle) >
/// friction, with acceleration g (sin - friction cos). Impulses are kept for the warm start of the
/// next step. A point that is so fast that its path crosses the shape is put where the path enters,
/// and continues along the surface. Edges and faces have contacts too where contacts of points
/// alone would let a shape enter triangles.
///
/// Cloth in a collider leaves it at recovery_speed at most, and ever more slowly where pins hold it
/// inside. A point leaves by its nearest surface; but if any is deeper than safe_depth(), or if the
/// collider was turned on or put there, all points in it leave in one direction. Points that two
/// colliders leave no room are held between them.
class ColliderContacts {
 public:
  /// Detects the contacts after a step from step.start to state, and warm-starts their impulses.
  void prepare(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// May steps skip detection and use the contacts of prepare()? Not while colliders push out or
  /// pinch.
  bool is_settled() const;

  /// Updates, in another step of the same length, the contacts of prepare() without detection: for
  /// the points that were near and the triangles that touched.
  void refresh(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&, State&);

  /// One pass over the contacts, of points at `positions`. Returns the largest change as a
  /// displacement in h [m]. `bodies`: none or those of the scene, whose velocities change, too.
  double solve_pass(const Cloth&, const Points& positions, RigidBodies*, Points& velocities);

  /// One pass over the places between a body and another collider. Returns the largest change of a
  /// relative velocity [m/s].
  double solve_coupled(const Cloth&, const Points& positions, RigidBodies&, Points& velocities);

  /// After the end of a step of bodies: follows their displacement, before positions are projected.
  void follow_bodies(const std::vector<MovingCollider>&, const RigidBodies&,
                     const Points& positions);

  /// Overlaps of bodies and other colliders that points between them show, less the cloth's
  /// thickness.
  std::vector<Overlap> overlaps(const std::vector<MovingCollider>&, const Cloth&,
                                const Points& positions) const;

  /// Moves points that are inside a collider to its surface. Velocities between colliders that push
  /// against each other become those of the motion that is left.
  void project_positions(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                         State&);

  /// The same after refresh(), for the points near a collider only.
  void project_near(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                    Points& positions);

  /// The same once more in a step without pinched points, after others have moved the points on
  /// from `start`.
  void project_again(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                     Points& positions);

  /// Adds the impulses of the cloth, at `positions`, on each collider in the step: impulse [N s]
  /// and its moment about the origin of the collider's frame [N m s], in the world. `masses`:
  /// impulse by change of velocity, by point [kg]. All changes of velocities count, also those of
  /// recovery; displacements by project_positions() do not.
  void add_impulses(const std::vector<MovingCollider>&, const Scalars& masses,
                    const Points& positions, std::vector<Wrench>& sums) const;

  /// Adds the changes of velocities by the contacts of points and faces, and by pinches, in the
  /// step [m/s].
  void add_velocities(Points& sum) const {
    for (const ColliderCache& s : caches_) s.slots.add_velocities(sum);
    faces_.add_velocities(sum);
    pinches_.add_velocities(sum);
  }

  /// Number of contacts that carry an impulse and of points that are pinched.
  int count() const;

  /// Do triangles touch with more than corners?
  bool has_faces() const { return faces_.size() > 0; }

  /// Is any place of the cloth between a rigid body and another collider?
  bool is_between_bodies() const { return !coupled_.empty(); }

  /// Points that two colliders leave no room.
  const Pinches& pinches() const { return pinches_; }
  Pinches& pinches() { return pinches_; }

  /// Do triangles have contacts of their own with any of these, or do two colliders pinch the
  /// cloth?
  bool has_edges(const std::vector<MovingCollider>&, const Cloth&) const;

  /// Was any part of the cloth in a collider when the step began?
  bool recovers() const { return recovers_; }

  /// Have colliders pushed out cloth in recent substeps?
  bool has_recovered_recently() const { return recovery_duration_ > 0; }
  /// Factor on the recovery speed, see ContactStep.
  double recovery_factor() const { return recovery_factor_after(recovery_duration_); }
  /// Resets the recovery factor to 1, so that cloth is pushed out at full speed again: to be called
  /// when something has moved.
  void reset_recovery() { recovery_duration_ = 0; }

  /// To be called when a collider was put elsewhere: cloth may be in it.
  void jump(std::size_t collider);
  /// The same for colliders that free points at `positions` are in, after read().
  void find_jumps(const std::vector<MovingCollider>&, const Cloth&, const Points& positions);

  /// To be called when a collider was turned on, or put elsewhere by more than its safe_depth():
  /// the next detection chooses how cloth in it leaves.
  void put_on(std::size_t collider);

  /// The exits by collider; may have fewer entries than there are colliders.
  std::vector<ColliderExit> exits() const;
  void set_exits(const std::vector<ColliderExit>&);

  /// Forgets the impulses, the distances of earlier steps, the pinches, the exits and the time of
  /// recovery.
  void reset();

  /// The impulses, the ways out of colliders, and those that no free point of the cloth, at
  /// `positions`, is in. `read` throws InvalidValue for data that is not from `write` for the same
  /// numbers of colliders and points.
  void write(MemoryWriter&, const std::vector<MovingCollider>&, const Points& positions) const;
  void read(MemoryReader&, std::size_t colliders, const Cloth&);

 private:
  /// Contacts of the cloth with one collider, and distances for their detection.
  struct ColliderCache {
    ContactSlots slots;
    SleepBounds sleep_bounds;
    std::vector<Span> near;    // blocks that may touch it before the next detection, ascending
    std::vector<Span> inside;  // blocks that may be in it as a step ends
    double friction = 0;
    double keeps = 0;                // distance that points keep from its surface [m]
    double within = 0;               // distance within which blocks are `near` [m]
    double moved = 0;                // displacement of its surface in this step, at most [m]
    bool has_faces = false;          // whether triangles may touch it in this step
    bool is_clear = false;           // no free point was in it as the last step ended
    bool is_restored_clear = false;  // the same, as it was written
    bool is_close = false;           // whether this step checks its points one by one
    ColliderExit exit;
    /// Common direction in which points leave it in this step, in its frame, unit.
    std::optional<Vector3> exit_direction;
    double exit_speed = 0;     // along exit_direction [m/s]
    std::vector<char> leaves;  // by point: it leaves along exit_direction
    MeshMemory mesh;

    MeshQuery query(const MovingCollider&, const Cloth&, double near);
  };

  /// Points and triangles that were in a collider when a step began, with the depth of the points
  /// [m].
  struct Penetration {
    int collider;
    std::vector<std::pair<int, double>> points;
    std::vector<PenetratingFace> faces;

    double depth() const;  // greatest [m], 0 without penetration
  };

  /// Finds the contacts of all colliders; one Penetration for each in reach.
  std::vector<Penetration> find(const std::vector<MovingCollider>&, const Cloth&,
                                const ContactStep&, State&);
  void find_at(ColliderCache&, const MovingCollider&, const Cloth&, const ContactStep&,
               double speed, double drift, State&, Penetration&);

  /// Finds the contacts of the points near a collider, except for those that need a close look.
  /// `travelled`: by all points so far, at most, for the sleep of blocks; empty: they do not sleep.
  static void find_points(ColliderCache&, const MovingCollider&, const Cloth&, const ContactStep&,
                          const State&, std::optional<double> travelled);
  /// Ends new contacts of points that pass by a rim without coming nearer: there the tangent plane
  /// of a contact would throw a body that slides up.
  static void leave_out_passing(ColliderCache&, const MovingCollider&, const Cloth&,
                                const ContactStep&, const State&);
  /// Ends the detection of contacts of points, and warm-starts their impulses, times `scale`.
  void warm_start(const Cloth&, double scale, RigidBodies*, State&);

  /// Updates the cache for the pose of the collider in this step.
  void follow(ColliderCache&, const MovingCollider&, const Points& positions) const;

  /// Is no free point in the collider as a step begins with the cloth at `positions`?
  bool stays_clear(const ColliderCache&, const MovingCollider&, const Points& positions) const;

  /// Can triangles come within `distance` [m] of the collider?
  bool is_near_faces(const ColliderCache&, const Clearance&, double distance) const;

  /// Finds the contact of a point again if the step may have taken it through the shape, or if it
  /// was inside when the step began.
  void look_closely(ColliderCache&, int point, const ContactSlots::Detector&, const ContactStep&,
                    State&, Penetration&);

  /// Contacts of a place between a body and another collider.
  struct Coupled {
    std::size_t a;         // the body
    std::size_t b;         // the other collider
    int point;             // in contact with both; -1: those of `face` are in contact with b
    std::size_t face = 0;  // contact of the body, in faces_
    double strongest = 0;  // normal impulse [N s]
  };

  /// Finds the places of the cloth between a body and another collider.
  void couple(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
              const Points& positions);
  /// Bounds their impulses, see RigidBodies::strongest_force().
  void bound_coupled(const ContactStep&, const Points& positions);
  void couple_points(std::size_t a, std::size_t b);
  void couple_faces(std::size_t a, std::size_t b, const Cloth&);
  double solve_coupled(const Coupled&, const Cloth&, const Points& positions, RigidBodies&,
                       Points& velocities);

  /// Finds the points that colliders leave no room, holds them, and removes them from the
  /// penetrations.
  void find_pinched(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
                    std::vector<Penetration>&);
  void pinch(const std::vector<MovingCollider>&, const Cloth&, const ContactStep&,
             const std::vector<Penetration>&);
  /// Bounds of the places where a collider touches, and of the normals there.
  struct Touched {
    Normals normals;
    Eigen::AlignedBox3d places;  // of points, with the corners of triangles [m]
  };
  Touched touched_by(int number, const Cloth&, const Points& positions);
  ContactManifold manifold_of(int number, const MovingCollider&, const Cloth&);

  /// Chooses how cloth leaves colliders that were put on it, and ends exits of cloth that is out.
  void choose_exits(const std::vector<Penetration>&, const std::vector<MovingCollider>&,
                    const Cloth&, const ContactStep&, const Points& positions);
  ColliderExit chosen_exit(const Penetration&, const std::vector<MovingCollider>&, const Cloth&,
                           const ContactStep&, const Points& positions);

  /// Marks the points that leave.
  void mark_leaving(const Penetration&, const Cloth&);

  /// Does another collider, that is no body, lie in the way of the points that leave collider
  /// `left` in a direction?
  bool is_blocked(const std::vector<MovingCollider>&, std::size_t left, const Cloth&,
                  const ContactStep&, const Points& positions, const Vector3& direction) const;

  /// Does another collider overlap this one where the cloth is, by more than jaws that hold the
  /// cloth may? A plane may by put_on_depth, other shapes by the cloth's thickness.
  static bool is_overlapped(const Penetration&, const std::vector<MovingCollider>&, const Cloth&,
                            const Points& start);

  void write_exits(MemoryWriter&) const;
  void read_exits(MemoryReader&, std::size_t colliders);

  /// Sets the common direction in which the points of a penetration leave a collider, if they have
  /// one.
  void leave_together(const Penetration&, const MovingCollider&, const Cloth&, const ContactStep&,
                      const Points& positions);

  /// Points in a collider have been moved out by `distance` [m] at most.
  void moved_out(std::size_t collider, double distance);
  /// Moves points that are in any collider out.
  void project_all(const std::vector<MovingCollider>&, const Cloth&, const Points& start,
                   Points& positions);
  /// Moves points that are in one collider out. Returns the largest displacement of a point [m].
  double project_at(std::size_t number, const MovingCollider&, const Cloth&, const Points& start,
                    Points& positions);

  /// The same for the points of a span that need a close look. `free`: positive for points of the
  /// span that move, 0 for points that do not or have been moved. Returns the largest displacement
  /// of a point [m].
  double project_closely(ColliderCache&, const Span&, const ContactSlots::Detector&, const Cloth&,
                         const Points& start, Points& positions, double* free);

  /// The same for a point that needs a close look; empty for one that does not.
  std::optional<double> project_closely(ColliderCache&, int point, const ContactSlots::Detector&,
                                        const Points& start, Points& positions);

  /// The same for triangles.
  double project_faces(std::size_t number, const MovingCollider&, const Cloth&, const Points& start,
                       Points& positions);

  /// Whether a triangle in contact is deeper than projections leave it. Edges turn about each
  /// other, so a step in which nothing moves by more than `in_step` [m] sinks a triangle by
  /// in_step^2 / (2 offset) at most.
  bool has_sunk(std::size_t number, const MovingCollider&, const Cloth&, double in_step,
                const Points& positions) const;

  ColliderCache& cache(int collider) { return caches_[static_cast<std::size_t>(collider)]; }

  double stretch_ = 0;                 // of the step, see ContactStep
  double h_ = 0;                       // step of the impulses [s]
  std::vector<ColliderCache> caches_;  // by collider
  MotionBound motion_bound_;
  FaceContacts faces_;
  Pinches pinches_;
  Stacks stacks_;
  std::vector<Coupled> coupled_;      // in this step
  bool has_pinched_ = false;          // in the step before
  bool is_restored_pinched_ = false;  // the same, as it was written
  bool recovers_ = false;
  double recovery_duration_ = 0;  // time of steps with recovery, less that of others [s]
  double recovery_factor_ = 1;    // of the step
  Points unprojected_;            // positions before project_positions(), while points recover
  LocalCloth local_;              // relative to a collider whose faces count
};

}  // namespace clothsim
