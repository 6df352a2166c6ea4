#include "clothsim/dynamics/incremental_potential.h"

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/forces.h"

namespace clothsim {

double incremental_potential(const Cloth& cloth, const Scalars& weights, const Points& y,
                             const Points& d, const Past& past) {
  return weights.dot(d.rowwise().squaredNorm()) / 2 + elastic_energy(cloth, y + d) +
         (past.empty() ? 0 : damping_potential(cloth, past, y + d));
}

void potential_gradient(const Cloth& cloth, const Scalars& weights, const Points& positions,
                        const Points& d, Points& gradient, const Past& past) {
  const Loads none{Vector3::Zero()};
  compute_forces(cloth, none, positions, gradient);
  gradient = -gradient;
  add_damping_gradient(cloth, past, positions, gradient);
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] > 0) {
      gradient.row(i) = weights[i] * d.row(i) + gradient.row(i);
    } else {
      gradient.row(i).setZero();
    }
  }
}

}  // namespace clothsim
