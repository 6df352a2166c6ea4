#include "clothsim/constraints/body_contacts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/local_cloth.h"

namespace clothsim {
namespace {

/// Contacts keep their impulse where their place on the body has moved by at most this share of its
/// bounding radius.
constexpr double same_place = 0.1;

/// Passes over the overlaps of a step.
enum { push_passes = 4 };

double inv_mass(const BodyTouch& t, const RigidBodies& bodies) {
  return bodies.motion(t.a).inv_mass_at(t.place, t.normal) +
         bodies.motion(t.b).inv_mass_at(t.place, t.normal);
}

/// The effective mass, or 0 where nothing can move: then no friction acts.
double mass_or_zero(double inv_mass) { return inv_mass > 0 ? 1 / inv_mass : 0; }

double inv_mass_across(const BodyTouch& t, const RigidBodies& bodies) {
  return bodies.motion(t.a).inv_mass_across(t.place, t.normal) +
         bodies.motion(t.b).inv_mass_across(t.place, t.normal);
}

}  // namespace

struct BodyContacts::Setup {
  Setup(const std::vector<ColliderSpec>& specs, const RigidBodies& bodies);

  bool may_touch(std::size_t a, std::size_t b) const { return joined.count({a, b}) == 0; }

  BodyCollisions collisions;
  std::set<std::pair<std::size_t, std::size_t>> joined;  // pairs of colliders without contact

