#include "clothsim/constraints/lagged_contact.h"

#include <algorithm>

namespace clothsim {
namespace {

/// Part of the bound on shares. With half of a similar bound a strip on a rod shakes up.
constexpr double part_of_bound = 0.25;

}  // namespace

const Points& LaggedContact::begin_step(double h, const Cloth& cloth) {
  if (h_ == 0) {
    lagged_.setZero(cloth.num_points(), 3);
  } else if (h != h_) {
    lagged_ *= h / h_;
  }
  h_ = h;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0) lagged_.row(i).setZero();
  }
  return lagged_;
}

void LaggedContact::follow(const ColliderContacts& colliders, const SelfContacts* self,
                           double gravity, double cells) {
  given_.setZero(lagged_.rows(), 3);
  colliders.add_velocities(given_);
  if (self) self->add_velocities(given_);
  const double fall = gravity * h_;  // [m/s]
  for (Eigen::Index i = 0; i < lagged_.rows(); ++i) {
    const double change = given_.row(i).norm();
    const double bound = change > 0 ? std::min(1 / cells, fall / change) : 1;
    lagged_.row(i) += part_of_bound * bound * (given_.row(i) - lagged_.row(i));
  }
}

void LaggedContact::write(MemoryWriter& memory) const {
  memory.add(h_);
  if (h_ > 0) memory.add(lagged_);
}

void LaggedContact::read(MemoryReader& memory, const Cloth& cloth) {
  h_ = std::max(0.0, memory.number());
  if (h_ > 0) lagged_ = memory.points(cloth.num_points());
}

}  // namespace clothsim
