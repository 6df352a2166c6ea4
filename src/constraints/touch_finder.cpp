#include "clothsim/constraints/touch_finder.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/crossing_guard.h"
#include "clothsim/constraints/pinches.h"

namespace clothsim {
namespace {

/// Displacement of points between two detections, of the least contact distance: contacts in
/// between were found ahead from the velocities at the first. With twice as much towels take as
/// long, with 0.1 an eighth longer.
constexpr double undetected_share = 0.25;

}  // namespace

/// Data of a step for its contacts.
struct TouchFinder::Query {
  const Cloth& cloth;
  double h;                  // of the step [s]
  double ahead;              // time until the next detection [s]
  const Points& middle;      // where impulses act [m]
  const Points& velocities;  // [m/s]
  double strongest;          // largest impulse for a pair at rest [N s]
};

TouchFinder::Query TouchFinder::query_in(const Cloth& cloth, const ContactStep& step,
                                         const State& state) const {
  return {cloth,   step.h,           step.ahead,
          middle_, state.velocities, cloth.mass.sum() * step.gravity * step.h};
}

/// Contact of a pair that may touch within the step, or had an impulse in the last one.
std::optional<Contact> TouchFinder::contact_of(const Query& query, const NearPair& near,
                                               const Contact* last) {
  const SurfacePair& pair = near.pair;
  if (near.separation.distance == 0) return {};

  // A cheap check that excludes most pairs.
  const Vector3& last_normal = near.separation.normal;
  const double approach = query.ahead * -gap_along(last_normal, pair, query.velocities);
  const double last_gap = gap_along(last_normal, pair, query.middle) - pair.nearest;
  if (!last && last_gap > 0 && approach < last_gap) return {};

  // The pair where impulses act; if its features have crossed by then, with the direction before.
  Separation s = separation(pair, query.middle);
  if (s.normal.dot(near.separation.normal) <= 0) {
    s = near.separation;
    s.distance = s.normal.dot(weighted_sum(pair.points, s.weights, query.middle));
  }

  // The gap may close until the next detection. Other constraints may still push a touching pair
  // together.
  const double gap = s.distance - pair.nearest;
  const double target_velocity = gap > 0 ? -gap / query.ahead : -overlap_share * gap / query.h;
  const double rate = s.normal.dot(weighted_sum(pair.points, s.weights, query.velocities));
  if (!last && rate >= target_velocity && gap > 0) return {};

  Contact contact{near.key, pair.points, s.weights};
  contact.compute_effective_mass(query.cloth);
  if (contact.mass == 0) return {};
  const double to_stop = std::abs(rate) * contact.mass;
  contact.nearest = pair.nearest;
  contact.impulse = {s.normal,
                     Vector3::Zero(),
                     target_velocity,
                     query.cloth.friction_between(pair.points.front(), pair.points.back()),
                     query.strongest + 2 * to_stop,
                     Pinches::max_overlap_impulse * query.strongest};
  if (last) contact.impulse.keep(last->impulse);
  return contact;
}

/// Detects pairs as far ahead as points may move until the next detection.
void TouchFinder::look(const ContactStep& step) {
  // With velocities after contact: with those after forces, all of a pile at rest would be about to
  // touch.
  const Points& velocities = step.velocities ? *step.velocities : step.drifted;
  const double max_time = undetected_share * near_.min_nearest() / longest_beyond_mean(velocities);
  double time = std::max(step.ahead, std::min(step.left, max_time));
  // An impulse moves points from the middle of its step on: without this they would overlap by half
  // of their displacement.
  if (kind_ == SelfCollision::points) time += step.displacement_factor * step.h;
  looked_at_ = step.detected_at ? *step.detected_at : step.start;
  near_.approaching(looked_at_, step.start + time * velocities, step.workers, step.budget);
  time_ = step.since - step.h;
  max_displacement_ = 0;
}

void TouchFinder::find(const Cloth& cloth, const ContactStep& step, const State& state,
                       ContactList& list) {
  if (looked_at_.rows() == 0) look(step);
  time_ += step.h;
  middle_.resize(state.positions.rows(), 3);
  step.workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    const int count = end - begin;
    middle_.middleRows(begin, count) =
        state.positions.middleRows(begin, count) -
        step.displacement_factor * step.h * step.drifted.middleRows(begin, count);
  });
  const Query query = query_in(cloth, step, state);
  const std::vector<NearPair>& near_pairs = near_.approaching();
  const auto found = step.workers.gather<std::vector<Contact>>(
      static_cast<int>(near_pairs.size()), [&](int begin, int end, std::vector<Contact>& contacts) {
        if (begin == end) return;
        contacts.reserve(static_cast<std::size_t>(end - begin));
        ContactList::Last last(list, near_pairs[static_cast<std::size_t>(begin)].key);
        for (int k = begin; k < end; ++k) {
          const NearPair& near = near_pairs[static_cast<std::size_t>(k)];
          const std::optional<Contact> contact = contact_of(query, near, last.of(near.key));
          if (contact) contacts.push_back(*contact);
        }
      });
  for (const std::vector<Contact>& contacts : found) list.add(contacts);
}

void TouchFinder::refresh(const Cloth& cloth, const ContactStep& step, const State& state,
                          ContactList& list) {
  const Query query = query_in(cloth, step, state);
  auto near = near_.approaching().begin();  // has all keys of the list, which ascend in both
  for (Contact& contact : list.contacts()) {
    while (near->key != contact.key) ++near;
    if (contact.impulse.normal_impulse == 0) continue;
    for (const int i : contact.points) {
      middle_.row(i) =
          state.positions.row(i) - step.displacement_factor * step.h * step.drifted.row(i);
    }
    const std::optional<Contact> now = contact_of(query, *near, &contact);
    if (now) {
      contact = *now;
    } else {
      contact.impulse.deactivate();
    }
  }
}

int TouchFinder::guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                       State& state) {
  if (looked_at_.rows() == 0) {  // the path until now has been checked
    looked_at_ = step.start;
    time_ = step.since;
    max_displacement_ = 0;
  }
  const double last = max_displacement_;
  max_displacement_ = longest_beyond_mean(looked_at_, state.positions);
  const double next = max_displacement_ + (max_displacement_ - last);
  if (step.left > step.h && next <= undetected_share * near_.min_nearest()) return 0;

  int truncated = 0;
  if (kind_ == SelfCollision::surface) truncated = guard_path(cloth, step, by_impulses, state);
  looked_at_.resize(0, 3);
  return truncated;
}

/// Applies the guard to the path since the last detection.
int TouchFinder::guard_path(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                            State& state) {
  ContactStep whole{time_, step.displacement_factor, looked_at_, step.drifted, step.workers};
  whole.budget = step.budget;
  whole.pinched = step.pinched;
  return keep_from_crossing(cloth, whole, by_impulses, near_, state);
}

}  // namespace clothsim
