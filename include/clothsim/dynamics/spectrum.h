#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Both bounds include the springs, the bends and their internal damping. To springs of omega_s,
/// bends add at most omega_b^2 = max_i sum_j |K_ij| / m_i (Gershgorin), and with internal damping
/// explicit steps need omega^2 = omega_s^2 (1 + tau_0 omega) + omega_b^2 (1 + tau_1 omega): Verlet
/// with a damping that is half a step late is stable for h omega < 2, since then h^2 omega_0^2 + 2
/// h tau omega_0^2 < 4 for each mode of frequency omega_0.

/// Upper bound on the highest frequency omega_max [rad/s] of the springs at `positions`; never
/// below the exact one, and 5 % above it for a flat classic cloth with all families on.
///
/// A spring's Hessian is k B with B = u u^T + max(0, 1 - L0 / l) (I - u u^T). From (a - b)^T B (a -
/// b) <= 2 a^T B a + 2 b^T B b follows, with S_i the sum of k B over the springs at point i,
/// omega_max^2 <= max_i 2 lambda_max(S_i) / m_i: Gershgorin's theorem on 3 x 3 blocks. It keeps the
/// springs' directions, unlike the scalar form 2 max_i sum k / m_i. Compressed springs count
/// without their (negative) second part, so the bound holds for them too. A bound below `min_omega`
/// returns `min_omega`: that needs no eigenvalue, and single precision mostly suffices.
///
/// A strain c of a cell, with the derivatives g_d by its diagonals and stress s = k c, changes by
/// g_1 . (w_3 - w_0) + g_2 . (w_2 - w_1). So it adds 2 k g_d g_d^T to S_i of both ends of diagonal
/// d, and max(0, 2 s p) + |s r| of the first one, max(0, 2 s q) + |s r| of the second one, across
/// them: see CellStrain.
///
/// For the triangles of a mesh see membrane_bounds(); its pieces do not move each other.
double omega_max_bound(const Cloth&, const Points& positions, double min_omega = 0,
                       const Workers& = {});

/// The same at any positions, by the scalar form: on a grid up to 48 % above it, and far cheaper.
/// Infinite for a mesh and for cells, whose stiffness grows with their stretch.
double omega_max_bound(const Cloth&);

}  // namespace clothsim
