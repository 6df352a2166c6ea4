#include "force_kernels.h"

#include <cmath>
#include <limits>

#include "clothsim/model/target_clones.h"

namespace clothsim::force_kernels {
namespace {

/// Added to squared lengths [m^2]: a spring of zero length gets a finite factor, and no force.
template <typename Real>
constexpr Real min_length2 = std::numeric_limits<Real>::min();

/// Force of springs (i, i + offset), i in [0, count), on their first points. Square root and
/// division take twice as long as all the rest. Alternatives, an estimate of few bits with Newton's
/// method, or one of single precision with Halley's, take longer, since they need the units that do
/// the rest.
template <typename Real>
[[gnu::always_inline]] inline void pull_of(Columns<Real> p, int offset, int count,
                                           double rest_length, double stiffness,
                                           Real* __restrict fx, Real* __restrict fy,
                                           Real* __restrict fz) {
  const auto k = static_cast<Real>(stiffness);
  const auto tension = static_cast<Real>(stiffness * rest_length);
  for (int i = 0; i < count; ++i) {
    const Real dx = p.x[i + offset] - p.x[i];
    const Real dy = p.y[i + offset] - p.y[i];
    const Real dz = p.z[i + offset] - p.z[i];
    const Real length = std::sqrt(dx * dx + dy * dy + dz * dz + min_length2<Real>);
    const Real s = k - tension / length;
    fx[i] = s * dx;
    fy[i] = s * dy;
    fz[i] = s * dz;
  }
}

/// Forces of pairs (i, i + offset), i in [0, count), on their first points. `v`: velocities where
/// `damped`.
template <bool sprung, bool bent, bool damped, typename Real>
[[gnu::always_inline]] inline void pull_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                 Columns<Real> v, int offset, int count,
                                                 Real* __restrict fx, Real* __restrict fy,
                                                 Real* __restrict fz) {
  const double* const spring = pairs.spring;
  const double* const bend = pairs.bend;
  const auto rest_length = static_cast<Real>(pairs.rest_length);
  const auto damping = static_cast<Real>(pairs.damping);
  for (int i = 0; i < count; ++i) {
    const Real dx = p.x[i + offset] - p.x[i];
    const Real dy = p.y[i + offset] - p.y[i];
    const Real dz = p.z[i + offset] - p.z[i];
    Real s = 0;
    if constexpr (bent) s = static_cast<Real>(bend[i]);
    if constexpr (sprung) {
      const auto k = static_cast<Real>(spring[i]);
      const Real inverse = 1 / std::sqrt(dx * dx + dy * dy + dz * dz + min_length2<Real>);
      s += k - k * rest_length * inverse;
      if constexpr (damped) {
        const Real ex = v.x[i + offset] - v.x[i];
        const Real ey = v.y[i + offset] - v.y[i];
        const Real ez = v.z[i + offset] - v.z[i];
        const Real rate = (dx * inverse * ex + dy * inverse * ey + dz * inverse * ez) * inverse;
        s += damping * k * rate;
      }
    }
    fx[i] = s * dx;
    fy[i] = s * dy;
    fz[i] = s * dz;
  }
}

template <bool sprung, bool bent, typename Real>
[[gnu::always_inline]] inline void pull_damped_of(const Pairs& pairs, Columns<Real> p,
                                                  Columns<Real> v, int offset, int count, Real* fx,
                                                  Real* fy, Real* fz) {
  if (v.x != nullptr && pairs.damping > 0) {
    return pull_pairs_of<sprung, bent, true>(pairs, p, v, offset, count, fx, fy, fz);
  }
  pull_pairs_of<sprung, bent, false>(pairs, p, v, offset, count, fx, fy, fz);
}

template <typename Real>
[[gnu::always_inline]] inline void pull_any_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                     Columns<Real> v, int offset, int count,
                                                     Real* fx, Real* fy, Real* fz) {
  if (pairs.spring == nullptr) {
    return pull_pairs_of<false, true, false>(pairs, p, v, offset, count, fx, fy, fz);
  }
  if (pairs.bend == nullptr) {
    return pull_damped_of<true, false>(pairs, p, v, offset, count, fx, fy, fz);
  }
  pull_damped_of<true, true>(pairs, p, v, offset, count, fx, fy, fz);
}

template <typename Real>
[[gnu::always_inline]] inline Real stencil_sum(const Real* of, int a, int b) {
  return (of[0] - of[a]) - (of[b] - of[a + b]);
}

/// k (1 + damping_share()) b of the stencils i in [0, count), see BendBand. `straight`: a is b.
template <bool straight, typename Real>
[[gnu::always_inline]] inline void bend_of(const Stencils& stencils, Columns<Real> p,
                                           Columns<Real> v, int count, Real* __restrict gx,
                                           Real* __restrict gy, Real* __restrict gz) {
  const double* const stiffness = stencils.stiffness;
  const int a = stencils.a, b = straight ? stencils.a : stencils.b;
  const auto damping = static_cast<Real>(stencils.damping);
  for (int i = 0; i < count; ++i) {
    const Real bx = stencil_sum(p.x + i, a, b);
    const Real by = stencil_sum(p.y + i, a, b);
    const Real bz = stencil_sum(p.z + i, a, b);
    const Real ex = stencil_sum(v.x + i, a, b);
    const Real ey = stencil_sum(v.y + i, a, b);
    const Real ez = stencil_sum(v.z + i, a, b);
    const Real squared = bx * bx + by * by + bz * bz + min_length2<Real>;
    const Real rate = (bx * ex + by * ey + bz * ez) / squared;
    const Real s = static_cast<Real>(stiffness[i]) * (1 + damping * rate);
    gx[i] = s * bx;
    gy[i] = s * by;
    gz[i] = s * bz;
  }
}

