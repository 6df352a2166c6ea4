#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// The points whose velocity has changed since the last look: passes over contacts skip contacts
/// without such a point.
class ChangedPoints {
 public:
  /// All `count` points count as changed at the next look.
  void mark_all(int count);
  /// These points count as changed at the next look.
  void mark(const std::array<int, 4>& points) {
    for (const int point : points) marked_[static_cast<std::size_t>(point)] = 1;
  }

  /// Number of parts of `count` points.
  static int parts(int count) { return (count + part_size - 1) / part_size; }

  /// Finds the points of a part that are marked, or whose `velocities` [m/s, N x 3] along an axis
  /// differ by more than `min_change` [m/s] from those at which they were last found.
  void look(int part, const Points& velocities, double min_change);

  bool any(const std::array<int, 4>& points) const {
    Flag result = 0;
    for (const int point : points) result |= changed_[static_cast<std::size_t>(point)];
    return result != 0;
  }

 private:
  static constexpr int part_size = 1024;  // points; a look at them outlasts the start of a thread
  using Flag = std::int64_t;              // as wide as a coordinate, for vector units

  Points seen_;                // [m/s]
  std::vector<Flag> marked_;   // by point
  std::vector<Flag> changed_;  // by point
};

}  // namespace clothsim
