#include "clothsim/constraints/crossing_guard.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace clothsim {
namespace {

/// Features never come nearer than this share of the least contact distance: far above rounding,
/// which would let them cross.
constexpr double floor_share = 1e-5;

/// More than the rounding of the motion of two features alike, as a share of the floor.
constexpr double motion_rounding = 1e-6;

/// Measurements in a step: points that must wait for others to move get as many chances.
constexpr int max_legs = 6;

/// Bounds on the motion of two features, from their distance.
struct TruncationBounds {
  double floor;  // [m]

  /// Displacement of their points in any direction, at most [m]: if both move by it, they end at
  /// the floor. Features that start nearer than any can come have no side to be kept on.
  double max_displacement(double distance) const {
    return distance < floor / 2 ? infinity : std::max(distance - floor, 0.0) / 2;
  }

  /// Gap at the ends of paths along the direction of a pair at `here` that ensures a plane between
  /// its features all the way [m]. Infinite where no plane separates them now, as rounding
  /// dominates their direction. Features nearer than the floor come no nearer.
  double gap(const NearPair& near, const Points& here) const {
    const double distance = near.separation.distance;
    const double now = gap_along(near.separation.normal, near.pair, here);
    if (now < floor / 4) return infinity;
    return distance > 0.75 * floor ? std::min(floor, now - motion_rounding * floor) : distance;
  }
};

/// Do the ends of paths from `here` leave that gap, with a plane between the features all the way?
/// For features that turn, as layers between turning fingers, the plane turns along.
bool leave(const NearPair& near, double gap, const Points& here, const Points& ends) {
  if (gap_along(near.separation.normal, near.pair, ends) >= gap) return true;
  return separation(near.pair, ends).distance >= gap &&
         min_gap_turning(near.pair, here, ends) >= gap / 2;
}

/// Moves features in contact that projections alone hold together to where impulses bring them.
void leave_out_projections(const std::vector<NearPair>& near_pairs,
                           const TruncationBounds& truncation, const Points& here,
                           const Points& by_impulses, Points& positions) {
  for (const NearPair& near : near_pairs) {
    if (near.separation.distance >= 2 * truncation.floor) continue;
    const double gap = truncation.gap(near, here);
    if (leave(near, gap, here, positions) || !leave(near, gap, here, by_impulses)) continue;
    for (const int i : near.pair.points) positions.row(i) = by_impulses.row(i);
  }
}

/// Ends of a leg, and the shares of their displacements that points make, at most 1.
struct Leg {
  Points ends;
  Scalars shares;
};

/// Sets of points whose truncation keeps them apart. Each zone has a displacement of its own, as
/// impact zones have (Bridson, Fedkiw & Anderson 2002), in which its truncated points take part:
/// the mean of the points that pins or two colliders hold, else the mean by mass.
class Zones {
 public:
  explicit Zones(int num_points) : next_(static_cast<std::size_t>(num_points)) {
    std::iota(next_.begin(), next_.end(), 0);
  }

  int of(int point) {
    while (next(point) != point) point = next(point) = next(next(point));
    return point;
  }
  void join(int a, int b) { next(of(a)) = of(b); }
  void join_all() { std::fill(next_.begin(), next_.end(), 0); }

  /// For each point, the displacement of its zone.
  Points common_displacements(const Cloth& cloth, const ContactStep& step,
                              const Points& displacements) {
    const auto count = static_cast<int>(displacements.rows());
    const auto holds = [&](int i) {
      const auto number = static_cast<std::size_t>(i);
      const bool is_pinched =
          step.pinched && number < step.pinched->size() && (*step.pinched)[number];
      return cloth.inv_mass[i] == 0 || is_pinched;
    };
    std::vector<bool> is_held(next_.size(), false);
    for (int i = 0; i < count; ++i) {
      if (holds(i)) is_held[static_cast<std::size_t>(of(i))] = true;
    }
    Points sums = Points::Zero(count, 3);
    Scalars weights = Scalars::Zero(count);
    for (int i = 0; i < count; ++i) {
      const bool in_held = is_held[static_cast<std::size_t>(of(i))];
      const double weight = !in_held ? cloth.mass[i] : holds(i) ? 1 : 0;
      sums.row(of(i)) += weight * displacements.row(i);
      weights[of(i)] += weight;
    }
    Points common(count, 3);
    for (int i = 0; i < count; ++i) common.row(i) = sums.row(of(i)) / weights[of(i)];
    return common;
  }

 private:
  int& next(int point) { return next_[static_cast<std::size_t>(point)]; }

