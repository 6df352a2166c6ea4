#pragma once

#include <vector>

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/triangle_fabric.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// compute_forces() for a cloth that is a mesh, see TriangleFabric. Internal damping makes squared
/// lengths q + tau_0 q' of q.
void compute_triangle_forces(const Cloth&, const Loads&, const Points& positions, Points& forces,
                             const Workers&, const Points* velocities);

/// Energy of the membrane of a mesh [J].
double membrane_energy(const Cloth&, const Points& positions);

/// Squared lengths of a triangle's edges [m^2], edge k from corner k to corner k + 1.
Vector3 squared_edges(const std::array<int, 3>& corners, const Points& positions);

/// Pulls s = K (q + tau q' - Q) of a triangle's edges [N/m]: edge d has the force 2 s d on its
/// first end. `velocities`: null without damping.
Vector3 triangle_pulls(const Cloth&, std::size_t triangle, const Points& positions,
                       const Points* velocities);

/// Tension of each edge of a mesh [N], in the order of cloth.springs.
std::vector<double> edge_tensions(const Cloth&, const Points& positions, const Points* velocities);

/// J^T w J of a triangle with squared edges q [m^2]: J are half the derivatives of q by the
/// displacements of the corners, `w` is a weight of each corner.
Eigen::Matrix3d squared_derivatives(const Vector3& q, const Vector3& w);

/// Bounds on the membrane's highest frequency by piece [rad/s], at least `min_omega`: the largest
/// of the triangles, each alone with a part of its points' masses (Irons & Treharne 1971, "A bound
/// theorem in eigenvalues and its practical applications"): a point divides its mass among its
/// triangles in proportion to their stiffness. Pins do not move. On the sheets of
/// test/unit/triangle_fabric_test.cpp up to 1.4 times the exact one.
std::vector<double> membrane_bounds(const Cloth&, const Points& positions,
                                    std::vector<double> min_omega);

}  // namespace clothsim
