#pragma once

#include <cstddef>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/search/patches.h"

namespace clothsim {

/// Where the cells of patches are: corners and centres, side by side, so that one cell is measured
/// against all those of a patch at once.
class CellOutlines {
 public:
  static constexpr int cells_along_side = 4;  // of a patch, at most
  static constexpr std::size_t cells = cells_along_side * cells_along_side;
  static constexpr std::size_t pairs = cells * cells;  // i * cells + j of cells i and j of two

  explicit CellOutlines(std::size_t num_patches);

  /// Takes a patch as it is at `positions` [m, N x 3].
  void update(std::size_t patch, const Patch& of, const Points& positions);

  /// Finds the pairs of cells of two patches that are within `reach` [m], of a patch with itself
  /// each once. Puts them into `near` and returns how many they are.
  ///
  /// `distances` [m], which have room for `pairs` as `near` has, are as far apart as planes square
  /// to the line between the centres of two cells: never more than the cells are.
  std::size_t look(std::size_t patch, std::size_t other, double reach, double* distances,
                   int* near) const;

 private:
  enum : std::size_t { axes = 3 };
  enum : std::size_t { corners = 4 };
  static constexpr std::size_t size_of_patch = axes * (corners + 1) * cells;

  std::vector<double> values_;       // by patch, corner (the centre comes last), axis and cell
  std::vector<std::size_t> counts_;  // of cells, by patch
};

}  // namespace clothsim
