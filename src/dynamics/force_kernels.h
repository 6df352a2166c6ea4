#pragma once

#include <array>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Addresses of points in each coordinate's column.
template <typename Real>
struct Columns {
  const Real* x;
  const Real* y;
  const Real* z;
};

/// Forces of springs (i, i + offset), i in [0, count), on their first points.
void pull(Columns<double> p, int offset, int count, double rest_length, double stiffness,
          double* fx, double* fy, double* fz);
void pull(Columns<float> p, int offset, int count, double rest_length, double stiffness, float* fx,
          float* fy, float* fz);

/// Springs and bends between points i and i + offset of a fabric, see PairBand, and their internal
/// damping [s]: of springs, of bends.
struct Pairs {
  const double* spring;
  const double* bend;
  double rest_length;
  std::array<double, 2> damping;
};

/// Forces of pairs (i, i + offset), i in [0, count), on their first points. `v`: velocities, null
/// without damping.
void pull_pairs(const Pairs& pairs, Columns<double> p, Columns<double> v, int offset, int count,
                double* fx, double* fy, double* fz);
void pull_pairs(const Pairs& pairs, Columns<float> p, Columns<float> v, int offset, int count,
                float* fx, float* fy, float* fz);

/// Consecutive cells of a CellBand, and bends along their diagonals.
struct CellPulls {
  int a;
  int b;
  CellStrain strain;
  const double* stiffness;
  std::array<const double*, 2> bends;  // weights by diagonal [N/m]; null: none
  std::array<double, 2> damping;       // internal, of cells and of bends [s]
};

/// Forces of `count` cells on the first ends of their first and second diagonals, in x, y, z each.
/// `v`: velocities, null without damping.
void pull_cells(const CellPulls&, Columns<double> p, Columns<double> v, int count,
                double* const forces[6]);
void pull_cells(const CellPulls&, Columns<float> p, Columns<float> v, int count,
                float* const forces[6]);

}  // namespace clothsim
