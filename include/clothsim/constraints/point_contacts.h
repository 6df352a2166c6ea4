#pragma once

#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/geometry/cell_list.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// A cloth's own points kept 2 * thickness apart: no restitution, Coulomb friction, impulses kept
/// from step to step, equal and opposite, weighted by inverse mass.
///
/// Pairs that lie within twice that distance at rest are left out: a fold between them has no room
/// for a layer. Points cannot see an edge or a face pass between them; this is the cheap method.
class PointContacts {
 public:
  /// Finds touching pairs after a step to `state`, and gives them their last impulses.
  void begin(const Cloth&, const ContactStep&, State&);

  /// Acts no more on what colliders hold. Takes back from the velocities [m/s] what begin() gave.
  void leave_to(const Pinches&, const Cloth&, Points& velocities);

  /// One pass over the pairs, whatever the `precision` [m]. Returns the largest change as a
  /// displacement in h [m].
  double sweep(const Cloth&, double precision, Points& velocities, const Workers& = {});

  /// Moves pairs that are closer than they may be apart, in one pass.
  void correct(const Cloth&, Points& positions) const;

  /// Nothing holds points back.
  int guard(const Cloth&, const ContactStep&, const Points&, State&) const { return 0; }

  /// Adds the impulses [N s] of the last step, times `scale`, to those of their points, N x 3.
  void add_impulses(double scale, Points& sum) const;

  /// As of SelfTouches, in the last step.
  void for_each_touch(const Cloth&, const std::function<void(const SelfTouch&)>& visit) const;

  /// To be called when other points than before are held: pairs of two are left out.
  void seek_anew() { found_at_.resize(0, 3); }

  /// Pairs that a pass looks at.
  std::size_t size() const { return contacts_.size(); }

  /// Pairs that carry an impulse.
  int count() const;

  /// Forgets the impulses.
  void reset();

  /// The impulses, and where pairs were sought last. `read` throws InvalidValue for what was not
  /// written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, const Cloth&);

 private:
  struct Contact {
    PointPair pair;
    double inv_mass;         // of both together [1/kg]
    ContactImpulse impulse;  // of a on b [N s]
  };

  /// Pairs that may touch, at `positions` unless those of an earlier call still serve.
  void find_candidates(const Cloth&, const Points& positions, double distance, WorkBudget*);
  void seek(const Cloth&, const Points& positions, double distance, WorkBudget*);

  double h_ = 0;
  PairFinder finder_;
  std::vector<PointPair> candidates_;  // sorted; hold while no point moves by skin / 2
  Points found_at_;                    // positions when candidates_ were found
  double skin_ = 0;                    // [m]
  std::vector<Contact> contacts_;      // by pair
  std::vector<Contact> last_;
};

}  // namespace clothsim
