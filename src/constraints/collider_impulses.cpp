// The impulses of a cloth on colliders in a step: those of contact, with opposite sign.

#include <array>

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Sums by lane, independent of each other.
struct LaneSums {
  std::array<std::array<double, ContactSlots::block>, 3> impulse{};  // [N s]
  std::array<std::array<double, ContactSlots::block>, 3> moment{};   // about the origin [N m s]
};

/// Adds the impulses on the points of these blocks, none of which ends beyond `mass` and `x`.
CLOTHSIM_TARGET_CLONES
void add_up(const int* blocks, std::size_t count, const ContactSlots::Block* slots,
            const double* mass, const Vector3& origin, PointRun x, LaneSums& sums) {
  const double ox = origin.x(), oy = origin.y(), oz = origin.z();
  LaneSums s = sums;
  for (std::size_t k = 0; k < count; ++k) {
    const ContactSlots::Block& b = slots[blocks[k]];
    const int first = blocks[k] * ContactSlots::block;
#pragma GCC ivdep
    for (int lane = 0; lane < ContactSlots::block; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      const int i = first + lane;
      const double fx =
          mass[i] * (b.normal_impulse[lane] * b.normal.x[lane] + b.friction_impulse.x[lane]);
      const double fy =
          mass[i] * (b.normal_impulse[lane] * b.normal.y[lane] + b.friction_impulse.y[lane]);
      const double fz =
          mass[i] * (b.normal_impulse[lane] * b.normal.z[lane] + b.friction_impulse.z[lane]);
      const double rx = x.x[i] - ox, ry = x.y[i] - oy, rz = x.z[i] - oz;
      s.impulse[0][l] += fx;
      s.impulse[1][l] += fy;
      s.impulse[2][l] += fz;
      s.moment[0][l] += ry * fz - rz * fy;
      s.moment[1][l] += rz * fx - rx * fz;
      s.moment[2][l] += rx * fy - ry * fx;
    }
  }
  sums = s;
}

Vector3 total(const std::array<std::array<double, ContactSlots::block>, 3>& lanes) {
  Vector3 sum;
  for (int axis = 0; axis < 3; ++axis) {
    sum[axis] = Eigen::Map<const Eigen::Array<double, ContactSlots::block, 1>>(
                    lanes[static_cast<std::size_t>(axis)].data())
                    .sum();
  }
  return sum;
}

}  // namespace

void ContactSlots::add_impulses(const Scalars& masses, const Vector3& origin,
                                const Points& positions, Wrench& sum) const {
  if (active_.empty()) return;
  LaneSums lanes;
  const bool ends_short = end_of(active_.back()) - first_of(active_.back()) < block;
  add_up(active_.data(), active_.size() - ends_short, blocks_.data(), masses.data(), origin,
         run_from(positions, 0), lanes);
  if (ends_short) {  // with slots that no point has
    const int b = active_.back(), first = first_of(b), zero = 0;
    Triples x{};
    double mass[block] = {};
    for (int i = first; i < points_; ++i) {
      x.set(i - first, row(positions, i));
      mass[i - first] = masses[i];
    }
    add_up(&zero, 1, &at(b), mass, origin, x.run(), lanes);
  }
  sum.force -= total(lanes.impulse);
  sum.torque -= total(lanes.moment);
}

void ContactSlots::add_velocities(Points& sum) const {
  for_each_with_impulse(
      [&](int i, const ContactImpulse& impulse) { sum.row(i) += impulse.total().transpose(); });
}

void FaceContacts::add_impulses(const std::vector<MovingCollider>& colliders, const Scalars& masses,
                                const Points& positions, std::vector<Wrench>& sums) const {
  for (const Contact& c : list_.contacts()) {
    if (c.impulse.normal_impulse == 0) continue;
    const auto collider = static_cast<std::size_t>(collider_of(c));
    const Vector3& origin = colliders[collider].pose().position;
    const Vector3 impulse = c.impulse.total();
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = c.points[k];
      sums[collider].add(row(positions, i) - origin, -masses[i] * c.moves[k] * impulse);
    }
  }
}

void Pinches::add_impulses(const std::vector<MovingCollider>& colliders, const Scalars& masses,
                           const Points& positions, std::vector<Wrench>& sums) const {
  for (const Pinch& p : pinches_) {
    const auto put_on = [&](const MovingCollider& collider, const Vector3& change) {
      sums[static_cast<std::size_t>(&collider - colliders.data())].add(
          row(positions, p.point) - collider.pose().position, -masses[p.point] * change);
    };
    const Vector3 across = p.across.dot(p.given) * p.across;
    const Vector3 along = p.given - across;
    put_on(p.across.dot(p.given) > 0 ? *p.a : *p.b, across);
    put_on(*p.a, (1 - p.share_of_b) * along);
    put_on(*p.b, p.share_of_b * along);
  }
}

void ColliderContacts::add_impulses(const std::vector<MovingCollider>& colliders,
                                    const Scalars& masses, const Points& positions,
                                    std::vector<Wrench>& sums) const {
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    caches_[k].slots.add_impulses(masses, colliders[k].pose().position, positions, sums[k]);
  }
  faces_.add_impulses(colliders, masses, positions, sums);
  pinches_.add_impulses(colliders, masses, positions, sums);
}

}  // namespace clothsim
