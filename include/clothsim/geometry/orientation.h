#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// Sign of (b - a) x (c - a) . (d - a): +1 where d lies on the side of the plane abc from which a,
/// b, c appear counter-clockwise, -1 on the other side, 0 where the four are coplanar or abc is a
/// line or a point.
///
/// Exact: a double is tried first, and where its error bound leaves the sign open, the determinant
/// is computed without rounding. Valid for coordinates that are 0 or of magnitude 1e-70 to 1e90;
/// beyond, products may leave the range of double and the sign may be wrong. Shewchuk 1997,
/// "Adaptive precision floating-point arithmetic and fast robust geometric predicates".
int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);

}  // namespace clothsim
