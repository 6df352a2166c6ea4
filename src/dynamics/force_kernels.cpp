#include "force_kernels.h"

#include <cmath>
#include <limits>

#include "clothsim/model/target_clones.h"

namespace clothsim {
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
template <bool sprung, bool damped, typename Real>
[[gnu::always_inline]] inline void pull_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                 Columns<Real> v, int offset, int count,
                                                 Real* __restrict fx, Real* __restrict fy,
                                                 Real* __restrict fz) {
  const double* const spring = pairs.spring;
  const double* const bend = pairs.bend;
  const auto rest_length = static_cast<Real>(pairs.rest_length);
  const auto of_springs = static_cast<Real>(pairs.damping[0]);
  const auto of_bends = static_cast<Real>(pairs.damping[1]);
  for (int i = 0; i < count; ++i) {
    const Real dx = p.x[i + offset] - p.x[i];
    const Real dy = p.y[i + offset] - p.y[i];
    const Real dz = p.z[i + offset] - p.z[i];
    const Real ex = damped ? v.x[i + offset] - v.x[i] : Real{0};
    const Real ey = damped ? v.y[i + offset] - v.y[i] : Real{0};
    const Real ez = damped ? v.z[i + offset] - v.z[i] : Real{0};
    const auto w = static_cast<Real>(bend[i]);
    Real s = w;
    if constexpr (sprung) {
      const auto k = static_cast<Real>(spring[i]);
      const Real inverse = 1 / std::sqrt(dx * dx + dy * dy + dz * dz + min_length2<Real>);
      s += k - k * rest_length * inverse;
      if constexpr (damped) {
        const Real rate = (dx * inverse * ex + dy * inverse * ey + dz * inverse * ez) * inverse;
        s += of_springs * k * rate;
      }
    }
    const Real t = of_bends * w;
    fx[i] = damped ? s * dx + t * ex : s * dx;
    fy[i] = damped ? s * dy + t * ey : s * dy;
    fz[i] = damped ? s * dz + t * ez : s * dz;
  }
}

template <typename Real>
[[gnu::always_inline]] inline void pull_any_pairs_of(const Pairs& pairs, Columns<Real> p,
                                                     Columns<Real> v, int offset, int count,
                                                     Real* fx, Real* fy, Real* fz) {
  const bool sprung = pairs.spring != nullptr;
  const bool damped = v.x != nullptr;
  if (sprung && damped) return pull_pairs_of<true, true>(pairs, p, v, offset, count, fx, fy, fz);
  if (sprung) return pull_pairs_of<true, false>(pairs, p, v, offset, count, fx, fy, fz);
  if (damped) return pull_pairs_of<false, true>(pairs, p, v, offset, count, fx, fy, fz);
  pull_pairs_of<false, false>(pairs, p, v, offset, count, fx, fy, fz);
}

/// The differences of a cell's ends along one axis, by diagonal.
template <typename Real>
struct Ends {
  Real one;
  Real two;
};

template <typename Real>
[[gnu::always_inline]] inline Ends<Real> ends(const Real* x, int a, int b) {
  return {x[a + b] - x[0], x[b] - x[a]};
}

template <typename Real>
[[gnu::always_inline]] inline Real dot(Real x, Real y, Real z, Real a, Real b, Real c) {
  return x * a + y * b + z * c;
}

/// p2 d1 . e1 + q2 d2 . e2 + r (d1 . e2 + d2 . e1) of diagonals d = (x, y, z) and e = (a, b, c).
template <typename Real>
[[gnu::always_inline]] inline Real product(Real p2, Real q2, Real r, const Ends<Real>& x,
                                           const Ends<Real>& y, const Ends<Real>& z,
                                           const Ends<Real>& a, const Ends<Real>& b,
                                           const Ends<Real>& c) {
  return p2 * dot(x.one, y.one, z.one, a.one, b.one, c.one) +
         q2 * dot(x.two, y.two, z.two, a.two, b.two, c.two) +
         r * (dot(x.one, y.one, z.one, a.two, b.two, c.two) +
              dot(x.two, y.two, z.two, a.one, b.one, c.one));
}

