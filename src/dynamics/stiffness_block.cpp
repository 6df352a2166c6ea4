#include "stiffness_block.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// A spring no longer than sqrt(min_direction2) [m] has no direction. It does not count, as it has
/// no force; in single precision, where that is uncertain, it counts in all directions.
template <typename Real>
constexpr Real min_direction2 = std::numeric_limits<Real>::min();
template <typename Real>
constexpr bool counts_without_length = false;
template <>
constexpr bool counts_without_length<float> = true;

/// Springs of one kind, between points and those `offset` further on in the columns x, y and z.
struct Springs {
  const double* x;
  const double* y;
  const double* z;
  int offset;
  double rest_length;
  double stiffness;
};

/// Stiffness k [u u^T + max(0, 1 - L0 / l) (I - u u^T)] of springs that begin at points [0, count).
template <typename Real>
[[gnu::always_inline]] inline void set_stiffness(const Springs& s, int count, Real* __restrict xx,
                                                 Real* __restrict yy, Real* __restrict zz,
                                                 Real* __restrict xy, Real* __restrict yz,
                                                 Real* __restrict xz) {
  const double* const x = s.x;
  const double* const y = s.y;
  const double* const z = s.z;
  const int offset = s.offset;
  const auto rest_length = static_cast<Real>(s.rest_length);
  const auto stiffness = static_cast<Real>(s.stiffness);
  const Real without_length = counts_without_length<Real> ? stiffness : Real{0};
  for (int i = 0; i < count; ++i) {
    const auto dx = static_cast<Real>(x[i + offset] - x[i]);
    const auto dy = static_cast<Real>(y[i + offset] - y[i]);
    const auto dz = static_cast<Real>(z[i + offset] - z[i]);
    const Real length2 = dx * dx + dy * dy + dz * dz;
    const bool has_length = length2 > min_direction2<Real>;
    const Real inverse = has_length ? 1 / std::sqrt(length2) : Real{0};
    const Real slack = 1 - rest_length * inverse;
    const Real across = slack > 0 ? slack : Real{0};
    const Real along = stiffness * (1 - across) * inverse * inverse;
    const Real all = has_length ? stiffness * across : without_length;
    xx[i] = along * dx * dx + all;
    yy[i] = along * dy * dy + all;
    zz[i] = along * dz * dz + all;
    xy[i] = along * dx * dy;
    yz[i] = along * dy * dz;
    xz[i] = along * dx * dz;
  }
}

CLOTHSIM_TARGET_CLONES
void stiffness_of(const Springs& s, int count, const Matrices<double>& to) {
  set_stiffness(s, count, to[0], to[1], to[2], to[3], to[4], to[5]);
}
CLOTHSIM_TARGET_CLONES
void stiffness_of(const Springs& s, int count, const Matrices<float>& to) {
  set_stiffness(s, count, to[0], to[1], to[2], to[3], to[4], to[5]);
}

/// Consecutive cells of a band, whose first corners are in the columns x, y and z.
struct CellColumns {
  const double* x;
  const double* y;
  const double* z;
  const CellBand& band;
  const double* stiffness;
};

/// Sets the parts of cells in S_i at both ends of their first diagonals, and of their second ones:
/// see omega_max_bound(). Six columns each, those of the second after those of the first.
template <typename Real>
[[gnu::always_inline]] inline void set_cell_stiffness(const CellColumns& cells, int count,
                                                      const Matrices<Real>& to) {
  const int a = cells.band.a, b = cells.band.b;
  const auto p = static_cast<Real>(cells.band.strain.p), q = static_cast<Real>(cells.band.strain.q);
  const auto r = static_cast<Real>(cells.band.strain.r);
  const auto rest = static_cast<Real>(cells.band.strain.rest);
  const double* const columns[3] = {cells.x, cells.y, cells.z};
  const double* const stiffness = cells.stiffness;
  Real* const sums = to.first;
  const int stride = to.stride;
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    Real one[3], two[3], by[2][3];
    Real one2 = 0, two2 = 0, across = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double* const x = columns[axis] + i;
      one[axis] = static_cast<Real>(x[a + b] - x[0]);
      two[axis] = static_cast<Real>(x[b] - x[a]);
      one2 += one[axis] * one[axis];
      two2 += two[axis] * two[axis];
      across += one[axis] * two[axis];
    }
    const auto k = static_cast<Real>(stiffness[i]);
    const Real stress = k * (p * one2 + q * two2 + r * across - rest);
    for (int axis = 0; axis < 3; ++axis) {
      by[0][axis] = 2 * p * one[axis] + r * two[axis];
      by[1][axis] = 2 * q * two[axis] + r * one[axis];
    }
    const Real mixed = stress * r < 0 ? -stress * r : stress * r;
    const Real signs[2] = {p * stress, q * stress};
    for (int d = 0; d < 2; ++d) {
      const Real transverse = (signs[d] > 0 ? 2 * signs[d] : Real{0}) + mixed;
      Real* const s = sums + d * coefficients * stride + i;
      const Real twice = 2 * k;
      s[0] = twice * by[d][0] * by[d][0] + transverse;
      s[stride] = twice * by[d][1] * by[d][1] + transverse;
      s[2 * stride] = twice * by[d][2] * by[d][2] + transverse;
      s[3 * stride] = twice * by[d][0] * by[d][1];
      s[4 * stride] = twice * by[d][1] * by[d][2];
      s[5 * stride] = twice * by[d][0] * by[d][2];
    }
  }
}

