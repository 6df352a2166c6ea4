#include "clothsim/dynamics/projective_dynamics.h"

#include <limits>

#include "clothsim/dynamics/anderson.h"
#include "clothsim/dynamics/cloth_watch.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/incremental_potential.h"
#include "clothsim/dynamics/spring_system.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {

struct ProjectiveDynamics::Impl {
  explicit Impl(const Parameters& p) : parameters(p), anderson(p.window) {}

  void factorize(const Cloth& cloth);
  void solve(const Cloth& cloth, const Points& y);

  Parameters parameters;
  ClothWatch watch;
  SpringSystem<1> system;
  bool factorized = false;
  Anderson anderson;
  Scalars weights;      // [N/m], N
  double small = 0;     // [m]
  Points displacement;  // [m], N x 3
  Points positions;     // [m]
  Points gradient;      // of the potential [N]
  Points change;        // by one iteration [m]
  Points plain;         // the last iterate without acceleration [m]
};

/// Inertia plus the springs' Laplacian.
void ProjectiveDynamics::Impl::factorize(const Cloth& cloth) {
  using Entry = SpringSystem<1>::Block;
  system.begin(cloth);
  for (int i = 0; i < cloth.num_points(); ++i) {
    system.add_to_point(i, Entry(cloth.inv_mass[i] > 0 ? weights[i] : 1.0));
  }
  int id = 0;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const Entry k(run.stiffness);
    const bool free_a = cloth.inv_mass[a] > 0;
    const bool free_b = cloth.inv_mass[b] > 0;
    if (free_a && free_b) {
      system.add_spring(id, a, b, k);
    } else if (free_a || free_b) {
      system.add_to_point(free_a ? a : b, k);
    }
    ++id;
  });
  factorized = system.factorize();
}

void ProjectiveDynamics::Impl::solve(const Cloth& cloth, const Points& y) {
  const int n = cloth.num_points();
  displacement.setZero(n, 3);
  if (cloth.springs.empty()) return;
  if (!factorized) {
    displacement.setConstant(std::numeric_limits<double>::quiet_NaN());
    return;
  }

  gradient.resize(n, 3);
  anderson.reset();
  double lowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < parameters.iterations; ++i) {
    // An accelerated iterate that raises the potential gives way to the plain one.
    if (parameters.window > 0) {
      const double potential = incremental_potential(cloth, weights, y, displacement);
      if (potential > lowest) {
        displacement = plain;
        anderson.reset();
        lowest = incremental_potential(cloth, weights, y, displacement);
      } else {
        lowest = potential;
      }
    }

    // Each spring alone, then all together.
    positions = y + displacement;
    potential_gradient(cloth, weights, positions, displacement, gradient);
    change = system.solve(-gradient);
    plain = displacement + change;
    if (!(change.cwiseAbs().maxCoeff() > small)) {
      displacement = plain;
      return;
    }
    if (parameters.window > 0) {
      anderson.next(change, displacement);
    } else {
      displacement = plain;
    }
  }
}

ProjectiveDynamics::ProjectiveDynamics() : ProjectiveDynamics(Parameters()) {}
ProjectiveDynamics::ProjectiveDynamics(const Parameters& parameters)
    : impl_(std::make_unique<Impl>(parameters)) {}
ProjectiveDynamics::~ProjectiveDynamics() = default;
ProjectiveDynamics::ProjectiveDynamics(ProjectiveDynamics&&) noexcept = default;
ProjectiveDynamics& ProjectiveDynamics::operator=(ProjectiveDynamics&&) noexcept = default;

void ProjectiveDynamics::step(const Cloth& cloth, const Loads& loads, double h, State& state,
                              const Workers&) {
  if (impl_->watch.changed(cloth, h)) {
    impl_->weights = coast_weights(cloth, h);
    impl_->small = impl_->parameters.tolerance * longest_rest_length(cloth);
    impl_->factorize(cloth);
  }

  coast(cloth, loads, h, state);
  impl_->solve(cloth, state.positions);
  state.positions += impl_->displacement;
  state.velocities += impl_->displacement / h;
}

}  // namespace clothsim
