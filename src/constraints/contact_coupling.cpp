#include "clothsim/constraints/contact_coupling.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Opposite normals have at most this scalar product.
constexpr double opposite = -0.95;

/// Rounding of impulses on a frictionless surface, of the normal impulse.
constexpr double impulse_rounding = 1e-12;

/// Largest share, at most 1, of a change that leaves an impulse within Coulomb's cone.
double share_within_cone(const ContactImpulse& impulse, const Vector3& change) {
  const double along = impulse.normal.dot(change);
  const Vector3 across = change - along * impulse.normal;
  const Vector3& f = impulse.friction_impulse;
  const double n = impulse.normal_impulse, slope = impulse.friction + impulse_rounding;
  // |f + s across|^2 = slope^2 (n + s along)^2
  const double a = across.squaredNorm() - slope * slope * along * along;
  const double b = f.dot(across) - slope * slope * n * along;
  const double c = std::min(0.0, f.squaredNorm() - slope * slope * n * n);
  if (n + along >= 0 && a + 2 * b + c <= 0) return 1;
  // The positive root, by the formula that cancels no digits.
  const double root = std::sqrt(std::max(0.0, b * b - a * c));
  double share = 0;
  if (b < 0) {
    share = a > 0 ? (root - b) / a : 1;
  } else if (b + root > 0) {
    share = -c / (b + root);
  }
  return std::clamp(along < 0 ? std::min(share, -n / along) : share, 0.0, 1.0);
}

void add(const Vector3& change, ContactImpulse& impulse) {
  const double along = impulse.normal.dot(change);
  impulse.normal_impulse = std::max(0.0, impulse.normal_impulse + along);
  impulse.friction_impulse += change - along * impulse.normal;
}

/// Adds to a normal impulse, which ends at 0 or above; friction shrinks with it. Returns the change
/// of the impulse.
Vector3 add_normal(double more, ContactImpulse& impulse) {
  const Vector3 last = impulse.total();
  const double last_normal = impulse.normal_impulse;
  impulse.normal_impulse = std::max(0.0, last_normal + more);
  if (more < 0 && last_normal > 0) {
    impulse.friction_impulse *= impulse.normal_impulse / last_normal;
  }
  return impulse.total() - last;
}

/// Does a contact slide in its own update, with this relative velocity [m/s] and effective mass?
bool slides(const ContactImpulse& impulse, const Vector3& velocity, double mass) {
  const Vector3 along = velocity - impulse.normal.dot(velocity) * impulse.normal;
  return (impulse.friction_impulse - mass * along).norm() >
         impulse.friction * impulse.normal_impulse;
}

}  // namespace

bool are_opposite(const Vector3& normal_a, const Vector3& normal_b) {
  return normal_a.dot(normal_b) <= opposite;
}

double ContactCoupling::update(RigidMotion& a, RigidMotion& b) {
  return std::max(stop_sliding(a, b), stop_approach(a, b));
}

/// Gives a corner impulses [N s] of both colliders, and them the opposite ones.
void ContactCoupling::give(Corner& c, const Vector3& from_a, const Vector3& from_b, RigidMotion& a,
                           RigidMotion& b) {
  c.velocity += (from_a + from_b) / c.mass;
  a.give(-from_a, x);
  b.give(-from_b, c.x);
}

