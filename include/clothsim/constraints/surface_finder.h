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
class SurfaceFinder {
 public:
  explicit SurfaceFinder(const Cloth& cloth) : near_(cloth) {}

  /// Adds what touches after a step to `state`.
  void find(const Cloth&, const ContactStep&, const State&, ContactList&);

  /// Impulses alone part what is closer than it may be: moving it at once would shake piles.
  void correct(const Cloth&, Points&) const {}

  /// As keep_from_crossing().
  int guard(const Cloth&, const ContactStep&, const Points& by_impulses, State&);

  void seek_anew() { near_.forget(); }
  void write(MemoryWriter& memory) const { near_.write(memory); }
  void read(MemoryReader& memory, const Cloth&) { near_.read(memory); }

 private:
  struct Sought;

  static std::optional<Contact> contact_of(const Sought&, const NearPair&, const Contact* last);

  NearPairs near_;
};

}  // namespace clothsim
