#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/constraints/contact_impulse.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// Points of a cloth that two colliders leave no room.
///
/// What surfaces that close on a cloth ask of it cannot both be met, and impulses that try grow
/// without end. So such a point goes across them with both, or midway between what they ask for if
/// that differs much. Solids press as hard as it takes: where friction can keep it from slipping
/// out, it does, and the point goes along with both, more with the rougher one. Else it slips, and
/// so it does where it is pulled out with more than its share of some weights of the whole cloth,
/// before what pulls it is torn.
class Pinches {
 public:
  /// A contact, and the collider that it is with.
  struct Side {
    const ContactImpulse& contact;
    const MovingCollider& collider;
  };

  /// Forgets all points, for a step of h [s]. The weight of the cloth is that under `gravity`
  /// [m/s^2].
  void start_over(double h, double gravity = least_gravity);

  /// Can no velocity of what is between them meet both?
  static bool leave_no_room(const ContactImpulse& a, const ContactImpulse& b);

  /// Takes a point at `x` [m], unless it is taken, that two contacts leave no room.
  void add(int point, const Vector3& x, const Side& a, const Side& b, const Cloth&);

  /// Gives the points their velocities. Returns the largest change [m/s].
  double sweep(Points& velocities);

  /// Puts the points back where those velocities bring them from `start`, as far as they do not
  /// slip.
  void correct(const Points& start, Points& positions) const;

  /// As of FaceContacts. Of two colliders the one that pushed has what a point got across them; of
  /// what it got along them each has its share of the friction. What both press against each other
  /// through the point is in no sum: nothing says how much that is.
  void add_impulses(const std::vector<MovingCollider>&, const Cloth&, double scale,
                    const Points& positions, std::vector<Wrench>& sums) const;

  bool holds(int point) const {
    return !held_.empty() && held_[static_cast<std::size_t>(point)] != 0;
  }
  bool holds_any(const std::array<int, 3>& points) const {
    return std::any_of(points.begin(), points.end(), [&](int point) { return holds(point); });
  }
  /// By point; empty: none.
  const std::vector<char>& held() const { return held_; }

  /// Which points are held. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, const Cloth&);

  int count() const { return static_cast<int>(pinches_.size()); }
  /// The first of them; -1: none.
  int first() const { return pinches_.empty() ? -1 : pinches_.front().point; }

 private:
  struct Pinch {
    int point;
    Vector3 velocity;  // wanted [m/s]
    Vector3 across;    // from one collider to the other
    double grip;       // greatest change of velocity along them in the step, were it alone [m/s]
    std::size_t jaws;  // that hold it
    Vector3 given;     // change of velocity in the step so far [m/s]
    bool slips;
  };

  /// Two colliders that hold points.
  struct Jaws {
    const MovingCollider* a;
    const MovingCollider* b;
    int points;  // that stick
  };

  std::size_t jaws_of(const MovingCollider&, const MovingCollider&);

  double h_ = 0;
  double gravity_ = least_gravity;  // [m/s^2]
  std::vector<Pinch> pinches_;
  std::vector<Jaws> jaws_;
  std::vector<char> held_;
};

/// Calls visit(i, j) for every two of `count` things, i < j, with the same key(i), below `keys`.
template <typename Key, typename Visit>
void for_each_two(std::size_t count, std::size_t keys, const Key& key, const Visit& visit) {
  std::vector<std::size_t> last(keys, count), before(count, count);
  for (std::size_t j = 0; j < count; ++j) {
    std::size_t& newest = last[static_cast<std::size_t>(key(j))];
    for (std::size_t i = newest; i < count; i = before[i]) visit(i, j);
    before[j] = newest;
    newest = j;
  }
}

}  // namespace clothsim
