#include "clothsim/constraints/self_contacts.h"

namespace clothsim {
namespace {

std::variant<PointFinder, SurfaceFinder> finder_of(const Cloth& cloth, SelfCollision kind) {
  if (kind == SelfCollision::surface) return SurfaceFinder(cloth);
  return PointFinder();
}

}  // namespace

SelfContacts::SelfContacts(const Cloth& cloth, SelfCollision kind)
    : finder_(finder_of(cloth, kind)) {}

void SelfContacts::begin(const Cloth& cloth, const ContactStep& step, State& state) {
  h_ = step.h;
  weight_ = cloth.mass.sum() * step.gravity * h_;
  contacts_.start_over(h_);
  std::visit([&](auto& finder) { finder.find(cloth, step, state, contacts_); }, finder_);
  contacts_.resume(state.positions, state.velocities);
}

/// Colliders alone move what they pinch. What is pinched in part, they push together: the rest
/// would have to leap to keep its distance.
void SelfContacts::leave_to(const Pinches& pinches, Points& velocities) {
  contacts_.leave_to(pinches, Pinches::beside * weight_, velocities);
}

double SelfContacts::sweep(double precision, Points& velocities, const Workers& workers) {
  return h_ * contacts_.sweep(precision / h_, velocities, workers);
}

void SelfContacts::correct(const Cloth& cloth, Points& positions) const {
  std::visit([&](const auto& finder) { finder.correct(cloth, positions); }, finder_);
}

int SelfContacts::guard(const Cloth& cloth, const ContactStep& step, const Points& by_impulses,
                        State& state) {
  return std::visit([&](auto& finder) { return finder.guard(cloth, step, by_impulses, state); },
                    finder_);
}

void SelfContacts::add_impulses(double scale, Points& sum) const {
  for (const Contact& c : contacts_.contacts()) {
    const Vector3 impulse = scale * c.impulse.total();
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

void SelfContacts::seek_anew() {
  std::visit([](auto& finder) { finder.seek_anew(); }, finder_);
}

void SelfContacts::reset() {
  contacts_.reset();
  seek_anew();
}

void SelfContacts::write(MemoryWriter& memory) const {
  std::visit([&](const auto& finder) { finder.write(memory); }, finder_);
  contacts_.write(memory);
}

void SelfContacts::read(MemoryReader& memory, const Cloth& cloth) {
  std::visit([&](auto& finder) { finder.read(memory, cloth); }, finder_);
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
