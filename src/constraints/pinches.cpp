#include "clothsim/constraints/pinches.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// Largest pull of the strain limit along two colliders that all points between them bear, in
/// weights of the whole cloth: as for a gripper that lifts it by one point and shakes it. With ten,
/// fingers that pull it from its pins stretched it by 70 to 90 %.
constexpr double strongest_grip = 3;

Vector3 direction_across(const Vector3& normal_a, const Vector3& normal_b) {
  return (normal_a - normal_b).normalized();
}

/// Friction at a point on one side: that of the collider, or the least in a row of layers, which
/// count with that of the point's own cloth.
double friction_of(const Pinches::ColliderDistance& side, const Cloth& cloth, int point) {
  const double of_collider = side.collider->friction();
  return side.touches ? of_collider : std::min(of_collider, cloth.friction_at(point));
}

/// Firmness of that grip: surfaces rub in series, with a compliance of 1 / friction each.
double firmness_of(const Pinches::ColliderDistance& side, const Cloth& cloth, int point) {
  if (friction_of(side, cloth, point) == 0) return 0;
  const double compliance = 1 / side.collider->friction();
  return 1 / (side.touches ? compliance : compliance + side.layers / cloth.friction_at(point));
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
  collider_pairs_.clear();
  held_.clear();
}

std::size_t Pinches::pair_of(const MovingCollider& a, const MovingCollider& b) {
  const auto known =
      std::find_if(collider_pairs_.begin(), collider_pairs_.end(), [&](const ColliderPair& pair) {
        return (pair.a == &a && pair.b == &b) || (pair.a == &b && pair.b == &a);
      });
  if (known != collider_pairs_.end()) {
    return static_cast<std::size_t>(known - collider_pairs_.begin());
  }
  collider_pairs_.push_back({&a, &b, 0});
  return collider_pairs_.size() - 1;
}

bool Pinches::face_each_other(const Vector3& a, const Vector3& b) { return a.dot(b) <= -facing; }

bool Pinches::leave_no_room(const ColliderDistance& a, const ColliderDistance& b, const Vector3& x,
                            double h) {
  const Vector3 across = direction_across(a.normal, b.normal);
  const double opening = across.dot(b.collider->velocity_at(x) - a.collider->velocity_at(x));
  return a.distance + b.distance + h * opening <= a.layer_height + b.layer_height;
}

void Pinches::add(int point, const Vector3& x, const ColliderDistance& a, const ColliderDistance& b,
                  const Cloth& cloth) {
  if (cloth.inv_mass[point] == 0 || holds(point)) return;
  if (held_.empty()) held_.assign(static_cast<std::size_t>(cloth.num_points()), 0);
  held_[static_cast<std::size_t>(point)] = 1;
  number_.resize(held_.size());
  number_[static_cast<std::size_t>(point)] = static_cast<int>(pinches_.size());

  const Vector3 across = direction_across(a.normal, b.normal);
  const Vector3 of_a = (a.collider->carried(x) - x) / h_, of_b = (b.collider->carried(x) - x) / h_;
  const double share = share_across(a, b);
  const double rate = across.dot((1 - share) * of_a + share * of_b);
  const double firm_a = firmness_of(a, cloth, point), firm_b = firmness_of(b, cloth, point);
  const bool sticks = firm_a + firm_b > 0 && jams(a.normal, b.normal, friction_of(a, cloth, point),
                                                  friction_of(b, cloth, point));
  const double share_of_b = sticks ? firm_b / (firm_a + firm_b) : 0.5;
  const Vector3 along = (1 - share_of_b) * of_a + share_of_b * of_b;
  const double grip = sticks ? strongest_grip * weight(cloth) * cloth.inv_mass[point] : 0;
  const std::size_t pair = pair_of(*a.collider, *b.collider);
  if (sticks) ++collider_pairs_[pair].points;
  pinches_.push_back({point, along + (rate - across.dot(along)) * across, across, a.collider,
                      b.collider, share_of_b, grip, pair, Vector3::Zero(), Vector3::Zero(),
                      Vector3::Zero(), !sticks});
}

double Pinches::solve_pass(Points& velocities) {
  double largest2 = 0;
  for (Pinch& p : pinches_) {
    const Vector3 wanted = p.given + p.velocity - row(velocities, p.point);
    const Vector3 across = p.across.dot(wanted) * p.across;
    const Vector3 along = p.grip > 0 ? Vector3(wanted - across + slip(p)) : Vector3::Zero();
    const Vector3 change = across + along - p.given;
    p.given += change;
    velocities.row(p.point) += change.transpose();
    p.left = row(velocities, p.point);
    largest2 = std::max(largest2, change.squaredNorm());
  }
  return std::sqrt(largest2);
}

/// Velocity along both by the excess of the strain limit's pull over the grip [m/s].
Vector3 Pinches::slip(Pinch& p) const {
  const Vector3 pull = p.pull - p.across.dot(p.pull) * p.across;
  const double strength = pull.norm(), strongest = p.grip / collider_pairs_[p.pair].points;
  p.slips = strength > strongest;
  return p.slips ? Vector3((1 - strongest / strength) * pull) : Vector3::Zero();
}

void Pinches::set_pulls(const Points& given) {
  for (Pinch& p : pinches_) p.pull = row(given, p.point);
}

void Pinches::add_pulls(const Points& velocities) {
  for (Pinch& p : pinches_) p.pull += row(velocities, p.point) - p.left;
}

int Pinches::slipping() const {
  return static_cast<int>(std::count_if(pinches_.begin(), pinches_.end(),
                                        [](const Pinch& p) { return p.grip > 0 && p.slips; }));
}

void Pinches::project_positions(const Points& start, Points& positions) const {
  for (const Pinch& p : pinches_) {
    Vector3 back = row(start, p.point) + h_ * p.velocity - row(positions, p.point);
    if (p.slips) back = p.across.dot(back) * p.across;
    positions.row(p.point) += back.transpose();
  }
}

}  // namespace clothsim
