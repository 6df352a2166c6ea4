#include "line_kernels.h"

#include <cmath>
#include <limits>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

static_assert(num_lanes == 2 * half_size);

/// A spring that is shorter than sqrt(least_length2) [m] has no direction.
constexpr double least_length2 = std::numeric_limits<double>::min();

/// Half of a row.
[[gnu::always_inline]] inline const Half& half_of(const Lanes* row, int half) {
  return half_at(row->data() + half * half_size);
}
[[gnu::always_inline]] inline Half& half_of(Lanes* row, int half) {
  return *reinterpret_cast<Half*>(row->data() + half * half_size);
}

}  // namespace

CLOTHSIM_TARGET_CLONES
void load_points(const LineRows& rows, const double* x, int axis) {
  Lanes* const to = rows.at[static_cast<std::size_t>(axis)];
  for (int k = 0; k <= rows.springs; ++k) {
    for (std::size_t i = 0; i < num_lanes; ++i) to[k][i] = x[rows.points[k][i]];
  }
}

CLOTHSIM_TARGET_CLONES
void measure_springs(const LineRows& rows) {
  const auto [x, y, z] = rows.at;
  const auto [ux, uy, uz] = rows.u;
  for (int k = 0; k < rows.springs; ++k) {
    for (int half = 0; half < 2; ++half) {
      const Half dx = half_of(x + k + 1, half) - half_of(x + k, half);
      const Half dy = half_of(y + k + 1, half) - half_of(y + k, half);
      const Half dz = half_of(z + k + 1, half) - half_of(z + k, half);
      const Half length2 = dx * dx + dy * dy + dz * dz;
      Half length = length2 + least_length2;
      for (int lane = 0; lane < half_size; ++lane) length[lane] = std::sqrt(length[lane]);
      half_of(rows.lengths + k, half) = length;
      const Half inverse = length2 > least_length2 ? 1 / length : Half{};
      half_of(ux + k, half) = dx * inverse;
      half_of(uy + k, half) = dy * inverse;
      half_of(uz + k, half) = dz * inverse;
      const Half& compliance = half_of(rows.compliance + k, half);
      const Half residual =
          half_of(rows.target + k, half) - length - compliance * half_of(rows.lambda + k, half);
      half_of(rows.changes + k, half) = length2 > least_length2 ? residual : Half{};
      half_of(rows.pivots + k, half) =
          half_of(rows.inv_mass + k, half) + half_of(rows.inv_mass + k + 1, half) + compliance;
    }
  }
  for (int k = 1; k < rows.springs; ++k) {
    for (int half = 0; half < 2; ++half) {
      const Half cosine = half_of(ux + k - 1, half) * half_of(ux + k, half) +
                          half_of(uy + k - 1, half) * half_of(uy + k, half) +
                          half_of(uz + k - 1, half) * half_of(uz + k, half);
      half_of(rows.couplings + k, half) = -half_of(rows.inv_mass + k, half) * cosine;
    }
  }
}

CLOTHSIM_TARGET_CLONES
void eliminate(const LineRows& rows) {
  const int last = rows.springs - 1;
  Half inverse[2], change[2];
  for (int half = 0; half < 2; ++half) {
    inverse[half] = half_of(rows.pivots, half) = 1 / half_of(rows.pivots, half);
    change[half] = half_of(rows.changes, half);
  }
  for (int k = 1; k <= last; ++k) {
    for (int half = 0; half < 2; ++half) {
      const Half& coupling = half_of(rows.couplings + k, half);
      const Half& least = half_of(rows.compliance + k, half);
      const Half factor = coupling * inverse[half];
      const Half pivot = half_of(rows.pivots + k, half) - factor * coupling;
      change[half] = half_of(rows.changes + k, half) - factor * change[half];
      inverse[half] = 1 / (pivot > least ? pivot : least);
      half_of(rows.changes + k, half) = change[half];
      half_of(rows.pivots + k, half) = inverse[half];
    }
  }
  for (int half = 0; half < 2; ++half) {
    change[half] = half_of(rows.changes + last, half) *= half_of(rows.pivots + last, half);
  }
  for (int k = last - 1; k >= 0; --k) {
    for (int half = 0; half < 2; ++half) {
      change[half] =
          (half_of(rows.changes + k, half) - half_of(rows.couplings + k + 1, half) * change[half]) *
          half_of(rows.pivots + k, half);
      half_of(rows.changes + k, half) = change[half];
    }
  }
}

