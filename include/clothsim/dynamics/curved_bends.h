#pragma once

#include <vector>

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/triangle_fabric.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

// The terms of CurvedTriangle, in addition to those of the bends' pairs: see PairBand.

/// Points for the functions below, which are instantiated for both kinds of views.
struct PointView {
  explicit PointView(const Points& values) : points(values) {}
  Vector3 operator()(int i) const { return row(points, i); }
  const Points& points;
};

/// The same for `stride` numbers a point, the first three its coordinates.
struct QuadView {
  const double* data;
  int stride;
  Eigen::Map<const Vector3> operator()(int i) const {
    return Eigen::Map<const Vector3>(data + stride * i);
  }
};

/// Adds the elastic forces [N].
template <typename View>
void add_curved_forces(const TriangleFabric&, const View& positions, const Workers&,
                       Points& forces);

/// Adds `factor` times the damping forces, by the rates of b - B n less those of a rotation by
/// piece [rad/s]: see bend_rotations(). Without `rotations` nothing is left out.
template <typename View>
void add_curved_damping(const TriangleFabric&, double factor, const View& positions,
                        const View& velocities, const std::vector<Vector3>& rotations,
                        const Workers&, Points& forces);

/// The elastic force on a point, plus that of damping, with rates that include rotations [N].
/// `velocities`: null without damping.
Vector3 curved_force_on(const TriangleFabric&, int point, const Points& positions,
                        const Points* velocities);

/// Adds the sums of BendMotion, by piece.
template <typename View>
void add_curved_motions(const TriangleFabric&, const View& positions, const View& rates,
                        std::vector<BendMotion>& motions);

/// Adds to `sums`, by point, Gershgorin's row sums of the terms that are quadratic in changes of
/// normals [N/m]: S |dn|^2, and at most |sum of k B (b - B n)| |d^2 n| for the second derivative of
/// n. |dn| is at most the sum of |dn / dx_i| |dx_i|, |d^2 n| at most 5 times the square of that
/// where |N| is e / 2 or more, see SmoothNormal.
void add_curved_sums(const Cloth&, const Points& positions, Scalars& sums);

}  // namespace clothsim
