#include "clothsim/collision/pinches.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Cosine of the angle between normals from which on surfaces face each other: out of a wider wedge
/// impulses push sideways.
constexpr double facing = -0.5;

/// Force that holds a point along the colliders, of the mass of the whole cloth [m/s^2]: three of
/// its weights, as friction of a gripper that may lift it by one point and shake it.
constexpr double strongest_grip = 3 * 9.81;

/// Least velocity along `across` that a contact asks for, where its surface moves at `surface`.
double least_rate(const ContactImpulse& contact, const Vector3& surface, const Vector3& across) {
  return contact.slowest + across.dot(surface);
}

Vector3 direction_across(const ContactImpulse& a, const ContactImpulse& b) {
  return (a.normal - b.normal).normalized();
}

/// Is the wedge between them so narrow that friction keeps what it presses on from slipping out? It
/// is where its angle is below the sum of both angles of friction, the arctangents of both
/// coefficients.
bool jams(const ContactImpulse& a, const ContactImpulse& b) {
  const double cos_wedge = -a.normal.dot(b.normal);
  const double m = a.friction, n = b.friction;
  return cos_wedge * std::sqrt((1 + m * m) * (1 + n * n)) > 1 - m * n;
}

}  // namespace

void Pinches::start_over(double h) {
  h_ = h;
  pinches_.clear();
  held_.clear();
}

bool Pinches::leave_no_room(const ContactImpulse& a, const ContactImpulse& b) {
  if (a.normal.dot(b.normal) > facing) return false;
  const Vector3 across = direction_across(a, b);
  return least_rate(a, a.surface_velocity, across) + least_rate(b, b.surface_velocity, -across) >=
         0;
}

void Pinches::add(int point, const Vector3& x, const Side& a, const Side& b, const Cloth& cloth) {
  if (cloth.inv_mass[point] == 0 || holds(point)) return;
  if (held_.empty()) held_.assign(static_cast<std::size_t>(cloth.num_points()), 0);
  held_[static_cast<std::size_t>(point)] = 1;

  const Vector3 across = direction_across(a.contact, b.contact);
  const Vector3 of_a = a.collider.velocity_at(x), of_b = b.collider.velocity_at(x);
  const double rate =
      (least_rate(a.contact, of_a, across) - least_rate(b.contact, of_b, -across)) / 2;
  const bool sticks = jams(a.contact, b.contact);
  const double share = sticks ? a.contact.friction / (a.contact.friction + b.contact.friction) : 0;
  const Vector3 along = share * of_a + (1 - share) * of_b;
  const double grip = sticks ? strongest_grip * cloth.mass.sum() * cloth.inv_mass[point] * h_ : 0;
  pinches_.push_back(
      {point, along + (rate - across.dot(along)) * across, across, grip, Vector3::Zero(), !sticks});
}

double Pinches::sweep(Points& velocities) {
  double largest2 = 0;
  for (Pinch& p : pinches_) {
    const Vector3 wanted = p.given + p.velocity - row(velocities, p.point);
    const Vector3 across = p.across.dot(wanted) * p.across;
    Vector3 along = wanted - across;
    const double strength = along.norm();
    p.slips = p.grip == 0 || strength > p.grip;
    if (strength > p.grip) along *= p.grip / strength;
    const Vector3 change = across + along - p.given;
    p.given += change;
    velocities.row(p.point) += change.transpose();
    largest2 = std::max(largest2, change.squaredNorm());
  }
  return std::sqrt(largest2);
}

void Pinches::correct(const Points& start, Points& positions) const {
  for (const Pinch& p : pinches_) {
    Vector3 back = row(start, p.point) + h_ * p.velocity - row(positions, p.point);
    if (p.slips) back = p.across.dot(back) * p.across;
    positions.row(p.point) += back.transpose();
  }
}

}  // namespace clothsim