  std::vector<int> next_;  // another of the same zone; for its first: itself
};

/// A leg from `here` towards `positions`, on which points move by at most `bounds` [m] relative to
/// the displacements of their zones; without zones, in total.
Leg bounded(const Cloth& cloth, const ContactStep& step, const Points& here,
            const Points& positions, const Scalars& bounds, Zones* zones) {
  const auto count = static_cast<int>(here.rows());
  Leg leg{positions, Scalars::Ones(count)};
  if (bounds.minCoeff() == infinity) return leg;
  const Points displacements = positions - here;
  Points common = Points::Zero(count, 3);
  if (zones) common = zones->common_displacements(cloth, step, displacements);
  for (int i = 0; i < count; ++i) {
    const Eigen::RowVector3d beyond = displacements.row(i) - common.row(i);
    const double length = beyond.norm();
    if (length <= bounds[i]) continue;
    leg.shares[i] = bounds[i] / length;
    leg.ends.row(i) = here.row(i) + common.row(i) + leg.shares[i] * beyond;
  }
  return leg;
}

/// A leg from `here` towards `positions`. Where a plane between two features does not stay on the
/// truncated paths, both get their bound. `unseen`: bound for features that are in no pair [m].
Leg leg_towards(const Cloth& cloth, const ContactStep& step,
                const std::vector<NearPair>& near_pairs, const TruncationBounds& truncation,
                const Points& here, const Points& positions, double unseen, bool has_zones) {
  Zones zones(static_cast<int>(here.rows()));
  if (unseen < infinity) zones.join_all();
  Scalars bounds = Scalars::Constant(here.rows(), unseen);
  std::vector<double> gaps;
  for (const NearPair& near : near_pairs) gaps.push_back(truncation.gap(near, here));
  std::vector<bool> binds(near_pairs.size(), false);
  while (true) {
    Leg leg = bounded(cloth, step, here, positions, bounds, has_zones ? &zones : nullptr);
    step.spend(static_cast<std::int64_t>(near_pairs.size()));
    bool has_bound = false;
    for (std::size_t k = 0; k < near_pairs.size(); ++k) {
      const NearPair& near = near_pairs[k];
      if (binds[k] || leave(near, gaps[k], here, leg.ends)) continue;
      binds[k] = has_bound = true;
      const double max_step = truncation.max_displacement(near.separation.distance);
      for (const int i : near.pair.points) {
        bounds[i] = std::min(bounds[i], max_step);
        zones.join(i, near.pair.points[0]);
      }
    }
    if (!has_bound || step.is_spent()) return leg;
  }
}

/// Where displacements exceed the range of the finder, bounds them all by that range [m]. Returns
/// whether it does.
bool narrow(const NearPairs& finder, const TruncationBounds& truncation, double& unseen) {
  if (finder.max_approach() <= finder.sees() || unseen < infinity) return false;
  unseen = truncation.max_displacement(finder.sees());
  return true;
}

/// Adds pairs that are not yet there. Returns whether there were any.
bool adds(const std::vector<NearPair>& more, std::vector<NearPair>& near_pairs) {
  const auto before = [](const NearPair& a, const NearPair& b) { return a.key < b.key; };
  std::sort(near_pairs.begin(), near_pairs.end(), before);
  std::vector<NearPair> added;
  for (const NearPair& near : more) {
    if (!std::binary_search(near_pairs.begin(), near_pairs.end(), near, before)) {
      added.push_back(near);
    }
  }
  near_pairs.insert(near_pairs.end(), added.begin(), added.end());
  return !added.empty();
}

/// Gives truncated points the velocity of their displacement, with at most the speed that they had:
/// projections have moved them, too, and are no velocity. The same holds for points beside them
/// that projections moved: otherwise impulses would part a knot and projections would close it
/// again.
void slow_down(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
               const Scalars& shares, State& state) {
  for (int i = 0; i < cloth.num_points(); ++i) {
    const bool is_moved = state.positions.row(i) != by_impulses.row(i);
    if (cloth.inv_mass[i] == 0 || !(is_moved || shares[i] < 1)) continue;
    const Eigen::RowVector3d made = (state.positions.row(i) - step.start.row(i)) / step.h;
    const double share = made.norm() > 0 ? state.velocities.row(i).norm() / made.norm() : 0;
    state.velocities.row(i) = std::min(1.0, share) * made;
  }
}

}  // namespace

int keep_from_crossing(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                       NearPairs& finder, State& state) {
  Points& positions = state.positions;
  Points here = step.start;
  const TruncationBounds truncation{floor_share * finder.min_nearest()};
  bool has_zones = true;
  for (int legs = 1;; ++legs) {
    if (!positions.allFinite()) return 0;  // the frame will be taken back
    std::vector<NearPair> near_pairs =
        finder.swept_query(here, positions, truncation.floor, step.workers, step.budget);
    double unseen = infinity;
    narrow(finder, truncation, unseen);
    if (near_pairs.empty() && unseen == infinity) {
      finder.go(positions, step.workers);
      return 0;
    }
    if (legs == 1) leave_out_projections(near_pairs, truncation, here, by_impulses, positions);

    Leg leg;
    do {  // truncated points may obstruct others
      leg = leg_towards(cloth, step, near_pairs, truncation, here, positions, unseen, has_zones);
      if (step.is_spent()) return 0;
    } while (adds(finder.swept_query(here, leg.ends, truncation.floor, step.workers, step.budget),
                  near_pairs) ||
             narrow(finder, truncation, unseen));

    // A pin moves to its target or stays: the cloth does not take it along.
    if (has_zones && (cloth.inv_mass.array() == 0 && leg.shares.array() < 1).any()) {
      has_zones = false;
      continue;
    }
    finder.go(leg.ends, step.workers);
    here = leg.ends;
    const auto truncated = (leg.shares.array() < 1).count();
    if (truncated == 0 || legs >= max_legs) {
      positions = here;
      if (truncated > 0) slow_down(cloth, step, by_impulses, leg.shares, state);
      return static_cast<int>(truncated);
    }
  }
}

}  // namespace clothsim
