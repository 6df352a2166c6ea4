#include "clothsim/geometry/cell_list.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace clothsim {
namespace {

/// 21 bits a coordinate, x lowest, so that cells along x follow each other. Cells farther than a
/// million from the first point's share the outermost one: slower, never wrong.
enum { bits = 21 };
constexpr std::int64_t last_cell = (std::int64_t{1} << bits) - 2;  // leaves room for a neighbour

std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(x | (y << bits) | (z << (2 * bits)));
}

std::int64_t cell_coordinate(double x, double origin, double size) {
  const double middle = static_cast<double>(last_cell / 2);
  const double cell = std::floor((x - origin) / size) + middle;
  return static_cast<std::int64_t>(std::clamp(cell, 1.0, static_cast<double>(last_cell)));
}

/// Ranges of three cells along x: the rows that come after a cell's own.
constexpr std::array<std::array<int, 2>, 4> rows_after = {{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

}  // namespace

void PairFinder::sort_into_cells(const Points& positions, double distance) {
  const auto count = static_cast<std::size_t>(positions.rows());
  if (entries_.size() != count) {
    entries_.resize(count);
    for (std::size_t i = 0; i < count; ++i) entries_[i].point = static_cast<int>(i);
  }
  const Vector3 origin = row(positions, 0);
  for (Entry& entry : entries_) {
    const Vector3 at = row(positions, entry.point);
    entry = {key(cell_coordinate(at.x(), origin.x(), distance),
                 cell_coordinate(at.y(), origin.y(), distance),
                 cell_coordinate(at.z(), origin.z(), distance)),
             entry.point, at.x(), at.y(), at.z()};
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& p, const Entry& q) {
    return std::tie(p.cell, p.point) < std::tie(q.cell, q.point);
  });
}

void PairFinder::find(const Points& positions, double distance, std::vector<PointPair>& pairs,
                      WorkBudget* budget, const std::function<bool(const PointPair&)>& leaves_out) {
  assert(positions.allFinite() && distance > 0);
  pairs.clear();
  if (positions.rows() == 0) return;

  sort_into_cells(positions, distance);
  const double distance2 = distance * distance;
  std::int64_t visits = 0;  // of an entry
  const auto try_pair = [&](const Entry& p, const Entry& q) {
    ++visits;
    const double dx = p.x - q.x, dy = p.y - q.y, dz = p.z - q.z;
    if (!(dx * dx + dy * dy + dz * dz < distance2)) return;
    const PointPair pair{std::min(p.point, q.point), std::max(p.point, q.point)};
    if (leaves_out && leaves_out(pair)) return;
    pairs.push_back(pair);
    visits += WorkBudget::pair_found;
  };

  // Cells are visited in order, so the rows after them are followed by fingers that only go
  // forward.
  std::array<std::size_t, rows_after.size()> fingers{};
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    if (budget) budget->spend(std::exchange(visits, 0));
    if (budget && budget->is_spent()) break;
    const Entry& entry = entries_[e];

    // The rest of the own cell, and the next one along x.
    for (std::size_t f = e + 1; f < entries_.size() && entries_[f].cell <= entry.cell + 1; ++f) {
      try_pair(entry, entries_[f]);
    }
    for (std::size_t r = 0; r < rows_after.size(); ++r) {
      const std::uint64_t middle = entry.cell + key(0, 0, rows_after[r][1]) +
                                   static_cast<std::uint64_t>(rows_after[r][0]) * key(0, 1, 0);
      std::size_t& finger = fingers[r];
      while (finger < entries_.size() && entries_[finger].cell < middle - 1) ++finger;
      for (std::size_t f = finger; f < entries_.size() && entries_[f].cell <= middle + 1; ++f) {
        try_pair(entry, entries_[f]);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace clothsim
