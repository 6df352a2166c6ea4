#pragma once

#include <vector>

#include "clothsim/constraints/contact_list.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/geometry/cell_list.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// A cloth's own points that touch, 2 * thickness apart.
///
/// Pairs that lie within twice that distance at rest are left out: a fold between them has no room
/// for a layer. Points cannot see an edge or a face pass between them; this is the cheap method.
class PointFinder {
 public:
  /// Adds the pairs that touch after a step to `state`.
  void find(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// Moves pairs that are closer than they may be apart, in one pass.
  void correct(const Cloth&, Points& positions) const;

  /// Nothing holds points back.
  int guard(const Cloth&, const ContactStep&, const Points&, State&) const { return 0; }

  /// Looks for all pairs anew in the next step.
  void seek_anew() { found_at_.resize(0, 3); }

  /// Where pairs were sought last. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, const Cloth&);

 private:
  /// Pairs that may touch, at `positions` unless those of an earlier call still serve.
  void find_candidates(const Cloth&, const Points& positions, double distance, WorkBudget*);
  void seek(const Cloth&, const Points& positions, double distance, WorkBudget*);

  PairFinder finder_;
  std::vector<PointPair> candidates_;  // sorted; hold while no point moves by skin / 2
  Points found_at_;                    // positions when candidates_ were found
  double skin_ = 0;                    // [m]
};

}  // namespace clothsim
