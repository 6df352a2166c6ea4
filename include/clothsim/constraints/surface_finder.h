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

/// A cloth's own surface that touches itself, 2 * thickness apart: points and triangles, edges and
/// edges.
///
/// Impulses keep layers apart; what they leave over cannot cross either, see keep_from_crossing().
/// So a cloth that does not cross itself never does.
///
/// What is near is sought, and ways are judged, as often as points move: in steps that are short
/// for the springs' sake, not in each. A frame's last step has its way judged in any case.
class SurfaceFinder {
 public:
  explicit SurfaceFinder(const Cloth& cloth) : near_(cloth) {}

  /// Adds what touches after a step to `state`.
  void find(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// Impulses alone part what is closer than it may be: moving it at once would shake piles.
  void correct(const Cloth&, Points&) const {}

  /// As keep_from_crossing(), from where it last looked on, or where it has judged the way from
  /// there, from the step's start on; 0 where that can wait.
  int guard(const Cloth&, const ContactStep&, const Points& by_impulses, State&);

  void seek_anew() {
    near_.forget();
    looked_at_.resize(0, 3);
  }
  void write(MemoryWriter& memory) const { near_.write(memory); }
  void read(MemoryReader& memory, const Cloth&) {
    seek_anew();
    near_.read(memory);
  }

 private:
  struct Sought;

  void look(const ContactStep&);
  static std::optional<Contact> contact_of(const Sought&, const NearPair&, const Contact* last);

  NearPairs near_;
  Points looked_at_;  // positions, until the guard has judged the way from there [m]; then no rows
  double time_ = 0;   // since then [s]
  double way_ = 0;    // of a point since then, beyond the mean of all, at most [m]
};

}  // namespace clothsim
