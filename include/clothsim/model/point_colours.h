#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace clothsim {

/// Colours for things that join points, so that no two of a colour share a point: greedily, each
/// the first colour that none of its points has yet.
class PointColours {
 public:
  explicit PointColours(int points) : taken_(static_cast<std::size_t>(points)) {}

  /// The colour of the next thing, on these points.
  template <typename Ids>
  std::size_t next(const Ids& points) {
    std::size_t colour = 0;
    const auto is_taken = [&](int i) {
      const std::vector<bool>& taken = taken_[static_cast<std::size_t>(i)];
      return colour < taken.size() && taken[colour];
    };
    while (std::any_of(points.begin(), points.end(), is_taken)) ++colour;
    for (const int i : points) {
      std::vector<bool>& taken = taken_[static_cast<std::size_t>(i)];
      if (taken.size() <= colour) taken.resize(colour + 1, false);
      taken[colour] = true;
    }
    return colour;
  }

 private:
  std::vector<std::vector<bool>> taken_;  // by point, for each colour
};

}  // namespace clothsim
