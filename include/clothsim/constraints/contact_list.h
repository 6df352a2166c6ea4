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

/// Weighted sum of four rows.
inline Vector3 weighted_sum(const std::array<int, 4>& points, const std::array<double, 4>& weights,
                            const Points& rows) {
  const auto along = [&](int axis) {
    const auto share = [&](std::size_t k) { return weights[k] * rows(points[k], axis); };
    return (share(0) + share(1)) + (share(2) + share(3));
  };
  return {along(0), along(1), along(2)};
}

/// A contact of a cloth, at up to four points, with a collider or with itself.
struct Contact {
  std::uint64_t key = 0;            // identifies the pair of features, the same in any step
  std::array<int, 4> points{};      // those of weight 0 are arbitrary
  std::array<double, 4> weights{};  // b_k: its velocity is the sum of b_k v_k
  std::array<double, 4> moves{};    // velocity changes per impulse: b_k / m_k [1/kg]
  double mass = 0;                  // effective mass [kg]: 1 / sum b_k moves_k; 0: infinite
  double nearest = 0;               // distance that the surfaces keep [m]
  ContactImpulse impulse = {};      // on the points, by weight [N s]

  /// Sets `moves` and `mass` from the inverse masses of the points.
  void compute_effective_mass(const Cloth&);
  /// Makes point number k immovable.
  void hold(std::size_t k);

  /// Adds the velocity changes of the points by an impulse [N s].
  void give(const Vector3& impulse, Points& velocities) const;

 private:
  void set_mass();
};

/// The contacts of a step in the order of their keys, of whichever finder. Each is solved in turn
/// by ContactImpulse (projected Gauss-Seidel), impulses are kept from step to step, and passes skip
/// contacts whose points have not changed.
class ContactList {
 public:
  /// Begins a step of h [s]: the present contacts become those of the last step.
  void start_over(double h);

  /// Contacts of the last step that had an impulse. Keys must be asked for in ascending order, from
  /// `first` on.
  class Last {
   public:
    Last(const ContactList&, std::uint64_t first);
    /// The contact with this key; null: none.
    const Contact* of(std::uint64_t key);

   private:
    std::vector<Contact>::const_iterator next_;
    std::vector<Contact>::const_iterator end_;
  };

  /// Adds contacts, by ascending keys, each with its impulse of the last step.
  void add(const Contact& contact) { contacts_.push_back(contact); }
  void add(const std::vector<Contact>&);

  /// To be called when a step has all of its contacts: gives points the impulses of the last step,
  /// scaled by the lengths of the steps. Contacts are divided over threads by `positions`.
  void warm_start(const Points& positions, Points& velocities, const Workers& = {});

  /// In another step of the same length, gives points the impulses of the last one once more.
  void warm_start_again(Points& velocities) { warm_start(1, velocities); }

  /// Adds the changes of velocities by the impulses [m/s].
  void add_velocities(Points& sum) const;

  /// One pass over the contacts, except for those whose points have changed by less than a share of
  /// `tolerance` [m/s] since their last update; over all where it is below 0. Returns the largest
  /// change of a contact's velocity [m/s].
  double solve_pass(double tolerance, Points& velocities, const Workers& = {});

  /// Ends the contacts whose points are all pinched, and bounds the impulse of those with some
  /// pinched points by `strongest` [N s]. Takes the excess of warm_start() back from the velocities
  /// [m/s].
  void release_pinched(const Pinches&, double strongest, Points& velocities);

  std::vector<Contact>& contacts() { return contacts_; }
  const std::vector<Contact>& contacts() const { return contacts_; }

  /// Contacts that carry an impulse.
  int count() const;

  /// Forgets the impulses.
  void reset();

  /// The impulses. `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  /// A contact, by number, and its points: most passes read no more of it.
  struct Place {
    std::array<int, 4> points;
    int contact;
  };

  /// Planes x[axis] = at, ascending, that cut the contacts into slabs.
  struct Cut {
    int axis = 0;
    std::vector<double> at;
  };

  struct Extent {
    Eigen::AlignedBox3d box;
    Vector3 lengths{0, 0, 0};
  };

  Extent extent(const Points& positions, const Workers&) const;
  Cut cut_into_slabs(const Points& positions, const Workers&) const;
  void group(const Points& positions, const Workers&);
  void warm_start(double scale, Points& velocities);
  double solve_group(const std::vector<Place>&, double min_change, Points& velocities);

  double h_ = 0;
  double scale_ = 0;  // factor on the impulses of the last step: ratio of the steps' lengths
  std::vector<Contact> contacts_;
  std::vector<Contact> last_;
  /// Contacts within each of n slabs, then those across one plane, even planes first, then those
  /// across more. Groups of one stage have no point in common.
  std::vector<std::vector<Place>> groups_;
  std::vector<int> group_of_;    // by contact
  std::vector<int> stages_;      // of a pass: ends of the parts of changed_, then of groups_
  std::vector<double> changes_;  // by group, in a pass
  ChangedPoints changed_;
};

}  // namespace clothsim
