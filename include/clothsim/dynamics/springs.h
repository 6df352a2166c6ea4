#pragma once

#include <algorithm>
#include <limits>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Calls visit(run, a, b) for every spring, in the order of cloth.springs. For what is not hot.
template <typename Visitor>
void for_each_spring(const Cloth& cloth, Visitor&& visit) {
  for (const SpringRun& run : cloth.springs) {
    for (int i = 0; i < run.count; ++i) {
      visit(run, run.first + i, run.first + i + run.offset);
    }
  }
}

/// Of all springs [m]; infinite without springs.
inline double shortest_rest_length(const Cloth& cloth) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const SpringRun& run : cloth.springs) shortest = std::min(shortest, run.rest_length);
  return shortest;
}

/// Of all springs [m]; zero without springs.
inline double longest_rest_length(const Cloth& cloth) {
  double longest = 0;
  for (const SpringRun& run : cloth.springs) longest = std::max(longest, run.rest_length);
  return longest;
}

}  // namespace clothsim
