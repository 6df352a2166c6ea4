#pragma once

#include <optional>
#include <vector>

#include "clothsim/constraints/contact_list.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {

/// Of points or of surfaces, not off nor automatic.
inline Tiling::Range stencils_of(SelfCollision kind) {
  return kind == SelfCollision::surface ? Tiling::of_surfaces : Tiling::of_points;
}

/// Finds where a cloth touches itself, 2 * thickness apart: points and triangles, edges and edges,
/// or points alone.
///
/// Impulses alone keep them apart: moving at once what is too close would shake piles. Of surfaces
/// what they leave over cannot cross either, see keep_from_crossing(): a cloth that does not cross
/// itself never does. Points cannot see an edge or a face pass between them; this is the cheap
/// method.
///
/// What is near is sought, and ways are judged, as often as points move: in steps that are short
/// for the springs' sake, not in each. A frame's last step has its way judged in any case.
class TouchFinder {
 public:
  TouchFinder(const Cloth& cloth, SelfCollision kind)
      : kind_(kind), near_(cloth, stencils_of(kind)) {}

  /// Adds what touches after a step to `state`.
  void find(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// Aims those that push anew in another step to `state`. Others are kept.
  void refresh(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// As keep_from_crossing(), from where it last looked on, or where it has judged the way from
  /// there, from the step's start on; 0 where that can wait. Nothing holds points alone back.
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
  int judge(const Cloth&, const ContactStep&, const Points& by_impulses, State&);
  static std::optional<Contact> contact_of(const Query&, const NearPair&, const Contact* last);

  SelfCollision kind_;
  NearPairs near_;
  Points middle_;     // where impulses of a step act, of points that may touch in it [m]
  Points looked_at_;  // positions, until the guard has judged the way from there [m]; then no rows
  double time_ = 0;   // since then [s]
  double way_ = 0;    // of a point since then, beyond the mean of all, at most [m]
};

}  // namespace clothsim