CLOTHSIM_TARGET_CLONES
void stiffness_of(const CellColumns& cells, int count, const Matrices<double>& to) {
  set_cell_stiffness(cells, count, to);
}
CLOTHSIM_TARGET_CLONES
void stiffness_of(const CellColumns& cells, int count, const Matrices<float>& to) {
  set_cell_stiffness(cells, count, to);
}

CLOTHSIM_TARGET_CLONES
void add(const double* __restrict added, int count, double* __restrict sum) {
  for (int i = 0; i < count; ++i) sum[i] += added[i];
}
CLOTHSIM_TARGET_CLONES
void add(const float* __restrict added, int count, float* __restrict sum) {
  for (int i = 0; i < count; ++i) sum[i] += added[i];
}

}  // namespace

template <typename Real>
Matrices<Real> StiffnessBlock<Real>::matrices() {
  return {sums_.data(), points_at_once};
}

template <typename Real>
void StiffnessBlock<Real>::sum(const Cloth& cloth, const Points& positions, int first, int count) {
  sums_.assign(coefficients * points_at_once, 0);
  for (const CellBand& band : cloth.cell_bands) add_cells(band, positions, first, count);
  for_each_band(cloth, [&](const SpringBand& band) {
    const SpringRun& run = *band.begin;
    if (run.stiffness == 0) return;
    const int from = std::max(band.first(), first - run.offset);
    const int to = std::min(band.first() + band.count(), first + count);
    if (from >= to) return;

    const int stride = to - from;
    springs_.resize(static_cast<std::size_t>(coefficients * stride));
    const Matrices<Real> springs{springs_.data(), stride};
    stiffness_of({&positions(from, 0), &positions(from, 1), &positions(from, 2), run.offset,
                  run.rest_length, run.stiffness},
                 stride, springs);
    band.for_each_gap([&](int gap, int gap_end) {
      gap = std::max(gap + band.first(), from);
      gap_end = std::min(gap_end + band.first(), to);
      for (int c = 0; c < coefficients; ++c) {
        for (int i = gap; i < gap_end; ++i) springs[c][i - from] = 0;
      }
    });

    const int begins = std::max(from, first);
    const int ends = std::min(to, first + count - run.offset);
    for (int c = 0; c < coefficients; ++c) {
      add(springs[c] + (begins - from), to - begins, matrices()[c] + (begins - first));
      add(springs[c], ends - from, matrices()[c] + (from + run.offset - first));
    }
  });
}

template <typename Real>
void StiffnessBlock<Real>::add_cells(const CellBand& band, const Points& positions, int first,
                                     int count) {
  const int last = band.a + band.b;
  const int from = std::max(0, first - last);
  const int to = std::min(static_cast<int>(band.stiffness.size()), first + count);
  if (from >= to) return;
  const int stride = to - from;
  springs_.resize(static_cast<std::size_t>(2 * coefficients * stride));
  const Matrices<Real> cells{springs_.data(), stride};
  stiffness_of(
      {&positions(from, 0), &positions(from, 1), &positions(from, 2), band, &band.stiffness[from]},
      stride, cells);
  for (const auto& [corner, diagonal] : {std::pair(0, 0), {last, 0}, {band.a, 1}, {band.b, 1}}) {
    const int begin = std::max(from, first - corner);
    const int end = std::min(to, first + count - corner);
    for (int c = 0; c < coefficients && begin < end; ++c) {
      add(cells[coefficients * diagonal + c] + (begin - from), end - begin,
          matrices()[c] + (begin + corner - first));
    }
  }
}

template class StiffnessBlock<double>;
template class StiffnessBlock<float>;

}  // namespace clothsim
