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

/// A cloth kept off itself: no restitution, Coulomb friction, impulses kept from step to step,
/// equal and opposite, weighted by inverse mass.
class SelfContacts {
 public:
  /// Of points or of surfaces, not off nor automatic.
  SelfContacts(const Cloth& cloth, SelfCollision kind) : finder_(cloth, kind) {}

  /// Finds what touches after a step to `state`, and gives it its last impulses.
  void prepare(const Cloth&, const ContactStep&, State&);

  /// The same in another step of the same length, of the contacts that prepare() found alone.
  void refresh(const Cloth&, const ContactStep&, State&);

  /// Acts no more on what colliders hold. Takes back from the velocities [m/s] what prepare() gave.
  void release_pinched(const Pinches&, Points& velocities);

  /// One pass over the contacts, but for those where nothing has changed that matters to a
  /// `precision` [m]. Returns the largest change as a displacement in h [m].
  double solve_pass(double precision, Points& velocities, const Workers& = {});

  /// Holds back what would cross itself, from a step on: see keep_from_crossing(). Returns how many
  /// points.
  int guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses, State& state) {
    return finder_.guard(cloth, step, by_impulses, state);
  }

  /// Adds the impulses [N s] of the last step, times `scale`, to those of their points, N x 3.
  void add_impulses(double scale, Points& sum) const;

  /// As of SelfTouches, in the last step.
  void for_each_touch(const std::function<void(const SelfTouch&)>& visit) const;

  /// To be called when other points than before are held.
  void restart_detection() { finder_.restart_detection(); }

  /// Contacts that a pass looks at.
  std::size_t size() const { return contacts_.contacts().size(); }

  /// Contacts that carry an impulse.
  int count() const { return contacts_.count(); }

  /// Forgets the impulses.
  void reset();

  /// What the next step goes on with. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  TouchFinder finder_;
  ContactList contacts_;
  double h_ = 0;       // of the last step [s]
  double weight_ = 0;  // of the cloth in it [N s]
};

/// Those that `cloth` asks for, none where it may pass through itself.
std::optional<SelfContacts> make_self_contacts(const Cloth& cloth);

}  // namespace clothsim
