#include "clothsim/constraints/pinches.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Cosine of the angle between normals from which on surfaces face each other: out of a wider wedge
/// impulses push sideways.
constexpr double facing = -0.5;

/// Force that holds all points between two colliders along them, of the weight of the whole cloth:
/// as friction of a gripper that may lift it by one point and shake it. With as much for each, a
/// cloth held by its pins too shook at up to 0.3 m/s.
constexpr double strongest_grip = 3;

/// Points that would go to the middle no faster than this stay where they are [m/s]: layers that
/// all had to go there would have to pass through each other.
constexpr double least_draw = 0.2;

/// Least velocity along `across` that a contact asks for, where its surface moves at `surface`.
double least_rate(const ContactImpulse& contact, const Vector3& surface, const Vector3& across) {
  return contact.slowest + across.dot(surface);
}

Vector3 direction_across(const ContactImpulse& a, const ContactImpulse& b) {
  return (a.normal - b.normal).normalized();
}

/// Is the wedge between them so narrow that friction keeps what it presses on from slipping out? It
/// is where its angle is below the sum of both angles of friction, the arctangents of both
/// coefficients. Without friction nothing sticks, whatever roundings make of the normals.
bool jams(const ContactImpulse& a, const ContactImpulse& b) {
  const double cos_wedge = -a.normal.dot(b.normal);
  const double m = a.friction, n = b.friction;
  if (m + n == 0) return false;
  return cos_wedge * std::sqrt((1 + m * m) * (1 + n * n)) > 1 - m * n;
}

}  // namespace

void Pinches::start_over(double h, double gravity) {
  h_ = h;
  gravity_ = gravity;
  pinches_.clear();
  jaws_.clear();
  held_.clear();
}

std::size_t Pinches::jaws_of(const MovingCollider& a, const MovingCollider& b) {
  const auto known = std::find_if(jaws_.begin(), jaws_.end(), [&](const Jaws& jaws) {
    return (jaws.a == &a && jaws.b == &b) || (jaws.a == &b && jaws.b == &a);
  });
  if (known != jaws_.end()) return static_cast<std::size_t>(known - jaws_.begin());
  jaws_.push_back({&a, &b, 0});
  return jaws_.size() - 1;
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
  const double still = across.dot(of_a + of_b) / 2;
  const double centred =
      (least_rate(a.contact, of_a, across) - least_rate(b.contact, of_b, -across)) / 2;
  const double rate = std::clamp(still, centred - least_draw, centred + least_draw);
  const bool sticks = jams(a.contact, b.contact);
  const double share = sticks ? a.contact.friction / (a.contact.friction + b.contact.friction) : 0;
  const Vector3 along = share * of_a + (1 - share) * of_b;
  const double weight = cloth.mass.sum() * gravity_;
  const double grip = sticks ? strongest_grip * weight * cloth.inv_mass[point] * h_ : 0;
  const std::size_t jaws = jaws_of(a.collider, b.collider);
  if (sticks) ++jaws_[jaws].points;
  pinches_.push_back({point, along + (rate - across.dot(along)) * across, across, grip, jaws,
                      Vector3::Zero(), !sticks});
}

double Pinches::sweep(Points& velocities) {
  double largest2 = 0;
  for (Pinch& p : pinches_) {
    const Vector3 wanted = p.given + p.velocity - row(velocities, p.point);
    const Vector3 across = p.across.dot(wanted) * p.across;
    Vector3 along = wanted - across;
    const double strength = along.norm(),
                 strongest = p.grip > 0 ? p.grip / jaws_[p.jaws].points : 0;
    p.slips = strongest == 0 || strength > strongest;
    if (strength > strongest) along *= strongest / strength;
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

void Pinches::write(MemoryWriter& memory) const {
  memory.add(static_cast<double>(std::count(held_.begin(), held_.end(), 1)));
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (held_[i] != 0) memory.add(static_cast<double>(i));
  }
}

void Pinches::read(MemoryReader& memory, const Cloth& cloth) {
  start_over(0);
  const auto points = static_cast<std::size_t>(cloth.num_points());
  const std::size_t count = memory.count();
  if (count > 0) held_.assign(points, 0);
  for (std::size_t k = 0; k < count; ++k) held_[static_cast<std::size_t>(memory.index(points))] = 1;
}

}  // namespace clothsim
