#include "clothsim/search/patches.h"

#include <algorithm>

namespace clothsim {

std::vector<Patch> cut_into_patches(const Cloth& cloth) {
  std::vector<Patch> patches;
  for (int first_row = 0; first_row < cloth.rows; first_row += Patch::side) {
    for (int first_column = 0; first_column < cloth.columns; first_column += Patch::side) {
      Patch patch;
      patch.tiles.fill(Patch::none);
      for (int r = 0; r <= Patch::side && first_row + r < cloth.rows; ++r) {
        for (int c = 0; c <= Patch::side && first_column + c < cloth.columns; ++c) {
          const int point = (first_row + r) * cloth.columns + first_column + c;
          patch.points.push_back(point);
          if (r == Patch::side || c == Patch::side) continue;
          patch.tiles[static_cast<std::size_t>(r * Patch::side + c)] = point;
        }
      }
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

void PatchMotions::follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
                          const Workers& workers) {
  const Points ways = to - from;
  longest_ = longest_beyond_mean(ways);
  ways_.resize(patches.size());
  workers.each(static_cast<int>(patches.size()), [&](int patch) {
    const auto p = static_cast<std::size_t>(patch);
    ways_[p] = around(ways, patches[p].points);
  });
}

/// The farthest apart that two of their ways are.
double PatchMotions::between(int p, int q) const {
  const Box &a = ways_[static_cast<std::size_t>(p)], &b = ways_[static_cast<std::size_t>(q)];
  return std::min((a.max() - b.min()).cwiseMax(b.max() - a.min()).norm(), most());
}

}  // namespace clothsim
