#include "clothsim/search/cell_outlines.h"

#include <array>
#include <cmath>
#include <cstdint>

#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr std::size_t n = CellOutlines::cells;

/// Distances are found in single precision: less than they are by more than that rounds.
constexpr double rounding = 1e-5;

// As ternaries they are vectorised.
inline double smaller(double a, double b) { return a < b ? a : b; }
inline double larger(double a, double b) { return a > b ? a : b; }

/// As CellOutlines::look(); `a` and `b` are the values of the patches.
CLOTHSIM_TARGET_CLONES
std::size_t look_at(const double* __restrict a, const double* __restrict b, double moved,
                    double nearest, double reach, double* __restrict wake_at,
                    int* __restrict awake) {
  constexpr std::size_t corner = 3 * n;  // from one to the next
  constexpr std::size_t centre = 4 * corner;
  std::size_t found = 0;
  for (std::size_t i = 0; i < n; ++i, ++a, wake_at += n) {
    std::int64_t any = 0;
    for (std::size_t j = 0; j < n; ++j) any |= std::int64_t{wake_at[j] <= moved + reach};
    if (any == 0) continue;

    std::array<std::int64_t, n> is_near;
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
      const double gap = larger((1 - rounding) * static_cast<double>(share), 0) - nearest;
      const bool wakes = wake_at[j] <= moved + reach;
      is_near[j] = std::int64_t{wakes & (gap <= reach)};
      wake_at[j] = wakes ? moved + gap : wake_at[j];
    }
    for (std::size_t j = 0; j < n; ++j) {
      awake[found] = static_cast<int>(i * n + j);
      found += static_cast<std::size_t>(is_near[j]);
    }
  }
  return found;
}

}  // namespace

CellOutlines::CellOutlines(std::size_t num_patches) : values_(num_patches * size_of_patch) {}

void CellOutlines::update(std::size_t patch, const Patch& of, const Points& positions) {
  const int cells_in_row = of.columns - 1;
  for (std::size_t c = 0; c < of.cells.size(); ++c) {
    double* const values = values_.data() + patch * size_of_patch + c;
    const auto put = [&](std::size_t k, const Vector3& x) {
      for (int axis = 0; axis < 3; ++axis) {
        values[(3 * k + static_cast<std::size_t>(axis)) * cells] = x[axis];
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

std::size_t CellOutlines::look(std::size_t patch, std::size_t other, double moved, double nearest,
                               double reach, double* wake_at, int* awake) const {
  const double* const first = values_.data();
  return look_at(first + patch * size_of_patch, first + other * size_of_patch, moved, nearest,
                 reach, wake_at, awake);
}

}  // namespace clothsim
