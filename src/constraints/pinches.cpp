#include "clothsim/constraints/pinches.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/model/compression.h"

namespace clothsim {
namespace {

/// From the place on collider a that is nearest to a point to the one on b: beside an edge the
/// normals also lead outwards. Where both nearly touch, along the normals.
Vector3 direction_across(const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b) {
  const Vector3 normals = a.normal - b.normal;
  const Vector3 places = a.distance * a.normal - b.distance * b.normal;
  const double length = places.norm();
  const bool is_apart =
      a.distance > 0 && b.distance > 0 && length > solid_share * (a.layer_height + b.layer_height);
  return is_apart ? Vector3(places / length) : normals.normalized();
}

/// Friction at a point on one side: that of the collider, or the least in a row of layers.
double friction_of(const Pinches::ColliderDistance& side, const Cloth& cloth) {
  const double of_collider = side.collider->friction();
  return side.touches ? of_collider : std::min(of_collider, cloth.friction);
}

/// Time in which a single layer comes into equilibrium between both [s].
constexpr double settling_time = 0.05;

/// Displacement in h [s] of a point towards its equilibrium, in the direction of b [m]: all layers
/// are compressed to the same share of their thickness.
double settling_way(const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b,
                    double h) {
  if (!a.touches || !b.touches) return 0;
  const double gap = a.distance + b.distance;
  const double place = gap * a.layer_height / (a.layer_height + b.layer_height);
  const double longest = recovery_speed * h;
  return std::clamp((place - a.distance) * std::min(1.0, h / settling_time), -longest, longest);
}

/// Friction of a collider on a point: on others than those of the outer layers it has none.
double acting_friction(const Pinches::ColliderDistance& side) {
  return side.touches ? side.collider->friction() : 0;
}

/// Is the wedge between them so narrow that friction keeps its content from slipping out? It is
/// where its angle is below the sum of both angles of friction, the arctangents of both
/// coefficients m and n. Without friction nothing sticks, whatever the rounding of the normals.
bool jams(const Vector3& normal_a, const Vector3& normal_b, double m, double n) {
  const double cos_wedge = -normal_a.dot(normal_b);
  if (m + n == 0) return false;
  return cos_wedge * std::sqrt((1 + m * m) * (1 + n * n)) > 1 - m * n;
}

/// Place of a point between both, from 0 at a to 1 at b; in the middle where they overlap.
double share_across(const Pinches::ColliderDistance& a, const Pinches::ColliderDistance& b) {
  const double gap = a.distance + b.distance;
  return gap > 0 ? std::clamp(a.distance / gap, 0.0, 1.0) : 0.5;
}

}  // namespace

void Pinches::start_over(double h, double gravity) {
  h_ = h;
  gravity_ = gravity;
  pinches_.clear();
  held_.clear();
}

bool Pinches::face_each_other(const Vector3& a, const Vector3& b) { return a.dot(b) <= -facing; }

double Pinches::room(const ColliderDistance& a, const ColliderDistance& b, const Vector3& x,
                     double h) {
  const Vector3 across = direction_across(a, b);
  const double opening = across.dot(b.collider->velocity_at(x) - a.collider->velocity_at(x));
  return (a.distance + b.distance + h * opening) / (a.layer_height + b.layer_height);
}

void Pinches::add(int point, const Vector3& x, const ColliderDistance& a, const ColliderDistance& b,
                  double area, const Cloth& cloth) {
  if (cloth.inv_mass[point] == 0 || holds(point)) return;
  if (held_.empty()) held_.assign(static_cast<std::size_t>(cloth.num_points()), 0);
  held_[static_cast<std::size_t>(point)] = 1;
  number_.resize(held_.size());
  number_[static_cast<std::size_t>(point)] = static_cast<int>(pinches_.size());

  const Vector3 across = direction_across(a, b);
  const Vector3 of_a = (a.collider->carried(x) - x) / h_, of_b = (b.collider->carried(x) - x) / h_;
  const double share = share_across(a, b);
  const double rate = across.dot((1 - share) * of_a + share * of_b);
  const double friction_a = acting_friction(a), friction_b = acting_friction(b);
  const double friction = friction_a + friction_b;
  const bool sticks =
      friction > 0 && jams(a.normal, b.normal, friction_of(a, cloth), friction_of(b, cloth));
  const double share_of_b = sticks ? friction_b / friction : 0.5;
  const Vector3 along = (1 - share_of_b) * of_a + share_of_b * of_b;
  const double pressure = compression_pressure(cloth.compression, room(a, b, x, h_));
  const double normal_impulse = h_ * area * pressure;
  const double max_friction = sticks ? friction * normal_impulse * cloth.inv_mass[point] : 0;
  pinches_.push_back({point, along + (rate - across.dot(along)) * across, across, a.collider,
                      b.collider, share_of_b, normal_impulse, (a.touches + b.touches) / 2.0,
                      max_friction, settling_way(a, b, h_), !sticks});
}

std::size_t Pinches::side_of(const Pinch& pinch, double weight, const Vector3& normal) {
  return weight * normal.dot(pinch.across) > 0 ? 0 : 1;
}

void Pinches::add_layer_contact(const std::array<int, 4>& points,
                                const std::array<double, 4>& weights, const Vector3& normal) {
  for (std::size_t k = 0; k < 4; ++k) {
    if (weights[k] == 0) continue;
    Pinch& pinch = pinches_[static_cast<std::size_t>(number_[static_cast<std::size_t>(points[k])])];
    pinch.contacts[side_of(pinch, weights[k], normal)] += std::abs(weights[k]);
  }
}

double Pinches::layer_normal_impulse(const std::array<int, 4>& points,
                                     const std::array<double, 4>& weights,
                                     const Vector3& normal) const {
  double sum = 0;  // of both features
  for (std::size_t k = 0; k < 4; ++k) {
    if (weights[k] == 0) continue;
    const Pinch& pinch = pinch_of(points[k]);
    sum += std::abs(weights[k]) * pinch.normal_impulse /
           pinch.contacts[side_of(pinch, weights[k], normal)];
  }
  return sum / 2;
}

double Pinches::solve_pass(Points& velocities) {
  double largest2 = 0;
  for (Pinch& p : pinches_) {
    const Vector3 wanted = p.given + p.velocity - row(velocities, p.point);
    const Vector3 across = p.across.dot(wanted) * p.across;
    Vector3 along = wanted - across;
    const double needed = along.norm();
    p.slips = needed > p.max_friction;
    if (p.slips) along *= p.max_friction / needed;
    const Vector3 change = across + along - p.given;
    p.given += change;
    velocities.row(p.point) += change.transpose();
    largest2 = std::max(largest2, change.squaredNorm());
  }
  return std::sqrt(largest2);
}

int Pinches::slipping() const {
  return static_cast<int>(std::count_if(pinches_.begin(), pinches_.end(), [](const Pinch& p) {
    return p.max_friction > 0 && p.slips;
  }));
}

void Pinches::project_positions(const Points& start, Points& positions) const {
  for (const Pinch& p : pinches_) {
    Vector3 back = row(start, p.point) + h_ * p.velocity - row(positions, p.point);
    if (p.slips) back = p.across.dot(back) * p.across;
    back += p.settling * p.across;
    positions.row(p.point) += back.transpose();
  }
}

}  // namespace clothsim
