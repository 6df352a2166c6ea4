#pragma once

// The loops of ForceBlocks, in double and in single precision, for the machine's vector unit.

namespace clothsim::force_kernels {

/// Directions whose forces one pass over a block's points sums: those of a classic cloth.
enum { max_terms = 6 };

/// Kinds of stencils of a fabric: along rows, along columns, the twist of cells.
enum { max_bends = 3 };

/// Addresses of points in each coordinate's column.
template <typename Real>
struct Columns {
  const Real* x;
  const Real* y;
  const Real* z;
};

/// Writes the forces [N] of springs (i, i + offset), i in [0, count), on their first points.
void pull(Columns<double>, int offset, int count, double rest_length, double stiffness, double* fx,
          double* fy, double* fz);
void pull(Columns<float>, int offset, int count, double rest_length, double stiffness, float* fx,
          float* fy, float* fz);

/// Springs and bends between points i and i + offset of a fabric, see PairBand, and the internal
/// damping of springs. One of both may be null.
struct Pairs {
  const double* spring;
  const double* bend;
  double rest_length;
  double damping;  // [s]
};

/// Writes the forces [N] of pairs (i, i + offset), i in [0, count), on their first points. `v`:
/// velocities [m/s], or null without damping.
void pull_pairs(const Pairs&, Columns<double> p, Columns<double> v, int offset, int count,
                double* fx, double* fy, double* fz);
void pull_pairs(const Pairs&, Columns<float> p, Columns<float> v, int offset, int count, float* fx,
                float* fy, float* fz);

/// Bending stencils (i, i + a, i + b, i + a + b) of a fabric with internal damping of bends.
struct Stencils {
  const double* stiffness;
  int a;
  int b;
  double damping;  // [s]
};

/// Writes the pulls G = k (1 + damping_share()) b [N] of the stencils i in [0, count): their four
/// points have the forces -G, G, G, -G. `v`: velocities [m/s].
void bend(const Stencils&, Columns<double> p, Columns<double> v, int count, double* gx, double* gy,
          double* gz);
void bend(const Stencils&, Columns<float> p, Columns<float> v, int count, float* gx, float* gy,
          float* gz);

/// Writes x - origin.
void narrow(const double* x, double origin, int count, float* to);

/// Writes g * start and the first `n` of `force`, less their values `offset` points before.
void sum_up_to_six(int n, double g, const double* start, const double* const* force,
                   const int* offset, int count, double* total);
void sum_up_to_six(int n, double g, const double* start, const float* const* force,
                   const int* offset, int count, float* total);
void sum_up_to_six(int n, double g, const float* start, const float* const* force,
                   const int* offset, int count, float* total);

/// Pulls G of stencils, see bend(), after those of a + b earlier ones.
template <typename Real>
struct Pulls {
  const Real* of[max_bends];
  int a[max_bends];
  int b[max_bends];
};

/// Adds to `total` the forces of `n` kinds of stencils.
void add_bends(int n, const Pulls<double>&, int count, double* total);
void add_bends(int n, const Pulls<float>&, int count, float* total);

}  // namespace clothsim::force_kernels
