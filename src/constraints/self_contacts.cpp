#include "clothsim/constraints/self_contacts.h"

namespace clothsim {

void SelfContacts::prepare(const Cloth& cloth, const ContactStep& step, State& state) {
  h_ = step.h;
  weight_ = cloth.mass.sum() * step.gravity * h_;
  contacts_.start_over(h_);
  finder_.find(cloth, step, state, contacts_);
  contacts_.warm_start(state.positions, state.velocities, step.workers);
}

void SelfContacts::refresh(const Cloth& cloth, const ContactStep& step, State& state) {
  finder_.refresh(cloth, step, state, contacts_);
  contacts_.warm_start_again(state.velocities);
}

/// Colliders alone move pinched points. The impulse on contacts that are pinched in part is
/// bounded: their other points would have to leap to keep their distance.
void SelfContacts::release_pinched(const Pinches& pinches, Points& velocities) {
  contacts_.release_pinched(pinches, Pinches::max_overlap_impulse * weight_, velocities);
}

double SelfContacts::solve_pass(double tolerance, Points& velocities, const Workers& workers) {
  return h_ * contacts_.solve_pass(tolerance / h_, velocities, workers);
}

void SelfContacts::add_impulses(Points& sum) const {
  for (const Contact& c : contacts_.contacts()) {
    const Vector3 impulse = c.impulse.total();
    for (std::size_t k = 0; k < 4; ++k) {
      sum.row(c.points[k]) += c.weights[k] * impulse.transpose();
    }
  }
}

void SelfContacts::for_each_touch(const std::function<void(const SelfTouch&)>& visit) const {
  for (const Contact& c : contacts_.contacts()) {
    visit({c.points, c.weights, c.impulse.normal, c.nearest});
  }
}

void SelfContacts::reset() {
  contacts_.reset();
  restart_detection();
}

void SelfContacts::write(MemoryWriter& memory) const {
  finder_.write(memory);
  contacts_.write(memory);
}

void SelfContacts::read(MemoryReader& memory) {
  finder_.read(memory);
  contacts_.read(memory);
}

std::optional<SelfContacts> make_self_contacts(const Cloth& cloth) {
  const SelfCollision kind = cloth.self_collision;
  if (kind == SelfCollision::points || kind == SelfCollision::surface) {
    return SelfContacts(cloth, kind);
  }
  return std::nullopt;
}

}  // namespace clothsim
