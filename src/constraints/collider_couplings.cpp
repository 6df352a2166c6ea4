// Contact of points with rigid bodies, and of points between a body and another collider.

#include <algorithm>
#include <map>
#include <utility>

#include "clothsim/constraints/collider_contacts.h"

namespace clothsim {
namespace {

/// A body stands on so many points.
enum { standing_points = 3 };

}  // namespace

double ContactSlots::solve_pass(double friction, const Cloth& cloth, const Points& positions,
                                RigidMotion& body, Points& velocities) {
  double largest = 0;
  for (const int b : active_) {
    for (int i = first_of(b); i < end_of(b); ++i) {
      if (!touches(i)) continue;
      const Vector3 x = row(positions, i), v = row(velocities, i);
      ContactImpulse c = contact(i, friction);
      c.surface_velocity = body.velocity_at(x);
      // Impulses are those on 1 kg of the cloth.
      const double mass = 1 / (1 + cloth.mass[i] * body.inv_mass_at(x, c.normal));
      const double tangential_mass = 1 / (1 + cloth.mass[i] * body.inv_mass_across(x, c.normal));
      const Vector3 change = c.update(v, mass, tangential_mass);
      if (change.isZero(0)) continue;
      velocities.row(i) += change.transpose();
      body.give(-cloth.mass[i] * change, x);
      set_impulse(i, c);
      largest = std::max(largest, change.norm() / std::min(mass, tangential_mass));
    }
  }
  return largest;
}

void ColliderContacts::couple(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                              const ContactStep& step, const Points& positions) {
  const RigidBodies& bodies = *step.bodies;
  coupled_.clear();
  for (std::size_t a = 0; a < caches_.size(); ++a) {
    if (!bodies.is_body(a) || !colliders[a].enabled()) continue;
    for (std::size_t b = 0; b < caches_.size(); ++b) {
      if (bodies.are_of_one(a, b) || !colliders[b].enabled() || caches_[b].near.empty()) continue;
      const std::size_t before = coupled_.size();
      if (!caches_[a].near.empty()) couple_points(a, b);
      // Faces at the rim of a body that stands on points carry little, and would slow the solution.
      const bool stands = coupled_.size() >= before + standing_points;
      if (bodies.is_body(b) && b > a) coupled_.resize(before);  // those of b and a
      if (caches_[a].has_faces && !stands) couple_faces(a, b, cloth);
    }
  }
  bound_coupled(step, positions);
}

void ColliderContacts::leave_out_passing(ColliderCache& s, const MovingCollider& collider,
                                         const Cloth& cloth, const ContactStep& step,
                                         const State& state) {
  for (const int b : s.slots.active()) {
    for (int i = ContactSlots::first_of(b); i < ContactSlots::end_of(b, cloth); ++i) {
      if (!s.slots.touches(i) || s.slots.has_impulse(i)) continue;
      const Vector3 x = row(state.positions, i);
      const Vector3 displacement = step.h * (row(state.velocities, i) - collider.velocity_at(x));
      const Vector3 end = to_local(collider.pose(), x + displacement);
      const double keeps = s.keeps - cloth.nearer_by(i);
      if (signed_distance(collider.shape(), end, end).value >= keeps - passing_depth) {
        s.slots.remove(i);
      }
    }
  }
}

void ColliderContacts::couple_points(std::size_t a, std::size_t b) {
  const ContactSlots &of_a = caches_[a].slots, &of_b = caches_[b].slots;
  of_a.for_each_touching_both(of_b, [&](int i) {
    if (!are_opposite(of_a.normal(i), of_b.normal(i))) return;
    coupled_.push_back({a, b, i});
    caches_[a].slots.forbid_recovery(i);
    caches_[b].slots.forbid_recovery(i);
  });
}

void ColliderContacts::couple_faces(std::size_t a, std::size_t b, const Cloth& cloth) {
  const ContactSlots& of_b = caches_[b].slots;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    if (faces_.collider(i) != static_cast<int>(a)) continue;
    const Contact& contact = faces_.contact(i);
    bool touches = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const int point = contact.points[k];
      if (contact.weights[k] == 0) continue;
      touches = touches && cloth.inv_mass[point] > 0 && of_b.touches(point) &&
                are_opposite(contact.impulse.normal, of_b.normal(point));
    }
    if (!touches) continue;
    coupled_.push_back({a, b, -1, i});
    faces_.forbid_recovery(i);
    for (std::size_t k = 0; k < 3; ++k) {
      if (contact.weights[k] != 0) caches_[b].slots.forbid_recovery(contact.points[k]);
    }
  }
}

