#include "clothsim/constraints/touch_finder.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/crossing_guard.h"
#include "clothsim/constraints/pinches.h"

namespace clothsim {
namespace {

/// Way that points may go from one look to the next, of the nearest that any features may come:
/// what comes together meanwhile was seen ahead by its velocities then. With twice as much towels
/// take as long, with 0.1 an eighth longer.
constexpr double unseen_way = 0.25;

}  // namespace

/// What a step has that its contacts are made of.
struct TouchFinder::Sought {
  const Cloth& cloth;
  double h;                  // of the step [s]
  double ahead;              // until contacts are sought anew [s]
  const Points& middle;      // where impulses act [m]
  const Points& velocities;  // [m/s]
  double strongest;          // push of what stops nothing [N s]
};

TouchFinder::Sought TouchFinder::sought_in(const Cloth& cloth, const ContactStep& step,
                                           const State& state) const {
  return {cloth,   step.h,           step.ahead,
          middle_, state.velocities, cloth.mass.sum() * step.gravity * step.h};
}

/// Of a pair that may touch within the step, or had an impulse in the last one.
std::optional<Contact> TouchFinder::contact_of(const Sought& sought, const NearPair& near,
                                               const Contact* last) {
  const SurfacePair& pair = near.pair;
  if (near.separation.distance == 0) return {};

  // Most do not get there.
  const Vector3& last_normal = near.separation.normal;
  const double way = sought.ahead * -gap_along(last_normal, pair, sought.velocities);
  const double room = gap_along(last_normal, pair, sought.middle) - pair.nearest;
  if (!last && room > 0 && way < room) return {};

  // As they lie where impulses act; if they have passed through each other by then, as they lay.
  Separation s = separation(pair, sought.middle);
  if (s.normal.dot(near.separation.normal) <= 0) {
    s = near.separation;
    s.distance = s.normal.dot(weighted_sum(pair.points, s.weights, sought.middle));
  }

  // The gap may close until contacts are sought anew. Others may yet push a touching pair together.
  const double gap = s.distance - pair.nearest;
  const double slowest = gap > 0 ? -gap / sought.ahead : -overlap_share * gap / sought.h;
  const double rate = s.normal.dot(weighted_sum(pair.points, s.weights, sought.velocities));
  if (!last && rate >= slowest && gap > 0) return {};

  Contact contact{near.key, pair.points, s.weights};
  contact.weigh(sought.cloth);
  if (contact.mass == 0) return {};
  const double to_stop = std::abs(rate) * contact.mass;
  contact.nearest = pair.nearest;
  contact.impulse = {s.normal,
                     Vector3::Zero(),
                     slowest,
                     sought.cloth.friction,
                     sought.strongest + 2 * to_stop,
                     Pinches::beside * sought.strongest};
  if (last) contact.impulse.keep(last->impulse);
  return contact;
}

/// Looks as far ahead as points may go until it looks again.
void TouchFinder::look(const ContactStep& step) {
  // By velocities that have met contact: by those that forces gave since, all of a pile at rest
  // would be about to touch.
  const Points& velocities = step.velocities ? *step.velocities : step.drifted;
  const double most = unseen_way * near_.least_nearest() / longest_beyond_mean(velocities);
  double time = std::max(step.ahead, std::min(step.left, most));
  // An impulse moves points from the middle of its step on: they would overlap by half of their
  // way.
  if (kind_ == SelfCollision::points) time += step.reach * step.h;
  looked_at_ = step.sought_at ? *step.sought_at : step.start;
  near_.approaching(looked_at_, step.start + time * velocities, step.workers, step.budget);
  time_ = step.since - step.h;
  way_ = 0;
}

void TouchFinder::find(const Cloth& cloth, const ContactStep& step, const State& state,
                       ContactList& list) {
  if (looked_at_.rows() == 0) look(step);
  time_ += step.h;
  middle_ = state.positions - step.reach * step.h * step.drifted;
  const Sought sought = sought_in(cloth, step, state);
  const std::vector<NearPair>& near_pairs = near_.approaching();
  const auto found = step.workers.gather<std::vector<Contact>>(
      static_cast<int>(near_pairs.size()), [&](int begin, int end, std::vector<Contact>& contacts) {
        if (begin == end) return;
        contacts.reserve(static_cast<std::size_t>(end - begin));
        ContactList::Last last(list, near_pairs[static_cast<std::size_t>(begin)].key);
        for (int k = begin; k < end; ++k) {
          const NearPair& near = near_pairs[static_cast<std::size_t>(k)];
          const std::optional<Contact> contact = contact_of(sought, near, last.of(near.key));
          if (contact) contacts.push_back(*contact);
        }
      });
  for (const std::vector<Contact>& contacts : found) list.add(contacts);
}

void TouchFinder::go_on(const Cloth& cloth, const ContactStep& step, const State& state,
                        ContactList& list) {
  const Sought sought = sought_in(cloth, step, state);
  auto near = near_.approaching().begin();  // has all keys of the list, which ascend in both
  for (Contact& contact : list.contacts()) {
    while (near->key != contact.key) ++near;
    if (contact.impulse.push == 0) continue;
    for (const int i : contact.points) {
      middle_.row(i) = state.positions.row(i) - step.reach * step.h * step.drifted.row(i);
    }
    const std::optional<Contact> now = contact_of(sought, *near, &contact);
    if (now) {
      contact = *now;
    } else {
      contact.impulse.let_go();
    }
  }
}

int TouchFinder::guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                       State& state) {
  if (looked_at_.rows() == 0) {  // it has judged the way until now
    looked_at_ = step.start;
    time_ = step.since;
    way_ = 0;
  }
  const double last = way_;
  way_ = longest_beyond_mean(looked_at_, state.positions);
  const double next = way_ + (way_ - last);
  if (step.left > step.h && next <= unseen_way * near_.least_nearest()) return 0;

  int held_back = 0;
  if (kind_ == SelfCollision::surface) held_back = judge(cloth, step, by_impulses, state);
  looked_at_.resize(0, 3);
  return held_back;
}

/// Of the way since it looked.
int TouchFinder::judge(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                       State& state) {
  ContactStep whole{time_, step.reach, looked_at_, step.drifted, step.workers};
  whole.budget = step.budget;
  whole.held = step.held;
  return keep_from_crossing(cloth, whole, by_impulses, near_, state);
}

}  // namespace clothsim