/// Adds to start * g the first `n` of `force`, less their values `offset` points before.
template <int n, typename Real, typename Start>
[[gnu::always_inline]] inline void sum_of(double g, const Start* start, const Real* const* force,
                                          const int* offset, int count, Real* __restrict total) {
  const auto factor = static_cast<Start>(g);
  for (int i = 0; i < count; ++i) {
    auto sum = static_cast<Real>(start[i] * factor);
    for (int d = 0; d < n; ++d) sum += force[d][i] - force[d][i - offset[d]];
    total[i] = sum;
  }
}

/// The same for an `n` known at run time, `n_max` at most.
template <int n_max = max_terms, typename Real, typename Start>
[[gnu::always_inline]] inline void sum_up_to_six_of(int n, double g, const Start* start,
                                                    const Real* const* force, const int* offset,
                                                    int count, Real* __restrict total) {
  if constexpr (n_max > 0) {
    if (n < n_max) {
      return sum_up_to_six_of<n_max - 1>(n, g, start, force, offset, count, total);
    }
  }
  sum_of<n_max>(g, start, force, offset, count, total);
}

/// Adds to `total` the forces of `n` kinds of stencils, whose four points have -G, G, G, -G.
template <int n = max_bends, typename Real>
[[gnu::always_inline]] inline void add_bends_of(int count_kinds, const Pulls<Real>& pulls,
                                                int count, Real* __restrict total) {
  if constexpr (n > 1) {
    if (count_kinds < n) return add_bends_of<n - 1>(count_kinds, pulls, count, total);
  }
  for (int i = 0; i < count; ++i) {
    Real sum = total[i];
    for (int d = 0; d < n; ++d) {
      const Real* const g = pulls.of[d] + i;
      const int a = pulls.a[d], b = pulls.b[d];
      sum += (g[-a] - g[0]) - (g[-a - b] - g[-b]);
    }
    total[i] = sum;
  }
}

}  // namespace

CLOTHSIM_TARGET_CLONES
void pull(Columns<double> p, int offset, int count, double rest_length, double stiffness,
          double* fx, double* fy, double* fz) {
  pull_of(p, offset, count, rest_length, stiffness, fx, fy, fz);
}
CLOTHSIM_TARGET_CLONES
void pull(Columns<float> p, int offset, int count, double rest_length, double stiffness, float* fx,
          float* fy, float* fz) {
  pull_of(p, offset, count, rest_length, stiffness, fx, fy, fz);
}

CLOTHSIM_TARGET_CLONES
void pull_pairs(const Pairs& pairs, Columns<double> p, Columns<double> v, int offset, int count,
                double* fx, double* fy, double* fz) {
  pull_any_pairs_of(pairs, p, v, offset, count, fx, fy, fz);
}
CLOTHSIM_TARGET_CLONES
void pull_pairs(const Pairs& pairs, Columns<float> p, Columns<float> v, int offset, int count,
                float* fx, float* fy, float* fz) {
  pull_any_pairs_of(pairs, p, v, offset, count, fx, fy, fz);
}

CLOTHSIM_TARGET_CLONES
void bend(const Stencils& stencils, Columns<double> p, Columns<double> v, int count, double* gx,
          double* gy, double* gz) {
  if (stencils.a == stencils.b) return bend_of<true>(stencils, p, v, count, gx, gy, gz);
  bend_of<false>(stencils, p, v, count, gx, gy, gz);
}
CLOTHSIM_TARGET_CLONES
void bend(const Stencils& stencils, Columns<float> p, Columns<float> v, int count, float* gx,
          float* gy, float* gz) {
  if (stencils.a == stencils.b) return bend_of<true>(stencils, p, v, count, gx, gy, gz);
  bend_of<false>(stencils, p, v, count, gx, gy, gz);
}

CLOTHSIM_TARGET_CLONES
void narrow(const double* x, double origin, int count, float* __restrict to) {
  for (int i = 0; i < count; ++i) to[i] = static_cast<float>(x[i] - origin);
}

CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const double* start, const double* const* force,
                   const int* offset, int count, double* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}
CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const double* start, const float* const* force,
                   const int* offset, int count, float* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}
CLOTHSIM_TARGET_CLONES
void sum_up_to_six(int n, double g, const float* start, const float* const* force,
                   const int* offset, int count, float* total) {
  sum_up_to_six_of(n, g, start, force, offset, count, total);
}

CLOTHSIM_TARGET_CLONES
void add_bends(int n, const Pulls<double>& pulls, int count, double* total) {
  add_bends_of(n, pulls, count, total);
}
CLOTHSIM_TARGET_CLONES
void add_bends(int n, const Pulls<float>& pulls, int count, float* total) {
  add_bends_of(n, pulls, count, total);
}

}  // namespace clothsim::force_kernels