/// Opposite impulses against sliding of one surface on the other, as much as both bear, where the
/// cloth sticks to both.
double ContactCoupling::stop_sliding(RigidMotion& a, RigidMotion& b) {
  Vector3 velocity(0, 0, 0);  // of the place
  double inv_effective_mass = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Corner& c = corners[k];
    velocity += c.weight * c.velocity;
    inv_effective_mass += c.weight * c.weight / c.mass;
    if (slides(c.of_b, c.velocity - b.velocity_at(c.x), 1)) return 0;
  }
  if (slides(of_a, velocity - a.velocity_at(x), 1 / inv_effective_mass)) return 0;

  Vector3 normal = -of_a.normal;
  for (std::size_t k = 0; k < count; ++k) normal += corners[k].weight * corners[k].of_b.normal;
  normal.normalize();
  const Vector3 v = a.velocity_at(x) - b.velocity_at(x);
  const Vector3 sliding = v - normal.dot(v) * normal;
  const double inv_mass = a.inv_mass_across(x, normal) + b.inv_mass_across(x, normal);
  if (inv_mass == 0) return 0;
  const Vector3 stop = sliding / inv_mass;
  double share = share_within_cone(of_a, stop);
  for (std::size_t k = 0; k < count; ++k) {
    const Corner& c = corners[k];
    share = std::min(share, share_within_cone(c.of_b, -c.weight / c.mass * stop));
  }
  add(share * stop, of_a);
  for (std::size_t k = 0; k < count; ++k) {
    Corner& c = corners[k];
    add(-share * c.weight / c.mass * stop, c.of_b);
    give(c, share * c.weight * stop, -share * c.weight * stop, a, b);
  }
  return share * sliding.norm();
}

/// The normal impulse of the body and those of the other collider by the same amount.
double ContactCoupling::stop_approach(RigidMotion& a, RigidMotion& b) {
  double lacking = of_a.target_velocity + of_a.normal.dot(a.velocity_at(x));
  double inv_effective_mass = a.inv_mass_at(x, of_a.normal) + b.inv_mass_at(x, of_a.normal);
  double least = -of_a.normal_impulse;
  for (std::size_t k = 0; k < count; ++k) {
    const Corner& c = corners[k];
    const Vector3& normal = c.of_b.normal;
    lacking += c.weight * (c.of_b.target_velocity + normal.dot(b.velocity_at(c.x)) -
                           (of_a.normal + normal).dot(c.velocity));
    inv_effective_mass += c.weight * c.weight / c.mass * (of_a.normal + normal).squaredNorm();
    least = std::max(least, -c.of_b.normal_impulse * c.mass / c.weight);
  }
  if (inv_effective_mass == 0) return 0;  // no joint is free along the normals
  const double most = strongest - of_a.normal_impulse;
  const double more = std::max(std::min(lacking / inv_effective_mass, most), least);
  if (more >= 0 || !release(-more, a, b)) {
    const Vector3 of_body = add_normal(more, of_a);
    for (std::size_t k = 0; k < count; ++k) {
      Corner& c = corners[k];
      const Vector3 of_other = c.mass * add_normal(more * c.weight / c.mass, c.of_b);
      give(c, c.weight * of_body, of_other, a, b);
    }
  }
  return std::abs(more) * inv_effective_mass;
}

/// Takes `less` from the normal impulses; friction of the body shrinks with them, and that of the
/// other collider by as much, where it bears that. False where it does not.
bool ContactCoupling::release(double less, RigidMotion& a, RigidMotion& b) {
  if (of_a.normal_impulse == 0) return false;
  const Vector3 friction = -less / of_a.normal_impulse * of_a.friction_impulse;
  const auto change_of_b = [&](const Corner& c) {
    return Vector3(c.weight * (-less * c.of_b.normal - friction));
  };
  double share = 1;
  for (std::size_t k = 0; k < count; ++k) {
    const Corner& c = corners[k];
    if (c.of_b.friction_impulse.dot(of_a.friction_impulse) > 0) return false;  // both slide
    share = std::min(share, share_within_cone(c.of_b, change_of_b(c) / c.mass));
  }
  if (share == 0) return false;
  const Vector3 of_body = share * (friction - less * of_a.normal);
  add(of_body, of_a);
  for (std::size_t k = 0; k < count; ++k) {
    Corner& c = corners[k];
    const Vector3 of_other = share * change_of_b(c);
    add(of_other / c.mass, c.of_b);
    give(c, c.weight * of_body, of_other, a, b);
  }
  return true;
}

}  // namespace clothsim
