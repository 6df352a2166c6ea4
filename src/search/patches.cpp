#include "clothsim/search/patches.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace clothsim {

namespace {

using Tiles = std::array<int, Patch::side * Patch::side>;

Patch patch_of(const Tiling& tiling, const Tiles& tiles) {
  Patch patch{tiles, {}};
  for (const int tile : tiles) {
    if (tile == Patch::none) continue;
    const auto& corners = tiling.at(tile).points;
    patch.points.insert(patch.points.end(), corners.begin(), corners.end());
  }
  std::sort(patch.points.begin(), patch.points.end());
  patch.points.erase(std::unique(patch.points.begin(), patch.points.end()), patch.points.end());
  return patch;
}

/// Adds the patches of some tiles, cut by the places of their centres.
void halve(const Tiling& tiling, const Points& centres, int* begin, int* end,
           std::vector<Patch>& patches) {
  if (end - begin <= Patch::side * Patch::side) {
    Tiles tiles;
    tiles.fill(Patch::none);
    std::copy(begin, end, tiles.begin());
    patches.push_back(patch_of(tiling, tiles));
    return;
  }
  int axis = 0;
  around(centres, std::vector<int>(begin, end)).sizes().maxCoeff(&axis);
  int* const middle = begin + (end - begin) / 2;
  std::nth_element(begin, middle, end, [&](int a, int b) {
    return std::pair(centres(a, axis), a) < std::pair(centres(b, axis), b);
  });
  halve(tiling, centres, begin, middle, patches);
  halve(tiling, centres, middle, end, patches);
}

}  // namespace

std::vector<Patch> cut_into_patches(const Tiling& tiling, int columns, int rows) {
  std::vector<Patch> patches;
  for (int first_row = 0; first_row < rows; first_row += Patch::side) {
    for (int first_column = 0; first_column < columns; first_column += Patch::side) {
      Tiles tiles;
      for (int k = 0; k < static_cast<int>(tiles.size()); ++k) {
        const int row = first_row + k / Patch::side, column = first_column + k % Patch::side;
        const bool exists = row < rows && column < columns;
        tiles[static_cast<std::size_t>(k)] = exists ? row * columns + column : Patch::none;
      }
      patches.push_back(patch_of(tiling, tiles));
    }
  }
  return patches;
}

std::vector<Patch> cut_into_patches(const Tiling& tiling, const Points& rest) {
  std::vector<Patch> patches;
  const auto count = static_cast<int>(tiling.tiles().size());
  if (count == 0) return patches;
  Points centres = Points::Zero(count, 3);
  for (int tile = 0; tile < count; ++tile) {
    for (const int corner : tiling.at(tile).points) centres.row(tile) += rest.row(corner) / 4;
  }
  std::vector<int> tiles(static_cast<std::size_t>(count));
  std::iota(tiles.begin(), tiles.end(), 0);
  halve(tiling, centres, tiles.data(), tiles.data() + count, patches);
  return patches;
}

void PatchMotions::follow(const std::vector<Patch>& patches, const Points& from, const Points& to,
                          const Workers& workers) {
  Points displacements(from.rows(), 3);
  workers.parallel_for(static_cast<int>(displacements.rows()), [&](int begin, int end) {
    const int count = end - begin;
    displacements.middleRows(begin, count) =
        to.middleRows(begin, count) - from.middleRows(begin, count);
  });
  longest_ = longest_beyond_mean(displacements);
  displacements_.resize(patches.size());
  workers.each(static_cast<int>(patches.size()), [&](int patch) {
    const auto p = static_cast<std::size_t>(patch);
    displacements_[p] = around(displacements, patches[p].points);
  });
}

/// The largest distance between two of their displacements.
double PatchMotions::between(int p, int q) const {
  const Box &a = displacements_[static_cast<std::size_t>(p)],
            &b = displacements_[static_cast<std::size_t>(q)];
  return std::min((a.max() - b.min()).cwiseMax(b.max() - a.min()).norm(), max());
}

}  // namespace clothsim
