#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "clothsim/constraints/contact_list.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/touch_finder.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Contact of a cloth with itself: no restitution, Coulomb friction, impulses kept from step to
/// step, equal and opposite, weighted by inverse mass.
class SelfContacts {
 public:
  /// `kind`: points or surface, neither off nor automatic.
  SelfContacts(const Cloth& cloth, SelfCollision kind) : finder_(cloth, kind) {}

  /// Detects the contacts after a step to `state`, and warm-starts their impulses.
  void prepare(const Cloth&, const ContactStep&, State&);

  /// The same in another step of the same length, without detection: for the contacts of prepare().
  void refresh(const Cloth&, const ContactStep&, State&);

  /// Ends contacts of points that colliders hold. Takes the impulses of prepare() back from the
  /// velocities [m/s].
  void release_pinched(const Pinches&, Points& velocities);

  /// One pass over the contacts, except for those without a change that matters to a `tolerance`
  /// [m]. Returns the largest change as a displacement in h [m].
  double solve_pass(double tolerance, Points& velocities, const Workers& = {});

  /// Truncates displacements through the cloth itself, see keep_from_crossing(). Returns the number
  /// of truncated points.
  int guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses, State& state) {
    return finder_.guard(cloth, step, by_impulses, state);
  }

  /// Adds the changes of velocities by the impulses [m/s].
  void add_velocities(Points& sum) const { contacts_.add_velocities(sum); }

  /// Adds the impulses [N s] of the last step to those of their points, N x 3.
  void add_impulses(Points& sum) const;

  /// Calls visit(touch) for each contact of the last step.
  void for_each_touch(const std::function<void(const SelfTouch&)>& visit) const;

  /// To be called when the set of held points has changed.
  void restart_detection() { finder_.restart_detection(); }

  /// Contacts, with or without an impulse.
  std::size_t size() const { return contacts_.contacts().size(); }

  /// Contacts that carry an impulse.
  int count() const { return contacts_.count(); }

  /// Forgets the impulses and the tracked pairs.
  void reset();

  /// The state for the next step. `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  TouchFinder finder_;
  ContactList contacts_;
  double h_ = 0;       // of the last step [s]
  double weight_ = 0;  // weight of the cloth in it [N s]
};

/// The self contacts of `cloth`; none where it may pass through itself.
std::optional<SelfContacts> make_self_contacts(const Cloth& cloth);

}  // namespace clothsim
