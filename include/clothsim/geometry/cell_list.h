#pragma once

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/model/work_budget.h"

namespace clothsim {

/// Two points of a cloth, a < b.
struct PointPair {
  int a;
  int b;
};

inline bool operator<(const PointPair& p, const PointPair& q) {
  return std::tie(p.a, p.b) < std::tie(q.a, q.b);
}
inline bool operator==(const PointPair& p, const PointPair& q) { return p.a == q.a && p.b == q.b; }

/// Finds close pairs of points with a cell list: points are sorted by the integer coordinates of
/// their cell, and each looks into the half of its 26 neighbour cells that comes after its own.
/// Hockney & Eastwood, Computer Simulation Using Particles, 8.4.
class PairFinder {
 public:
  /// All pairs closer than `distance` [m], sorted, but those that are left out. `positions` must be
  /// finite. Some are missing where the budget is spent.
  void find(const Points& positions, double distance, std::vector<PointPair>& pairs,
            WorkBudget* = nullptr,
            const std::function<bool(const PointPair&)>& leaves_out = nullptr);

 private:
  struct Entry {
    std::uint64_t cell;
    int point;
    double x, y, z;  // [m]
  };

  void sort_into_cells(const Points& positions, double distance);

  std::vector<Entry> entries_;  // sorted by cell, then point: next time, they almost are
};

}  // namespace clothsim
