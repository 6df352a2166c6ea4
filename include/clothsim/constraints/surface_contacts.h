#pragma once

#include <array>
#include <optional>
#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/search/changed_points.h"
#include "clothsim/search/near_pairs.h"

namespace clothsim {

/// A cloth's own surface kept from passing through itself, and 2 * thickness apart: points against
/// triangles and edges against edges, no restitution, Coulomb friction, impulses kept from step to
/// step, equal and opposite, weighted by inverse mass.
///
/// Impulses keep layers apart; what they leave over cannot cross either, see keep_from_crossing().
/// So a cloth that does not cross itself never does.
class SurfaceContacts {
 public:
  explicit SurfaceContacts(const Cloth&);

  /// Finds what touches after a step to `state`, and gives it its last impulses.
  void begin(const Cloth&, const ContactStep&, State&);

  /// Acts no more on what colliders hold. Takes back from the velocities [m/s] what begin() gave.
  void leave_to(const Pinches&, const Cloth&, Points& velocities);

  /// One pass over the contacts, but for those where nothing has changed that matters to a
  /// `precision` [m]. Returns the largest change as a displacement in h [m].
  double sweep(const Cloth&, double precision, Points& velocities, const Workers& = {});

  /// Impulses alone part what is closer than it may be: moving it at once would shake piles.
  void correct(const Cloth&, Points&) const {}

  /// As keep_from_crossing().
  int guard(const Cloth&, const ContactStep&, const Points& by_impulses, State&);

  /// Adds the impulses [N s] of the last step, times `scale`, to those of their points, N x 3.
  void add_impulses(double scale, Points& sum) const;

  /// As of SelfTouches, in the last step.
  void for_each_touch(const Cloth&, const std::function<void(const SelfTouch&)>& visit) const;

  /// To be called when other points than before are held.
  void seek_anew() {}

  /// Contacts that a pass looks at.
  std::size_t size() const { return contacts_.size(); }

  /// Contacts that carry an impulse.
  int count() const;

  /// Forgets the impulses.
  void reset();

  /// The impulses. `read` throws InvalidValue for what was not
  /// written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, const Cloth&);

 private:
  struct Contact {
    std::uint64_t key;  // of the pair
    std::array<int, 4> points;
    std::array<double, 4> weights;  // see Separation
    double mass;                    // of the closest points together [kg]
    double nearest;                 // how near these may come [m]
    ContactImpulse impulse;         // of b on a [N s]
  };

  /// Contacts on either side of a plane, which have no point in common, and those across it: passes
  /// go over both sides at once, then over the rest.
  enum Group { one_side, other_side, across, num_groups };

  /// A contact, by number, and its points: most passes look at no more of it.
  struct Place {
    std::array<int, 4> points;
    int contact;
  };

  void group(const Points& positions);
  double sweep_group(Group, const Cloth&, double least, Points& velocities);
  bool is_nearest_on_surface(const SurfacePair&, const Separation&) const;
  std::optional<Contact> find(const Cloth&, const NearPair&, bool held, const Points& middle,
                              const Points& velocities) const;

  NearPairs near_;
  double h_ = 0;
  /// Between two features, but for what stops them: the cloth's weight in a step [N s]. What
  /// presses layers with more, as fingers that leave them no room, gets them closer; it would shake
  /// them.
  double strongest_push_ = 0;
  double most_to_part_ = 0;        // of what works off an overlap [N s]
  std::vector<Contact> contacts_;  // by key
  std::vector<Contact> last_;
  std::array<std::vector<Place>, num_groups> groups_;
  ChangedPoints changed_;
};

}  // namespace clothsim
