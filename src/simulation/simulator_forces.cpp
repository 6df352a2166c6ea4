// External forces on points, and tensions within the cloth.

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Range of the components of a force on a point: no machine exerts more.
constexpr Range force_range{-1e6, 1e6, "N"};

}  // namespace

void Simulator::Impl::apply_external_forces(const Cloth& inert, double h) {
  if (external_forces.rows() == 0) return;
  state.velocities += h * (external_forces.array().colwise() * inert.inv_mass.array()).matrix();
  if (!holders.empty()) impulses += h * external_forces;
  // Without its history BDF2 takes a step of implicit Euler. All points must do so: otherwise
  // momentum would not balance.
  if (auto* bdf2 = std::get_if<Bdf2>(&method->integrator)) bdf2->forget();
}

double Simulator::Impl::max_external_acceleration() const {
  if (external_forces.rows() == 0) return 0;
  return (external_forces.rowwise().norm().array() * cloth.inv_mass.array()).maxCoeff();
}

double Simulator::Impl::work_of_external_forces(double dt, const State& before) const {
  if (external_forces.rows() == 0) return 0;
  const Scalars strength = external_forces.rowwise().norm();
  const Scalars displacements = (state.positions - before.positions).rowwise().norm();
  const auto from_rest = dt * dt * strength.array().square() * cloth.inv_mass.array();
  return (strength.array() * displacements.array() + from_rest).sum();
}

void Simulator::set_forces(const Points& forces) {
  if (forces.rows() == 0) {
    impl_->external_forces = forces;
    return;
  }
  if (forces.rows() != cloth().num_points()) {
    throw InvalidValue({"forces"}, std::to_string(forces.rows()) + " of them",
                       std::to_string(cloth().num_points()) + ", one for each point");
  }
  inside("forces", [&] {
    for (Eigen::Index i = 0; i < forces.rows(); ++i) {
      check_range(std::to_string(i), Vector3(forces.row(i).transpose()), force_range);
    }
  });
  impl_->external_forces = forces;
}

const Points& Simulator::forces() const { return impl_->external_forces; }

std::vector<double> Simulator::tensions() const {
  const State& now = state();
  const double viscous = cloth().internal_damping[0];
  std::vector<double> tensions;
  tensions.reserve(static_cast<std::size_t>(cloth().num_springs()));
  if (cloth().is_mesh()) {
    tensions =
        edge_tensions(cloth(), now.positions, is_damped(cloth()) ? &now.velocities : nullptr);
  } else {
    for_each_spring(cloth(), [&](const SpringRun& run, int a, int b) {
      const Vector3 along = (now.positions.row(b) - now.positions.row(a)).transpose();
      const Vector3 rate = (now.velocities.row(b) - now.velocities.row(a)).transpose();
      const double length = along.norm();
      const double parting = length > 0 ? rate.dot(along) / length : 0;
      tensions.push_back(run.stiffness * (length - run.rest_length + viscous * parting));
    });
  }
  // The limit acts at a substep's end, when drag has reduced the effect of forces in it.
  const double h = impl_->last_substep;
  if (impl_->strain_limit && h > 0) {
    impl_->strain_limit->add_impulse_magnitudes(impulses_as_forces(cloth(), h) / h, tensions);
  }
  return tensions;
}

}  // namespace clothsim