void ColliderContacts::bound_coupled(const ContactStep& step, const Points& positions) {
  RigidBodies& bodies = *step.bodies;
  for (const Coupled& c : coupled_) bodies.touch(c.a, c.b);
  const auto pair = [](const Coupled& c) {
    return std::pair(std::min(c.a, c.b), std::max(c.a, c.b));
  };
  std::map<std::pair<std::size_t, std::size_t>, int> places;
  for (const Coupled& c : coupled_) ++places[pair(c)];
  for (Coupled& c : coupled_) {
    const Vector3 x = c.point < 0 ? faces_.place(c.face) : row(positions, c.point);
    const Vector3 normal =
        c.point < 0 ? faces_.contact(c.face).impulse.normal : caches_[c.a].slots.normal(c.point);
    const RigidMotion &a = bodies.motion(c.a), &b = bodies.motion(c.b);
    const double approach = std::max(0.0, normal.dot(a.velocity_at(x) - b.velocity_at(x)));
    const double inv_mass = a.inv_mass_at(x, normal) + b.inv_mass_at(x, normal);
    const double at_rest = bodies.strongest_force(c.a, c.b, places[pair(c)], step.gravity) * step.h;
    c.strongest = at_rest + (inv_mass > 0 ? 2 * approach / inv_mass : 0);
  }
}

double ColliderContacts::solve_coupled(const Cloth& cloth, const Points& positions,
                                       RigidBodies& bodies, Points& velocities) {
  double largest = 0;
  for (const Coupled& c : coupled_) {
    largest = std::max(largest, solve_coupled(c, cloth, positions, bodies, velocities));
  }
  return largest;
}

double ColliderContacts::solve_coupled(const Coupled& c, const Cloth& cloth,
                                       const Points& positions, RigidBodies& bodies,
                                       Points& velocities) {
  ContactSlots &slots_a = caches_[c.a].slots, &slots_b = caches_[c.b].slots;
  ContactCoupling coupling;
  std::array<int, 3> points{c.point, 0, 0};
  const auto add = [&](int point, double weight) {
    points[coupling.count] = point;
    coupling.corners[coupling.count++] = {weight, cloth.mass[point], row(positions, point),
                                          slots_b.contact(point, caches_[c.b].friction),
                                          row(velocities, point)};
  };
  if (c.point >= 0) {
    add(c.point, 1);
    coupling.x = row(positions, c.point);
    coupling.of_a = slots_a.contact(c.point, caches_[c.a].friction).scaled(cloth.mass[c.point]);
  } else {
    const Contact& contact = faces_.contact(c.face);
    for (std::size_t k = 0; k < 3; ++k) {
      if (contact.weights[k] != 0) add(contact.points[k], contact.weights[k]);
    }
    coupling.x = faces_.place(c.face);
    coupling.of_a = contact.impulse;
  }
  coupling.strongest = c.strongest;
  const double change = coupling.update(bodies.motion(c.a), bodies.motion(c.b));
  for (std::size_t k = 0; k < coupling.count; ++k) {
    slots_b.set_impulse(points[k], coupling.corners[k].of_b);
    velocities.row(points[k]) = coupling.corners[k].velocity.transpose();
  }
  if (c.point >= 0) {
    slots_a.set_impulse(c.point, coupling.of_a.scaled(1 / cloth.mass[c.point]));
  } else {
    faces_.keep(c.face, coupling.of_a);
  }
  return change;
}

void ColliderContacts::follow_bodies(const std::vector<MovingCollider>& colliders,
                                     const RigidBodies& bodies, const Points& positions) {
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    if (!bodies.is_body(k) || !colliders[k].enabled()) continue;
    const double radius = farthest_from(colliders[k].pose().position, positions);
    caches_[k].moved += caches_[k].sleep_bounds.follow(colliders[k].pose(), radius);
  }
}

std::vector<Overlap> ColliderContacts::overlaps(const std::vector<MovingCollider>& colliders,
                                                const Cloth& cloth, const Points& positions) const {
  const auto distance = [&](std::size_t k, const Vector3& x) {
    const Vector3 local = to_local(colliders[k].pose(), x);
    return signed_distance(colliders[k].shape(), local, local).value;
  };
  std::vector<Overlap> result;
  for (const Coupled& c : coupled_) {
    Contact place;
    if (c.point < 0) {
      place = faces_.contact(c.face);
    } else {
      place.points.fill(c.point);
      place.weights = {1, 0, 0, 0};
      place.nearest = caches_[c.a].keeps - cloth.nearer_by(c.point);
      place.impulse.normal = caches_[c.a].slots.normal(c.point);
    }
    const Vector3 x = weighted_sum(place.points, place.weights, positions);
    double gap = distance(c.a, x) - place.nearest;
    Vector3 normal = -place.impulse.normal;
    for (std::size_t k = 0; k < 3; ++k) {
      if (place.weights[k] == 0) continue;
      const int point = place.points[k];
      const double keeps = caches_[c.b].keeps - cloth.nearer_by(point);
      gap += place.weights[k] * (distance(c.b, row(positions, point)) - keeps);
      normal += place.weights[k] * caches_[c.b].slots.normal(point);
    }
    if (gap < 0) result.push_back({c.a, c.b, x, normal.normalized(), -gap});
  }
  return result;
}

}  // namespace clothsim
