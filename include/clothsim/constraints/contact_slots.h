#pragma once

#include <algorithm>
#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/rigid_motion.h"
#include "clothsim/constraints/sleep_bounds.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/moving_collider.h"
#include "clothsim/shapes/signed_distances.h"

namespace clothsim {

/// Contacts of the points of a cloth with one collider, a slot for each point: loops over blocks of
/// points vectorise, and impulses stay in place from step to step.
///
/// The law is that of ContactImpulse::update(). Blocks without contacts are skipped. Results do not
/// depend on the division into blocks.
class ContactSlots {
 public:
  /// Points of a block: as many as the widest vector unit takes.
  static constexpr int block = num_lanes;

  static int num_blocks(const Cloth& cloth) { return (cloth.num_points() + block - 1) / block; }

  static int first_of(int b) { return b * block; }
  static int end_of(int b, const Cloth& cloth) {
    return std::min((b + 1) * block, cloth.num_points());
  }

  static bool has_pin(int b, const Cloth& cloth) {
    const int first = first_of(b);
    return cloth.inv_mass.segment(first, end_of(b, cloth) - first).minCoeff() == 0;
  }

  /// Vectors of the points of a block.
  struct Triples {
    alignas(64) double x[block];
    alignas(64) double y[block];
    alignas(64) double z[block];

    MutablePointRun run() { return {x, y, z}; }
    Vector3 get(int i) const { return {x[i], y[i], z[i]}; }
    void set(int i, const Vector3& v) {
      x[i] = v.x();
      y[i] = v.y();
      z[i] = v.z();
    }
  };

  /// Contacts of the points of a block, see ContactImpulse.
  struct Block {
    Triples normal;
    Triples surface;                            // velocity of the surface [m/s]
    alignas(64) double target_velocity[block];  // -infinity: no contact
    alignas(64) double normal_impulse[block];   // 0 except in active blocks
    Triples friction_impulse;                   // 0 except in active blocks
    // Velocities of the points after the last pass: no update until they change.
    Triples left;
  };

  /// No contacts, with as many slots as the cloth has points.
  void reset(const Cloth&);

  bool fits(const Cloth& cloth) const { return points_ == cloth.num_points(); }

  /// Data for the detection of contacts with one collider in a step.
  struct Detector {
    /// `offset`: that points keep from the surface, those of the thickest cloth [m]. `query`: for
    /// all points. Nothing farther away than its `near` can touch.
    Detector(const MovingCollider&, const Cloth&, double offset, const MeshQuery& query);

    const MovingCollider& collider;
    const Cloth& cloth;
    Frame frame;
    Frame before;   // at the step's start
    double offset;  // [m]

    double offset_at(int point) const { return offset - cloth.nearer_by(point); }
    /// Adds to the distances of points, from `first` on, how much nearer than `offset` they come.
    void add_nearer(int first, int count, double* distances) const;

    /// `query` for the points from `first` on.
    MeshQuery query(int first) const;

   private:
    MeshQuery query_;
  };

  /// Keeps the contacts of the last step for a warm start.
  void start_over();

  /// Finds the contacts of some blocks. To be called in ascending order. `nearest`: by block, the
  /// distance of its nearest point from the surface; of blocks with impulses -infinity [m].
  void find(const Span&, const Detector&, const Cloth&, const ContactStep&, const State&,
            double* nearest);

  /// Sets the contact of one point, whether it was detected or not: with a surface of this normal,
  /// and a normal velocity of at least `target_velocity` [m/s].
  void put(int point, const Vector3& normal, const Vector3& surface_velocity,
           double target_velocity);

  /// Keeps a contact from pushing its point away from the surface.
  void forbid_recovery(int point) {
    double& target = at(point / block).target_velocity[point % block];
    target = std::min(target, 0.0);
  }

  /// Ends an existing contact.
  void remove(int point);

  /// To be called when all contacts of a step have been found: clears the impulses of blocks
  /// without contacts.
  void close();

  /// Gives the points the impulses of the last step, `scale` times as large.
  void warm_start(const Cloth&, double scale, Points& velocities);

  /// Adds the changes of velocities by the impulses [m/s].
  void add_velocities(Points& sum) const;

  /// One pass. Returns the square of the largest change of a velocity [m^2/s^2].
  double solve_pass(double friction, Points& velocities);

  /// The same for a rigid body with this motion, whose velocity changes, too: one contact after
  /// another. Returns the largest change of a relative velocity [m/s].
  double solve_pass(double friction, const Cloth&, const Points& positions, RigidMotion&,
                    Points& velocities);

  /// Moves points of some blocks, at `positions` after a step from `start`, to the offset. Points
  /// that are not `free`, from the first on, stay. `min_distances`: by block, least distance of a
  /// point from the surface [m]. Returns the largest displacement of a point [m].
  static double project_positions(const Span&, const Detector&, const double* free,
                                  const Points& start, Points& positions, double* min_distances);

  /// Does a point have a contact in this step?
  bool touches(int point) const {
    return has_active(point / block) &&
           at(point / block).target_velocity[point % block] > -infinity;
  }
  /// Does a point have an impulse (before warm_start(): of the last step)?
  bool has_impulse(int point) const { return at(point / block).normal_impulse[point % block] > 0; }
  bool has_active(int b) const {
    return !is_active_.empty() && is_active_[static_cast<std::size_t>(b)] != 0;
  }

  /// Blocks with contacts, ascending.
  const std::vector<int>& active() const { return active_; }

  ContactImpulse contact(int point, double friction) const;
  Vector3 normal(int point) const { return at(point / block).normal.get(point % block); }

  /// Adds the impulses of the points, at `positions`, on the collider in the step: impulse [N s]
  /// and its moment about `origin` [N m s]. `masses`: impulse by change of velocity, by point [kg].
  void add_impulses(const Scalars& masses, const Vector3& origin, const Points& positions,
                    Wrench& sum) const;

  /// Contacts that carry an impulse.
  int count() const;
  /// Calls visit(point, impulse) for each of these.
  template <typename Visit>
  void for_each_with_impulse(Visit&& visit) const {
    for (const int b : active_) {
      for (int i = first_of(b); i < end_of(b); ++i) {
        if (has_impulse(i)) visit(i, contact(i, 0));
      }
    }
  }
  /// Calls visit(point) for each that touches this collider and the `other` one.
  template <typename Visit>
  void for_each_touching_both(const ContactSlots& other, Visit&& visit) const {
    for (const int b : active_) {
      if (!other.has_active(b)) continue;
      for (int i = first_of(b); i < end_of(b); ++i) {
        if (touches(i) && other.touches(i)) visit(i);
      }
    }
  }

  /// Sets an impulse, for a warm start or of a contact. Points in ascending order where they have
  /// no contact.
  void set_impulse(int point, const ContactImpulse&);

 private:
  double least_distance(int b, const double* distances) const;
  int end_of(int b) const { return std::min((b + 1) * block, points_); }
  Block& at(int b) { return blocks_[static_cast<std::size_t>(b)]; }
  const Block& at(int b) const { return blocks_[static_cast<std::size_t>(b)]; }
  void activate(int b);
  void clear(int b);

  int points_ = 0;
  std::vector<Block> blocks_;
  std::vector<int> active_;  // blocks with contacts
  std::vector<int> last_active_;
  std::vector<char> is_active_;  // by block
};

}  // namespace clothsim
