#pragma once

#include "clothsim/geometry/box_tree.h"
#include "clothsim/model/cloth.h"

namespace clothsim {

/// Bounds of the gradient F of the map from a cloth at rest to space, over some triangles: its
/// columns along the grid's rows and along its columns.
struct GradientBounds {
  Box along_row;
  Box along_column;

  void extend(const GradientBounds&);
};

/// Over both triangles of each of columns x rows cells, from that whose first point is
/// (first_column, first_row) on.
GradientBounds gradient_bounds(const Cloth&, const Points& positions, int first_column,
                               int first_row, int columns, int rows);

/// The least share L of their distance at rest that two points of a rectangle of the grid are
/// proved to be apart, without looking at pairs. `bounds`: over all cells of the rectangle. Zero or
/// less, or NaN, where it cannot be told.
///
/// If there are two orthonormal directions Q such that the symmetric part of Q^T F has no
/// eigenvalue below L on any triangle of the rectangle, then two points of it that are d apart at
/// rest are at least L d apart: project their difference on Q and integrate F along the line
/// between them. It is the normal cone and the boundary test (Volino & Magnenat-Thalmann 1994) in
/// one, since a rectangle is convex, and it bounds the distance.
double least_stretch(const GradientBounds& bounds);

}  // namespace clothsim
