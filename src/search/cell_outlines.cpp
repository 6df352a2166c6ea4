#include "clothsim/search/cell_outlines.h"

#include <cmath>
#include <limits>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr std::size_t n = CellOutlines::cells;

/// Distances are found in single precision: less than they are by more than its four roundings,
/// each half of this at most.
constexpr double rounding = std::numeric_limits<float>::epsilon();

// As ternaries they are vectorised.
inline double smaller(double a, double b) { return a < b ? a : b; }
inline double larger(double a, double b) { return a > b ? a : b; }

/// Distances of a cell with values `a` to the `n` of a patch with values `b`, see
/// CellOutlines::look(). `corner`: from one to the next, `centre`: where it stands.
CLOTHSIM_TARGET_CLONES
void measure(const double* __restrict a, const double* __restrict b, std::size_t corner,
             std::size_t centre, double* __restrict distances) {
  for (std::size_t j = 0; j < n; ++j) {
    const auto between = [=](std::size_t axis) {
      return b[centre + axis * n + j] - a[centre + axis * n];
    };
    const double x = between(0), y = between(1), z = between(2);
    const auto along = [=](const double* at) { return x * at[0] + y * at[n] + z * at[2 * n]; };
    const double highest = larger(larger(along(a), along(a + corner)),
                                  larger(along(a + 2 * corner), along(a + 3 * corner)));
    const double lowest = smaller(smaller(along(b + j), along(b + corner + j)),
                                  smaller(along(b + 2 * corner + j), along(b + 3 * corner + j)));
    const auto length = std::sqrt(static_cast<float>(x * x + y * y + z * z));
    const auto share = static_cast<float>(lowest - highest) / (length + 1e-30F);
    distances[j] = larger((1 - 4 * rounding) * static_cast<double>(share), 0);
  }
}

}  // namespace

CellOutlines::CellOutlines(std::size_t num_patches)
    : values_(num_patches * size_of_patch), counts_(num_patches) {}

void CellOutlines::update(std::size_t patch, const Patch& of, const Points& positions) {
  const int cells_in_row = of.columns - 1;
  counts_[patch] = of.cells.size();
  for (std::size_t c = 0; c < of.cells.size(); ++c) {
    double* const values = values_.data() + patch * size_of_patch + c;
    const auto put = [&](std::size_t k, const Vector3& x) {
      for (int axis = 0; axis < 3; ++axis) {
        values[(axes * k + static_cast<std::size_t>(axis)) * cells] = x[axis];
      }
    };
    const int cell = static_cast<int>(c);
    const int first = cell / cells_in_row * of.columns + cell % cells_in_row;
    Vector3 centre = Vector3::Zero();
    for (std::size_t k = 0; k < corners; ++k) {
      const int corner = first + (k % 2 == 1 ? 1 : 0) + (k / 2 == 1 ? of.columns : 0);
      const Vector3 x = row(positions, of.points[static_cast<std::size_t>(corner)]);
      put(k, x);
      centre += x / corners;
    }
    put(corners, centre);
  }
}

std::size_t CellOutlines::look(std::size_t patch, std::size_t other, double reach,
                               double* distances, int* near) const {
  const double* const a = values_.data() + patch * size_of_patch;
  const double* const b = values_.data() + other * size_of_patch;
  std::size_t found = 0;
  for (std::size_t i = 0; i < counts_[patch]; ++i) {
    measure(a + i, b, axes * n, corners * axes * n, distances + i * n);
    for (std::size_t j = patch == other ? i : 0; j < counts_[other]; ++j) {
      near[found] = static_cast<int>(i * n + j);
      found += distances[i * n + j] <= reach ? 1 : 0;
    }
  }
  return found;
}

}  // namespace clothsim