 private:
  static std::vector<MovingCollider> at_start(const std::vector<ColliderSpec>& specs) {
    std::vector<MovingCollider> colliders(specs.begin(), specs.end());
    for (MovingCollider& collider : colliders) collider.enable(true);
    return colliders;
  }
  static std::vector<char> are_bodies(const std::vector<ColliderSpec>& specs,
                                      const RigidBodies& bodies) {
    std::vector<char> result;
    for (std::size_t k = 0; k < specs.size(); ++k) result.push_back(bodies.leads(bodies.leader(k)));
    return result;
  }
};

BodyContacts::Setup::Setup(const std::vector<ColliderSpec>& specs, const RigidBodies& bodies)
    : collisions(at_start(specs), are_bodies(specs, bodies)) {
  const auto by_joint = [&](std::size_t a, std::size_t b) {
    return !bodies.are_of_one(a, b) && (bodies.has_joint(a) || bodies.has_joint(b));
  };
  for (const BodyTouch& t : collisions.find(at_start(specs), -penetration_slop, by_joint)) {
    joined.insert({t.a, t.b});
  }
}

Vector3 BodyContacts::relative_velocity(const BodyTouch& t, const RigidBodies& bodies) {
  return bodies.motion(t.a).velocity_at(t.place) - bodies.motion(t.b).velocity_at(t.place);
}

void BodyContacts::give(const BodyTouch& t, const Vector3& impulse, RigidBodies& bodies) {
  bodies.motion(t.a).give(impulse, t.place);
  bodies.motion(t.b).give(-impulse, t.place);
}

void BodyContacts::give(const LimitContact& c, double impulse, RigidBodies& bodies) {
  const Wrench& direction = c.limit.direction;
  bodies.motion(c.body).give({impulse * direction.force, impulse * direction.torque});
}

void BodyContacts::prepare(double h, double gravity, const std::vector<ColliderSpec>& specs,
                           const std::vector<MovingCollider>& colliders,
                           const FindPlaces& find_places, RigidBodies& bodies) {
  if (!setup_) setup_ = std::make_shared<Setup>(specs, bodies);
  const double scale = h_ > 0 ? h / h_ : 0;
  h_ = h;
  prepare_contacts(scale, gravity, colliders, find_places, bodies);
  prepare_limits(scale, bodies);
}

std::vector<BodyTouch> BodyContacts::find(const std::vector<MovingCollider>& colliders,
                                          const FindPlaces& find_places,
                                          const RigidBodies& bodies) const {
  const auto may_touch = [&](std::size_t a, std::size_t b) {
    return (bodies.is_body(a) || bodies.is_body(b)) && !bodies.are_of_one(a, b) &&
           setup_->may_touch(a, b);
  };
  const double reach = bodies.longest_displacement(h_) + penetration_slop;
  std::vector<BodyTouch> touches = setup_->collisions.find(colliders, reach, may_touch);
  for (const BodyTouch& t : find_places(reach)) {
    if (may_touch(t.a, t.b)) touches.push_back(t);
  }
  return touches;
}

void BodyContacts::prepare_contacts(double scale, double gravity,
                                    const std::vector<MovingCollider>& colliders,
                                    const FindPlaces& find_places, RigidBodies& bodies) {
  last_.swap(contacts_);
  contacts_.clear();
  const std::vector<BodyTouch> touches = find(colliders, find_places, bodies);
  const auto pair = [](const BodyTouch& t) {
    return std::pair(std::min(t.a, t.b), std::max(t.a, t.b));
  };
  std::map<std::pair<std::size_t, std::size_t>, int> places;
  for (const BodyTouch& t : touches) {
    bodies.touch(t.a, t.b);
    ++places[pair(t)];
  }
  for (const BodyTouch& t : touches) {
    const double inv_effective_mass = inv_mass(t, bodies);
    if (inv_effective_mass == 0) continue;  // no joint is free along the normal
    PairContact c{t, to_local(colliders[t.a].pose(), t.place),
                  t.normal.dot(relative_velocity(t, bodies)), 1 / inv_effective_mass,
                  mass_or_zero(inv_mass_across(t, bodies))};
    c.impulse.normal = t.normal;
    c.impulse.friction =
        t.friction.value_or(std::sqrt(colliders[t.a].friction() * colliders[t.b].friction()));
    c.impulse.max_normal_impulse = bodies.strongest_force(t.a, t.b, places[pair(t)], gravity) * h_ +
                                   2 * c.mass * std::max(0.0, -c.approach);
    // The gap where impulses act.
    c.impulse.target_velocity =
        -std::max(0.0, t.gap - RigidBodies::displacement_factor * h_ * c.approach) / h_;
    contacts_.push_back(c);
  }
  for (PairContact& c : contacts_) {  // once all motions are known that are free
    warm_start(scale, bounding_radius(colliders[c.touch.a].shape()), c);
    give(c.touch, c.impulse.total(), bodies);
  }
}

void BodyContacts::prepare_limits(double scale, RigidBodies& bodies) {
  const std::vector<LimitContact> last = std::move(limits_);
  limits_.clear();
  for (std::size_t k = 0; k < bodies.count(); ++k) {
    if (!bodies.leads(k)) continue;
    for (const RigidBodies::JointLimit& limit : bodies.joint_limits(k)) {
      LimitContact c{k, limit, -std::max(0.0, limit.gap) / h_};
      const std::size_t i = limits_.size();
      if (i < last.size()) c.impulse = scale * last[i].impulse;
      give(c, c.impulse, bodies);
      limits_.push_back(c);
    }
  }
}

/// Takes the impulse of the nearest contact of the last step, which then has none.
void BodyContacts::warm_start(double scale, double radius, PairContact& c) {
  PairContact* nearest = nullptr;
  double least = same_place * radius;
  for (PairContact& other : last_) {
    if (other.touch.a != c.touch.a || other.touch.b != c.touch.b) continue;
    const double distance = (other.local - c.local).norm();
    if (distance >= least || other.impulse.normal_impulse == 0) continue;
    nearest = &other;
    least = distance;
  }
  if (!nearest) return;
  c.impulse.keep(nearest->impulse);
  c.impulse.warm_start(scale);
  c.impulse.limit_normal_impulse(c.impulse.max_normal_impulse);
  nearest->impulse.deactivate();
}

double BodyContacts::solve_pass(RigidBodies& bodies) {
  double largest = 0;
  for (PairContact& c : contacts_) {
    const Vector3 change =
        c.impulse.update(relative_velocity(c.touch, bodies), c.mass, c.tangential_mass);
    if (change.isZero(0)) continue;
    give(c.touch, change, bodies);
    largest =
        std::max(largest, change.norm() /
                              std::min(c.mass, c.tangential_mass > 0 ? c.tangential_mass : c.mass));
  }
  for (LimitContact& c : limits_) {
    const RigidMotion& motion = bodies.motion(c.body);
    const double rate = c.limit.direction.force.dot(motion.velocity) +
                        c.limit.direction.torque.dot(motion.angular_velocity);
    const double change = std::max(c.limit.mass * (c.min_rate - rate), -c.impulse);
    if (change == 0) continue;
    c.impulse += change;
    give(c, change, bodies);
    largest = std::max(largest, std::abs(change) / c.limit.mass);
  }
  return largest;
}

std::vector<RigidMotion> BodyContacts::pushes(const RigidBodies& bodies,
                                              const std::vector<Overlap>& further) const {
  std::vector<Overlap> overlaps = further;
  for (const PairContact& c : contacts_) {
    const BodyTouch& t = c.touch;
    const double parting = t.normal.dot(relative_velocity(t, bodies)) - c.approach;
    const double gap = t.gap + RigidBodies::displacement_factor * h_ * parting;
    if (gap < 0) overlaps.push_back({t.a, t.b, t.place, t.normal, -gap});
  }
  if (overlaps.empty()) return {};
  std::vector<RigidMotion> motions;
  for (std::size_t k = 0; k < bodies.count(); ++k) {
    motions.push_back(bodies.motion(k));
    motions.back().velocity.setZero();
    motions.back().angular_velocity.setZero();
  }
  std::vector<double> impulses(overlaps.size(), 0);
  for (int pass = 0; pass < push_passes; ++pass) {
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
      const Overlap& o = overlaps[i];
      RigidMotion &a = motions[bodies.leader(o.a)], &b = motions[bodies.leader(o.b)];
      const double wanted = std::min(overlap_share * o.depth, recovery_speed * h_) -
                            o.normal.dot(a.velocity_at(o.place) - b.velocity_at(o.place));
      const double inv_mass = a.inv_mass_at(o.place, o.normal) + b.inv_mass_at(o.place, o.normal);
      if (inv_mass == 0) continue;
      const double impulse = std::max(0.0, impulses[i] + wanted / inv_mass);
      a.give((impulse - impulses[i]) * o.normal, o.place);
      b.give((impulses[i] - impulse) * o.normal, o.place);
      impulses[i] = impulse;
    }
  }
  return motions;
}

void BodyContacts::reset() {
  contacts_.clear();
  limits_.clear();
  h_ = 0;
}

void BodyContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  const auto is_held = [](const PairContact& c) { return c.impulse.normal_impulse > 0; };
  memory.add(static_cast<double>(std::count_if(contacts_.begin(), contacts_.end(), is_held)));
  for (const PairContact& c : contacts_) {
    if (!is_held(c)) continue;
    memory.add(static_cast<double>(c.touch.a));
    memory.add(static_cast<double>(c.touch.b));
    memory.add(c.local);
    c.impulse.write(memory);
  }
  memory.add(static_cast<double>(limits_.size()));
  for (const LimitContact& c : limits_) memory.add(c.impulse);
}

void BodyContacts::read(MemoryReader& memory, std::size_t colliders) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    PairContact c{};
    c.touch.a = static_cast<std::size_t>(memory.index(colliders));
    c.touch.b = static_cast<std::size_t>(memory.index(colliders));
    c.local = memory.vector();
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
  for (std::size_t left = memory.count(); left > 0; --left) {
    limits_.push_back({0, {}, 0, std::max(0.0, memory.number())});
  }
}

}  // namespace clothsim