template <bool bent, bool damped, typename Real>
[[gnu::always_inline]] inline void pull_cells_of(const CellPulls& cells, Columns<Real> p,
                                                 Columns<Real> v, int count, Real* __restrict ax,
                                                 Real* __restrict ay, Real* __restrict az,
                                                 Real* __restrict bx, Real* __restrict by,
                                                 Real* __restrict bz) {
  const int a = cells.a, b = cells.b;
  const auto p2 = static_cast<Real>(2 * cells.strain.p);
  const auto q2 = static_cast<Real>(2 * cells.strain.q);
  const auto r = static_cast<Real>(cells.strain.r);
  const auto rest = static_cast<Real>(cells.strain.rest);
  const auto of_cells = static_cast<Real>(cells.damping[0]);
  const auto of_bends = static_cast<Real>(cells.damping[1]);
  const double* const stiffness = cells.stiffness;
  const double* const first_bends = cells.bends[0];
  const double* const second_bends = cells.bends[1];
  for (int i = 0; i < count; ++i) {
    const Ends<Real> x = ends(p.x + i, a, b), y = ends(p.y + i, a, b), z = ends(p.z + i, a, b);
    Real strain = product(p2, q2, r, x, y, z, x, y, z) / 2 - rest;
    Ends<Real> ex{}, ey{}, ez{};
    if constexpr (damped) {
      ex = ends(v.x + i, a, b), ey = ends(v.y + i, a, b), ez = ends(v.z + i, a, b);
      strain += of_cells * product(p2, q2, r, x, y, z, ex, ey, ez);
    }
    const Real stress = static_cast<Real>(stiffness[i]) * strain;
    const Real one_bend = bent ? static_cast<Real>(first_bends[i]) : Real{0};
    const Real two_bend = bent ? static_cast<Real>(second_bends[i]) : Real{0};
    const Real of_one = p2 * stress + one_bend, of_two = q2 * stress + two_bend;
    const Real of_other = r * stress;
    ax[i] = of_one * x.one + of_other * x.two;
    ay[i] = of_one * y.one + of_other * y.two;
    az[i] = of_one * z.one + of_other * z.two;
    bx[i] = of_two * x.two + of_other * x.one;
    by[i] = of_two * y.two + of_other * y.one;
    bz[i] = of_two * z.two + of_other * z.one;
    if constexpr (bent && damped) {
      const Real one_rate = of_bends * one_bend, two_rate = of_bends * two_bend;
      ax[i] += one_rate * ex.one;
      ay[i] += one_rate * ey.one;
      az[i] += one_rate * ez.one;
      bx[i] += two_rate * ex.two;
      by[i] += two_rate * ey.two;
      bz[i] += two_rate * ez.two;
    }
  }
}

template <bool bent, typename Real>
[[gnu::always_inline]] inline void pull_damped_or_not(const CellPulls& cells, Columns<Real> p,
                                                      Columns<Real> v, int count,
                                                      Real* const f[6]) {
  if (v.x != nullptr) {
    pull_cells_of<bent, true>(cells, p, v, count, f[0], f[1], f[2], f[3], f[4], f[5]);
  } else {
    pull_cells_of<bent, false>(cells, p, v, count, f[0], f[1], f[2], f[3], f[4], f[5]);
  }
}

template <typename Real>
[[gnu::always_inline]] inline void pull_any_cells(const CellPulls& cells, Columns<Real> p,
                                                  Columns<Real> v, int count, Real* const f[6]) {
  if (cells.bends[0] != nullptr) {
    pull_damped_or_not<true>(cells, p, v, count, f);
  } else {
    pull_damped_or_not<false>(cells, p, v, count, f);
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
void pull_cells(const CellPulls& cells, Columns<double> p, Columns<double> v, int count,
                double* const forces[6]) {
  pull_any_cells(cells, p, v, count, forces);
}

CLOTHSIM_TARGET_CLONES
void pull_cells(const CellPulls& cells, Columns<float> p, Columns<float> v, int count,
                float* const forces[6]) {
  pull_any_cells(cells, p, v, count, forces);
}

}  // namespace clothsim