CLOTHSIM_TARGET_CLONES
void set_impulses(const LineRows& rows) {
  const auto [ux, uy, uz] = rows.u;
  for (Lanes* const numbers : {ux, uy, uz, rows.couplings}) numbers[rows.springs] = {};
  for (int k = 0; k < rows.springs; ++k) {
    for (int half = 0; half < 2; ++half) {
      const Half& change = half_of(rows.changes + k, half);
      const Half& length = half_of(rows.lengths + k, half);
      Half& lambda = half_of(rows.lambda + k, half);
      lambda += change;
      const Half expected =
          half_of(rows.target + k, half) - half_of(rows.compliance + k, half) * lambda;
      const Half least = length / 2;
      const Half density = -change / (expected > least ? expected : least);
      const Half impulse = change < 0 ? density * length : -change;
      half_of(rows.couplings + k, half) = change < 0 ? density : Half{};
      half_of(ux + k, half) *= impulse;
      half_of(uy + k, half) *= impulse;
      half_of(uz + k, half) *= impulse;
    }
  }
}

CLOTHSIM_TARGET_CLONES
void move_points(const LineRows& rows) {
  const auto [dx, dy, dz] = rows.moves;
  const auto [fx, fy, fz] = rows.u;
  Lanes* const after = rows.changes;
  struct Before {  // of the point or spring before; kept: of its density, by the points before
    Half density, kept, fx, fy, fz, dx, dy, dz;
  };
  Before before[2] = {};
  for (int k = 0; k <= rows.springs; ++k) {
    for (int half = 0; half < 2; ++half) {
      Before& b = before[half];
      const Half& w = half_of(rows.inv_mass + k, half);
      const Half& density = half_of(rows.couplings + k, half);
      const Half inverse = 1 / (1 + w * (density + b.kept));
      const Half share = w * inverse;
      const Half x = half_of(fx + k, half), y = half_of(fy + k, half), z = half_of(fz + k, half);
      b.dx = half_of(dx + k, half) = share * (x - b.fx + b.density * b.dx);
      b.dy = half_of(dy + k, half) = share * (y - b.fy + b.density * b.dy);
      b.dz = half_of(dz + k, half) = share * (z - b.fz + b.density * b.dz);
      half_of(after + k, half) = -share * density;
      b.kept = density * (1 + w * b.kept) * inverse;
      b.fx = x;
      b.fy = y;
      b.fz = z;
      b.density = density;
    }
  }
  Half next[2][3] = {};  // moves of the point after
  for (int k = rows.springs; k >= 0; --k) {
    for (int half = 0; half < 2; ++half) {
      const Half& a = half_of(after + k, half);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Half& move = half_of(rows.moves[axis] + k, half);
        next[half][axis] = move -= a * next[half][axis];
        half_of(rows.at[axis] + k, half) += move;
      }
    }
  }
}

CLOTHSIM_TARGET_CLONES
void turn_impulses(const LineRows& rows) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Lanes* const moves = rows.moves[axis];
    for (int k = 0; k < rows.springs; ++k) {
      for (int half = 0; half < 2; ++half) {
        half_of(rows.u[axis] + k, half) +=
            half_of(rows.couplings + k, half) *
            (half_of(moves + k + 1, half) - half_of(moves + k, half));
      }
    }
  }
}

void store_points(const LineRows& rows, std::size_t lines, int axis, double* x) {
  const Lanes* const from = rows.at[static_cast<std::size_t>(axis)];
  for (int k = 0; k <= rows.springs; ++k) {
    for (std::size_t i = 0; i < lines; ++i) x[rows.points[k][i]] = from[k][i];
  }
}

}  // namespace clothsim
