#pragma once

#include <algorithm>
#include <vector>

#include "clothsim/model/lanes.h"
#include "clothsim/model/types.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// Points, or springs, that are worth a thread: half a microsecond of work. Their data stays in the
/// nearest cache.
inline constexpr int near_at_once = 512;

/// Consecutive blocks, at most `longest`: the range of one loop over their points.
struct Span {
  static constexpr int longest = near_at_once / num_lanes;

  int begin;
  int end;
};

/// Bound on the displacement of all points of a cloth.
class MotionBound {
 public:
  /// A step has moved the points from `start` to `now`.
  void begin(const Points& start, const Points& now);

  /// Constraints in the step have moved them to `now`.
  void update(const Points& start, const Points& now);

  /// They have moved on by `distance` [m] at most.
  void add(double distance) { total_ += distance; }

  /// The step ends with the points at `now`.
  void end(const Points& now) { seen_ = now; }

  /// Sum of the largest displacements of a point in all steps and between them [m].
  double total() const { return total_; }

  /// Largest displacement of a point within the step [m].
  double in_step() const { return in_step_; }

  /// Largest displacement of a point between the last step's end and this one's start [m]; infinity
  /// for the first.
  double between_steps() const { return between_steps_; }
  /// The same for a step that would start with the points at `start`.
  double since_step(const Points& start) const;

 private:
  Points seen_;  // at the last step's end; none: not known
  double total_ = 0;
  double at_start_ = 0;  // total at the step's start
  double in_step_ = 0;
  double between_steps_ = 0;
};

/// Which blocks of points are too far from a collider to touch it. The distance from a surface
/// changes no faster than point and surface move, whatever the shape: a block sleeps until the
/// displacements of both may have used up the least distance of its points.
class SleepBounds {
 public:
  /// Resets the bounds, for so many blocks.
  void reset(int blocks);

  bool is_of(int blocks) const { return used_up_at_.size() == static_cast<std::size_t>(blocks); }

  /// The collider is at `pose` now, and no point is farther from its origin than `radius` [m],
  /// which matters only if it turned. Returns a bound on the displacement of its surface since the
  /// last call [m].
  double follow(const Pose& pose, double radius);

  /// Pose at the last call of follow().
  const Pose& pose() const { return pose_; }

  /// Total displacement of the surface, at most [m].
  double moved() const { return moved_; }

  /// No point of a block is nearer to the surface than `distance` [m], after a total displacement
  /// of `travelled`.
  void keep(int block, double distance, double travelled) {
    const double at = travelled + moved_ + distance;
    used_up_at_[static_cast<std::size_t>(block)] = at;
    min_used_up_at_ = std::min(min_used_up_at_, at);
  }
  void wake(int block) {
    used_up_at_[static_cast<std::size_t>(block)] = min_used_up_at_ = -infinity;
  }

  /// Can a point be within `distance` [m] of the surface?
  bool is_near(double travelled, double distance) const {
    return !(min_used_up_at_ > travelled + moved_ + distance);
  }

  /// Finds the blocks with points that can be within `distance` [m] of the surface, ascending.
  void find_near(double travelled, double distance, std::vector<Span>& spans);

 private:
  std::vector<double> used_up_at_;     // by block: travelled + moved_
  double min_used_up_at_ = -infinity;  // their minimum, or less
  double moved_ = 0;                   // total displacement of the surface [m]
  bool is_seen_ = false;
  Pose pose_;
};

}  // namespace clothsim
