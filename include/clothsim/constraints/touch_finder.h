#pragma once

#include <optional>

#include "clothsim/constraints/contact_list.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {

/// `kind`: points or surface, neither off nor automatic.
inline Tiling::Range stencils_of(SelfCollision kind) {
  return kind == SelfCollision::surface ? Tiling::of_surfaces : Tiling::of_points;
}

/// Detects self contacts, see NearestDistances: points and triangles, edges and edges, or points
/// alone.
///
/// Impulses alone keep features apart: a projection of overlaps would shake piles. With surfaces,
/// residual motion cannot cross either, see keep_from_crossing(): a cloth without crossings stays
/// without. With points alone, the cheap method, an edge or a face may pass between points.
///
/// Detection and guard run as often as the motion of points requires: not in each of the steps that
/// are short for the springs' sake. The guard always runs in a frame's last step.
class TouchFinder {
 public:
  TouchFinder(const Cloth& cloth, SelfCollision kind)
      : kind_(kind), near_(cloth, stencils_of(kind)) {}

  /// Adds the contacts after a step to `state`.
  void find(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// Updates the contacts with an impulse in another step to `state`. Others are kept.
  void refresh(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// keep_from_crossing(), for the path since the last detection, or from the step's start where
  /// the guard has checked the path since then; 0 where that can wait. With points alone nothing is
  /// truncated.
  int guard(const Cloth&, const ContactStep&, const Points& by_impulses, State&);

  void restart_detection() {
    near_.forget();
    looked_at_.resize(0, 3);
  }
  void write(MemoryWriter& memory) const { near_.write(memory); }
  void read(MemoryReader& memory) {
    restart_detection();
    near_.read(memory);
  }

 private:
  struct Query;

  Query query_in(const Cloth&, const ContactStep&, const State&) const;
  void look(const ContactStep&);
  int guard_path(const Cloth&, const ContactStep&, const Points& by_impulses, State&);
  static std::optional<Contact> contact_of(const Query&, const NearPair&, const Contact* last);

  SelfCollision kind_;
  NearPairs near_;
  Points middle_;     // where impulses of a step act, for points that may touch in it [m]
  Points looked_at_;  // positions at the last detection, until the guard has checked the path from
                      // there [m]; then no rows
  double time_ = 0;   // since then [s]
  /// Displacement of a point since then, relative to the mean of all, at most [m].
  double max_displacement_ = 0;
};

}  // namespace clothsim
