#pragma once

#include <cstddef>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/point_colours.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Sorts constraints by colour.
template <typename Constraint>
class Colouring {
 public:
  explicit Colouring(const Cloth& cloth) : of_points_(cloth.num_points()) {}

  template <typename Ids>
  void add(const Constraint& constraint, const Ids& points) {
    const std::size_t colour = of_points_.next(points);
    if (colour == colours_.size()) colours_.emplace_back();
    colours_[colour].push_back(constraint);
  }

  void move_to(std::vector<Constraint>& constraints, std::vector<int>& ends) const {
    constraints.clear();
    ends.clear();
    for (const std::vector<Constraint>& colour : colours_) {
      constraints.insert(constraints.end(), colour.begin(), colour.end());
      ends.push_back(static_cast<int>(constraints.size()));
    }
  }

 private:
  PointColours of_points_;
  std::vector<std::vector<Constraint>> colours_;
};

/// Calls visit(c) for each constraint, colour after colour; `back`: from the last one on.
template <typename Visitor>
void parallel_for_colours(const std::vector<int>& ends, bool back, const Workers& workers,
                          Visitor&& visit) {
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const std::size_t colour = back ? ends.size() - 1 - k : k;
    const int first = colour > 0 ? ends[colour - 1] : 0;
    workers.parallel_for(ends[colour] - first, [&](int from, int to) {
      for (int c = first + from; c < first + to; ++c) visit(static_cast<std::size_t>(c));
    });
  }
}

}  // namespace clothsim
