#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clothsim/constraints/changed_points.h"
#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Sum of four rows by weights.
inline Vector3 weighted_sum(const std::array<int, 4>& points, const std::array<double, 4>& weights,
                            const Points& rows) {
  const auto along = [&](int axis) {
    const auto share = [&](std::size_t k) { return weights[k] * rows(points[k], axis); };
    return (share(0) + share(1)) + (share(2) + share(3));
  };
  return {along(0), along(1), along(2)};
}

/// A place of a cloth, of up to four points, that a surface touches: a collider's, or its own.
struct Contact {
  std::uint64_t key = 0;            // of what touches what: the same in any step
  std::array<int, 4> points{};      // those of weight 0 are any
  std::array<double, 4> weights{};  // it moves with the sum of w_k v_k
  std::array<double, 4> moves{};    // of the points by an impulse: w_k / m_k [1/kg]
  double mass = 0;                  // that impulses meet: 1 / sum w_k moves_k; 0: no end of it [kg]
  double nearest = 0;               // room that the surfaces need between them [m]
  ContactImpulse impulse = {};      // on the points, by weight [N s]

  /// Sets what it moves, and its mass: all of its points by their inverse masses.
  void compute_effective_mass(const Cloth&);
  /// Moves its point number k no more.
  void hold(std::size_t k);

  /// Adds what an impulse [N s] does to the points.
  void give(const Vector3& impulse, Points& velocities) const;

 private:
  void set_mass();
};

/// Contacts of a step, by their keys, whatever has found them: one law, that of ContactImpulse, for
/// each in turn (projected Gauss-Seidel), one memory of impulses from step to step, and one rule of
/// which a pass leaves out.
class ContactList {
 public:
  /// Begins a step of h [s]: contacts of before are those to go on with.
  void start_over(double h);

  /// Those of the last step that had an impulse, to be asked for by ascending keys from `first` on.
  class Last {
   public:
    Last(const ContactList&, std::uint64_t first);
    /// None: null.
    const Contact* of(std::uint64_t key);

   private:
    std::vector<Contact>::const_iterator next_;
    std::vector<Contact>::const_iterator end_;
  };

  /// Calls visit(contact) for those of the last step, by ascending keys.
  template <typename Visit>
  void for_each_last(Visit&& visit) const {
    for (const Contact& c : last_) visit(c);
  }

  /// Contacts by ascending keys, each with its impulse of the last step, as it was then.
  void add(const Contact& contact) { contacts_.push_back(contact); }
  void add(const std::vector<Contact>&);

  /// To be called when a step has all of its contacts: gives points the impulses of the last step,
  /// over this one's length. `positions`: by which to tell threads apart.
  void warm_start(const Points& positions, Points& velocities);

  /// In another step of the same length, gives points the impulses of the last one once more.
  void warm_start_again(Points& velocities) { warm_start(1, velocities); }

  /// One pass over the contacts, but for those where no point has changed by more than a share of
  /// `precision` [m/s] since they were looked at; where it is below 0, over all. Returns the
  /// largest change of a contact's velocity [m/s].
  double solve_pass(double precision, Points& velocities, const Workers& = {});

  /// Contacts with what colliders hold act no more; those that it is a part of, with no more than
  /// `strongest` [N s]. Takes back from the velocities [m/s] what warm_start() gave beyond that.
  void release_pinched(const Pinches&, double strongest, Points& velocities);

  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }

  /// Contacts that carry an impulse.
  int count() const;

  /// Forgets the impulses.
  void reset();

  /// The impulses. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  /// A contact, by number, and its points: most passes look at no more of it.
  struct Place {
    std::array<int, 4> points;
    int contact;
  };

  /// Planes x[axis] = at, ascending, that cut the contacts into slabs.
  struct Cut {
    int axis = 0;
    std::vector<double> at;
  };

  Cut cut_into_slabs(const Points& positions) const;
  void group(const Points& positions);
  void warm_start(double scale, Points& velocities);
  double solve_group(const std::vector<Place>&, double min_change, Points& velocities);

  double h_ = 0;
  double scale_ = 0;  // of the last step's impulses, over the same forces' in this one
  std::vector<Contact> contacts_;
  std::vector<Contact> last_;
  /// Contacts within each of n slabs, then those across one plane, of every other plane first, then
  /// those across more. The groups up to each of `stages_` have no point in common.
  std::vector<std::vector<Place>> groups_;
  std::array<int, 4> stages_{};
  std::vector<double> changes_;  // of each group in a pass
  ChangedPoints changed_;
};

}  // namespace clothsim
