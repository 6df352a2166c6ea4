#pragma once

#include <algorithm>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Calls visit(run, a, b) for every spring, in the order of cloth.springs. Not for hot loops.
template <typename Visitor>
void for_each_spring(const Cloth& cloth, Visitor&& visit) {
  for (const SpringRun& run : cloth.springs) {
    for (int i = 0; i < run.count; ++i) {
      visit(run, run.first + i, run.first + i + run.offset);
    }
  }
}

/// Neighbours in cloth.springs that differ in their first points and counts, ascending: a kernel
/// takes them as one, from the first point of the first to the last of the last, gaps between runs
/// included.
struct SpringBand {
  const SpringRun* begin;
  const SpringRun* end;

  int first() const { return begin->first; }  // of the first points of springs
  int count() const { return (end - 1)->first + (end - 1)->count - first(); }

  /// Calls visit(begin, end) for the points between runs, from first() on.
  template <typename Visitor>
  void for_each_gap(Visitor&& visit) const {
    for (const SpringRun* run = begin; run + 1 != end; ++run) {
      visit(run->first + run->count - first(), (run + 1)->first - first());
    }
  }
};

/// Calls visit(band) for all of them, in the order of cloth.springs.
template <typename Visitor>
void for_each_band(const Cloth& cloth, Visitor&& visit) {
  const SpringRun* const all_end = cloth.springs.data() + cloth.springs.size();
  for (const SpringRun* begin = cloth.springs.data(); begin != all_end;) {
    const SpringRun* end = begin + 1;
    while (end != all_end && end->offset == begin->offset &&
           end->rest_length == begin->rest_length && end->stiffness == begin->stiffness &&
           end->first >= (end - 1)->first + (end - 1)->count) {
      ++end;
    }
    visit(SpringBand{begin, end});
    begin = end;
  }
}

/// Shortest of all springs [m]; infinite without springs.
inline double shortest_rest_length(const Cloth& cloth) {
  double shortest = infinity;
  for (const SpringRun& run : cloth.springs) shortest = std::min(shortest, run.rest_length);
  return shortest;
}

/// Longest of all springs [m]; zero without springs.
inline double longest_rest_length(const Cloth& cloth) {
  double longest = 0;
  for (const SpringRun& run : cloth.springs) longest = std::max(longest, run.rest_length);
  return longest;
}

}  // namespace clothsim
