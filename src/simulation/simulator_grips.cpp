// Points of the cloth that are attached to frames while it moves, and what it does to frames and
// colliders.

#include <utility>
#include <variant>

#include "clothsim/dynamics/drag.h"
#include "simulator_impl.h"

namespace clothsim {

namespace {

/// Constraints act at a substep's end, when drag has taken some of what forces gave in it. As
/// forces through the substep they would be that much larger.
double as_force(const Cloth& cloth, double h) { return h / Drag(cloth.damping, h).distance; }

}  // namespace

void Simulator::Impl::hold_pins(Cloth& cloth) {
  for (int i = 0; i < cloth.num_points(); ++i) cloth.inv_mass[i] = 1 / cloth.mass[i];
  for (const int pin : cloth.pinned) cloth.inv_mass[pin] = 0;
}

void Simulator::Impl::hold_points() {
  hold_pins(cloth);
  grips.hold(cloth);

  // Constraints weigh by inverse mass, and leave out pairs that are held on both sides.
  std::optional<StrainLimit> last_limit = std::move(strain_limit);
  build_strain_limit();
  if (last_limit && strain_limit) strain_limit->take_over(std::move(*last_limit));
  if (self_contacts) self_contacts->seek_anew();
  disturbed = true;
}

void Simulator::Impl::add_impulses(double h) {
  if (const Xpbd* solver = std::get_if<Xpbd>(&method->integrator)) {
    solver->add_reactions(cloth, h, impulses);  // as far as it solved
  } else {
    grips.add_spring_impulses(cloth, h, state, impulses);
  }
  const double scale = as_force(cloth, h);
  if (strain_limit) strain_limit->add_impulses(scale, impulses);
  if (self_contacts) self_contacts->add_impulses(scale, impulses);
}

void Simulator::Impl::finish_grips(double dt, const State& before) {
  grips.arrive(before, state);
  grips.weigh(cloth, scene.simulation.gravity, dt, impulses, before, state);
  const std::vector<int> torn = grips.torn();
  if (torn.empty()) return;
  grips.detach(torn);
  hold_points();
}

void Simulator::Impl::add_collider_impulses(double h) {
  collider_contacts.add_impulses(colliders, cloth, as_force(cloth, h), state.positions,
                                 collider_impulses);
}

void Simulator::Impl::finish_colliders(double dt) {
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    collider_wrenches[i].force = collider_impulses[i].force / dt;
    collider_wrenches[i].torque = collider_impulses[i].torque / dt;
  }
}

void Simulator::attach(const std::string& frame, const Pose& pose, const std::vector<int>& points,
                       std::optional<double> tear_force) {
  check_place(pose);
  impl_->grips.attach(frame, pose, points, tear_force, impl_->cloth, impl_->state.positions);
  impl_->hold_points();
}

void Simulator::detach(const std::vector<int>& points) {
  impl_->grips.detach(points);
  impl_->hold_points();
}

void Simulator::move_grip(const std::string& frame, const Pose& target) {
  check_place(target);
  impl_->grips.move(frame, target);
}

const std::map<std::string, Grip>& Simulator::grips() const { return impl_->grips.all(); }

void Simulator::weigh_colliders(bool asks) {
  impl_->weighs_colliders = asks;
  if (!asks) impl_->collider_wrenches.assign(impl_->colliders.size(), {});
}

bool Simulator::weighs_colliders() const { return impl_->weighs_colliders; }

const std::vector<Wrench>& Simulator::collider_wrenches() const { return impl_->collider_wrenches; }

}  // namespace clothsim
