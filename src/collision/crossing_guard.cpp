#include "clothsim/collision/crossing_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Way of a point between two measurements, of its distance to the nearest feature: below a half,
/// or two could meet.
constexpr double bound_share = 0.45;

/// Features never come nearer than this, of the nearest that impulses let any: far above rounding,
/// which would let them cross.
constexpr double floor_share = 1e-5;

/// More than the motion of two features alike rounds, of the floor.
constexpr double rounding = 1e-6;

/// Measurements in a step: points that must wait for others to move get as many chances.
constexpr int most_legs = 6;

/// What two features at a distance from each other grant.
struct Room {
  double floor;  // [m]

  /// Way of their points, wherever to [m]. What starts nearer than anything may ever come has no
  /// side to be kept on.
  double way(double distance) const {
    return distance < floor / 2 ? infinity : bound_share * std::max(distance - floor, 0.0);
  }

  /// Gap that must be left at the ends of ways along the direction of a pair at `here`, for a plane
  /// to be between its features all the way [m]. Where none is between them now, as their direction
  /// is lost in rounding, no gap will do. What is nearer than the floor comes no nearer.
  double gap(const NearPair& near, const Points& here) const {
    const double distance = near.separation.distance;
    const double now = gap_along(near.separation.normal, near.pair, here);
    if (now < floor / 4) return infinity;
    return distance > 0.75 * floor ? std::min(floor, now - rounding * floor) : distance;
  }
};

/// Do the ends of ways leave that gap?
bool leave(const NearPair& near, double gap, const Points& ends) {
  return gap_along(near.separation.normal, near.pair, ends) >= gap;
}

/// Brings what touches, and is held together by repairs alone, to where impulses bring it.
void leave_out_repairs(const std::vector<NearPair>& near_pairs, const Room& room,
                       const Points& here, const Points& by_impulses, Points& positions) {
  for (const NearPair& near : near_pairs) {
    if (near.separation.distance >= 2 * room.floor) continue;
    const double gap = room.gap(near, here);
    if (leave(near, gap, positions) || !leave(near, gap, by_impulses)) continue;
    for (const int i : near.pair.points) positions.row(i) = by_impulses.row(i);
  }
}

/// The ways, none of them longer than its bound.
Points shorten(const Points& ways, const Scalars& bounds) {
  Points result = ways;
  for (int i = 0; i < ways.rows(); ++i) {
    const double way = ways.row(i).norm();
    if (way > bounds[i]) result.row(i) *= bounds[i] / way;
  }
  return result;
}

/// Bounds of the ways from `here`: where a plane between two features does not stay, on the ways
/// that the bounds leave, these bind their points. What is not among the pairs grants `unseen`.
Scalars bounds_of(const std::vector<NearPair>& near_pairs, const Room& room, const Points& here,
                  const Points& ways, double unseen) {
  Scalars bounds = Scalars::Constant(here.rows(), unseen);
  std::vector<double> gaps;
  for (const NearPair& near : near_pairs) gaps.push_back(room.gap(near, here));
  std::vector<bool> binds(near_pairs.size(), false);
  for (bool shortened = true; shortened;) {
    shortened = false;
    const Points ends = here + shorten(ways, bounds);
    for (std::size_t k = 0; k < near_pairs.size(); ++k) {
      const NearPair& near = near_pairs[k];
      if (binds[k] || leave(near, gaps[k], ends)) continue;
      binds[k] = true;
      const double most = room.way(near.separation.distance);
      for (const int i : near.pair.points) {
        bounds[i] = std::min(bounds[i], most);
        shortened = shortened || ways.row(i).norm() > bounds[i];
      }
    }
  }
  return bounds;
}

/// Is a point that is held to go farther than it may?
bool binds_a_pin(const Cloth& cloth, const Points& ways, const Scalars& bounds) {
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0 && ways.row(i).norm() > bounds[i]) return true;
  }
  return false;
}

/// Gives what is held back the velocity of the way that it made, and no more than it had: repairs
/// and push-outs have moved it, too, and what they did is no velocity. So it is with the points
/// that they moved beside it: from what is knotted, impulses would part them and repairs bring them
/// back.
void slow_down(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
               const std::vector<int>& held_back, State& state) {
  std::vector<bool> slows(static_cast<std::size_t>(cloth.num_points()), false);
  for (const int i : held_back) slows[static_cast<std::size_t>(i)] = true;
  for (int i = 0; i < cloth.num_points(); ++i) {
    const bool is_moved = state.positions.row(i) != by_impulses.row(i);
    if (cloth.inv_mass[i] == 0 || !(is_moved || slows[static_cast<std::size_t>(i)])) continue;
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
  const Room room{floor_share * finder.least_nearest()};
  bool together = true;  // points held back go along with the cloth
  for (int leg = 1;; ++leg) {
    // Ways beyond the common one, which brings nobody closer. Pairs that bind are nearer than the
    // longest way needs; further ones than can be seen are taken to be no further.
    const Eigen::RowVector3d common = together
                                          ? Eigen::RowVector3d((positions - here).colwise().mean())
                                          : Eigen::RowVector3d::Zero();
    const auto longest_to = [&](const Points& ends) {
      return longest_row((ends - here).rowwise() - common);
    };
    const double longest =
        leg == 1 ? std::max(longest_to(positions), longest_to(by_impulses)) : longest_to(positions);
    const double needed = room.floor + longest / bound_share;
    if (!std::isfinite(needed)) return 0;  // no longer numbers: the frame will be taken back
    const double seen = std::min(needed, finder.reach());
    const std::vector<NearPair>& near_pairs = finder.within(cloth, here, seen, step.workers);
    if (near_pairs.empty() && seen == needed) return 0;

    if (leg == 1) leave_out_repairs(near_pairs, room, here, by_impulses, positions);
    const Points ways = (positions - here).rowwise() - common;
    const Scalars bounds =
        bounds_of(near_pairs, room, here, ways, seen == needed ? infinity : room.way(seen));
    // A pin goes where it is told or stays: the cloth does not take it along.
    if (together && binds_a_pin(cloth, ways, bounds)) {
      together = false;
      continue;
    }
    std::vector<int> held_back;
    for (int i = 0; i < here.rows(); ++i) {
      const double way = ways.row(i).norm();
      if (way > bounds[i]) {
        here.row(i) += common + bounds[i] / way * ways.row(i);
        held_back.push_back(i);
      } else {
        here.row(i) = positions.row(i);
      }
    }
    if (held_back.empty() || leg >= most_legs) {
      positions = here;
      if (!held_back.empty()) slow_down(cloth, step, by_impulses, held_back, state);
      return static_cast<int>(held_back.size());
    }
  }
}

}  // namespace clothsim
