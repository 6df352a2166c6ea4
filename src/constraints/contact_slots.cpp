#include "clothsim/constraints/contact_slots.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most = ContactSlots::block;
using Triples = ContactSlots::Triples;
using Block = ContactSlots::Block;

/// Velocity of a solid about `origin`, in the world.
struct Motion {
  Vector3 velocity;  // [m/s]
  Vector3 angular;   // [rad/s]
  Vector3 origin;    // [m]
};

/// Where contact is looked for: of a point that is held, where it lies when impulses act, as if it
/// followed the surface from there on, `way` [s] back along the velocity that brought it to x.
/// Others may yet pass by: as they lie at x.
CLOTHSIM_TARGET_CLONES
void go_back(int count, double way, const Motion& motion, const double* push, PointRun x,
             PointRun drifted, MutablePointRun surface, MutablePointRun from) {
  const Vector3 v = motion.velocity, w = motion.angular, origin = motion.origin;
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const double rx = x.x[i] - origin[0], ry = x.y[i] - origin[1], rz = x.z[i] - origin[2];
    const double ux = v[0] + (w[1] * rz - w[2] * ry);
    const double uy = v[1] + (w[2] * rx - w[0] * rz);
    const double uz = v[2] + (w[0] * ry - w[1] * rx);
    const double back = push[i] > 0 ? way : 0;
    surface.x[i] = ux;
    surface.y[i] = uy;
    surface.z[i] = uz;
    from.x[i] = x.x[i] - back * (drifted.x[i] - ux);
    from.y[i] = x.y[i] - back * (drifted.y[i] - uy);
    from.z[i] = x.z[i] - back * (drifted.z[i] - uz);
  }
}

/// What is known of some points where contact is looked for.
struct Approach {
  double h;       // [s]
  double way;     // [s] see go_back()
  double offset;  // that points keep from the surface [m]
  const double* inv_mass;
  const double* push;
  const double* distance;  // [m]
  PointRun normal;
  PointRun surface;   // velocity [m/s]
  PointRun velocity;  // [m/s]
  PointRun drifted;   // [m/s]
};

/// Which points touch, and how slowly they may leave: no faster towards the surface than they would
/// use up the gap, the one this step would leave if they only followed it. Returns how many.
CLOTHSIM_TARGET_CLONES
long mark_touching(int count, const Approach& a, double* slowest) {
  const double h = a.h, way = a.way, offset = a.offset;
  const auto [n, u, v, drifted] = std::tuple(a.normal, a.surface, a.velocity, a.drifted);
  const double *const inv_mass = a.inv_mass, *const push = a.push, *const distance = a.distance;
  long touching = 0;
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const double rate =
        n.x[i] * (v.x[i] - u.x[i]) + n.y[i] * (v.y[i] - u.y[i]) + n.z[i] * (v.z[i] - u.z[i]);
    const double drift = n.x[i] * (drifted.x[i] - u.x[i]) + n.y[i] * (drifted.y[i] - u.y[i]) +
                         n.z[i] * (drifted.z[i] - u.z[i]);
    const bool held = push[i] > 0;
    const double gap = distance[i] - offset - (held ? 0 : way * drift);
    const double least = -(gap > 0 ? gap : 0) / h;
    // Others may yet push a point on the surface into it.
    const bool touches = (inv_mass[i] > 0) & (held | (rate < least) | (gap <= 0));
    slowest[i] = touches ? least : -infinity;
    touching += touches;
  }
  return touching;
}

/// See ContactImpulse::resume().
CLOTHSIM_TARGET_CLONES
void resume_all(int count, double scale, const double* inv_mass, Block& s, MutablePointRun v) {
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const double kept = inv_mass[i] > 0 ? scale : 0;
    const double push = kept * s.push[i];
    const double nx = s.normal.x[i], ny = s.normal.y[i], nz = s.normal.z[i];
    const double dx = kept * s.drag.x[i], dy = kept * s.drag.y[i], dz = kept * s.drag.z[i];
    const double along = nx * dx + ny * dy + nz * dz;
    s.push[i] = push;
    s.drag.x[i] = dx - along * nx;
    s.drag.y[i] = dy - along * ny;
    s.drag.z[i] = dz - along * nz;
    v.x[i] += push * nx + s.drag.x[i];
    v.y[i] += push * ny + s.drag.y[i];
    v.z[i] += push * nz + s.drag.z[i];
    s.left.x[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

/// ContactImpulse::update() of slot i on a point alone. Returns the square of the change.
[[gnu::always_inline]] inline double update(Block& s, double friction, const MutablePointRun& v,
                                            int i) {
  const double nx = s.normal.x[i], ny = s.normal.y[i], nz = s.normal.z[i];
  const double vx = v.x[i] - s.surface.x[i];
  const double vy = v.y[i] - s.surface.y[i];
  const double vz = v.z[i] - s.surface.z[i];
  const double rate = nx * vx + ny * vy + nz * vz;
  const double wanted = s.push[i] + (s.slowest[i] - rate);
  const double push = wanted > 0 ? wanted : 0;

  double dx = s.drag.x[i] - (vx - rate * nx);
  double dy = s.drag.y[i] - (vy - rate * ny);
  double dz = s.drag.z[i] - (vz - rate * nz);
  const double strongest = friction * push;
  const double length2 = dx * dx + dy * dy + dz * dz;
  const double shrunk = strongest / std::sqrt(length2);
  const double share = length2 > strongest * strongest ? shrunk : 1;
  dx *= share;
  dy *= share;
  dz *= share;

  const double more = push - s.push[i];
  const double cx = more * nx + dx - s.drag.x[i];
  const double cy = more * ny + dy - s.drag.y[i];
  const double cz = more * nz + dz - s.drag.z[i];
  s.push[i] = push;
  s.drag.x[i] = dx;
  s.drag.y[i] = dy;
  s.drag.z[i] = dz;
  s.left.x[i] = v.x[i] += cx;
  s.left.y[i] = v.y[i] += cy;
  s.left.z[i] = v.z[i] += cz;
  return cx * cx + cy * cy + cz * cz;
}

/// Bits of eight numbers, see Lanes: where they differ is quicker to gather than whether they do.
using Bits = std::uint64_t __attribute__((vector_size(64), aligned(8), may_alias));
[[gnu::always_inline]] inline const Bits& bits(const double* numbers) {
  return *reinterpret_cast<const Bits*>(numbers);
}

/// The same of a block whose points have changed since the last pass. `largest`: of the squares so
/// far, by lane.
[[gnu::always_inline]] inline void update_block(Block& s, double friction, const MutablePointRun& v,
                                                double* largest) {
  const Bits differ =
      (bits(v.x) ^ bits(s.left.x)) | (bits(v.y) ^ bits(s.left.y)) | (bits(v.z) ^ bits(s.left.z));
  std::uint64_t changed = 0;
  for (int i = 0; i < most; ++i) changed |= differ[i];
  if (changed == 0) return;
#pragma GCC ivdep
  for (int i = 0; i < most; ++i) {
    const double change2 = update(s, friction, v, i);
    largest[i] = change2 > largest[i] ? change2 : largest[i];
  }
}

/// The same of all these blocks, none of which ends beyond `v`.
CLOTHSIM_TARGET_CLONES
void update_blocks(const int* blocks, std::size_t count, double friction, Block* slots,
                   MutablePointRun v, double* largest) {
  for (std::size_t k = 0; k < count; ++k) {
    const int first = blocks[k] * most;
    update_block(slots[blocks[k]], friction, {v.x + first, v.y + first, v.z + first}, largest);
  }
}

/// Lifts free points that are less than `offset` away from the surface to it; `lift`: by how much.
CLOTHSIM_TARGET_CLONES
void lift_out(int count, double offset, const double* free, const double* distance, PointRun n,
              MutablePointRun x, double* lift) {
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const double missing = offset - distance[i];
    const double way = (free[i] > 0) & (missing > 0) ? missing : 0;
    x.x[i] += way * n.x[i];
    x.y[i] += way * n.y[i];
    x.z[i] += way * n.z[i];
    lift[i] = way;
  }
}

}  // namespace

ContactSlots::Seeker::Seeker(const MovingCollider& c, double kept)
    : collider(c), frame(c.pose()), before(c.previous()), offset(kept) {}

void ContactSlots::reset(const Cloth& cloth) {
  points_ = cloth.num_points();
  Block empty{};
  std::fill(std::begin(empty.slowest), std::end(empty.slowest), -infinity);
  blocks_.assign(static_cast<std::size_t>(num_blocks(cloth)), empty);
  is_active_.assign(blocks_.size(), 0);
  active_.clear();
}

void ContactSlots::find(int b, const Seeker& seeker, const Cloth& cloth, const ContactStep& step,
                        const State& state) {
  const int first = first_of(b), count = end_of(b) - first;
  const MovingCollider& collider = seeker.collider;
  const double way = step.reach * step.h;
  const PointRun drifted = run_from(step.drifted, first);
  Block& s = at(b);
  Triples from;
  double distance[most];
  go_back(count, way, {collider.velocity(), collider.angular_velocity(), seeker.frame.origin},
          s.push, run_from(state.positions, first), drifted, s.surface.run(), from.run());
  signed_distances(collider.shape(), seeker.frame, from.run(), seeker.before,
                   run_from(step.start, first), count, distance, s.normal.run());
  const long touching =
      mark_touching(count,
                    {step.h, way, seeker.offset, &cloth.inv_mass[first], s.push, distance,
                     s.normal.run(), s.surface.run(), run_from(state.velocities, first), drifted},
                    s.slowest);
  if (touching > 0) {
    is_active_[static_cast<std::size_t>(b)] = 1;
    active_.push_back(b);
  }
}

void ContactSlots::start_over() {
  for (const int b : active_) is_active_[static_cast<std::size_t>(b)] = 0;
  last_active_.swap(active_);
  active_.clear();
}

void ContactSlots::clear(int b) {
  for (int i = first_of(b); i < end_of(b); ++i) remove(i);
}

void ContactSlots::activate(int b) {
  if (has_active(b)) return;
  clear(b);
  is_active_[static_cast<std::size_t>(b)] = 1;
  active_.push_back(b);
}

void ContactSlots::put(int point, const Vector3& normal, const Vector3& surface_velocity,
                       double slowest) {
  activate(point / block);
  Block& s = at(point / block);
  const int i = point % block;
  s.normal.set(i, normal);
  s.surface.set(i, surface_velocity);
  s.slowest[i] = slowest;
}

void ContactSlots::remove(int point) {
  Block& s = at(point / block);
  const int i = point % block;
  s.slowest[i] = -infinity;
  s.push[i] = 0;
  s.drag.set(i, Vector3::Zero());
}

void ContactSlots::close() {
  std::sort(active_.begin(), active_.end());
  for (const int b : last_active_) {
    if (!has_active(b)) clear(b);
  }
}

void ContactSlots::hold(int point, const ContactImpulse& impulse) {
  activate(point / block);
  at(point / block).push[point % block] = impulse.push;
  at(point / block).drag.set(point % block, impulse.drag);
}

void ContactSlots::resume(const Cloth& cloth, double scale, Points& velocities) {
  for (const int b : active_) {
    const int first = first_of(b);
    resume_all(end_of(b) - first, scale, &cloth.inv_mass[first], at(b),
               run_from(velocities, first));
  }
}

double ContactSlots::sweep(double friction, Points& velocities) {
  if (active_.empty()) return 0;
  double largest2[most] = {};
  const bool ends_short = end_of(active_.back()) - first_of(active_.back()) < block;
  update_blocks(active_.data(), active_.size() - ends_short, friction, blocks_.data(),
                run_from(velocities, 0), largest2);
  if (ends_short) {  // with slots that no point has: they never touch
    const int b = active_.back(), first = first_of(b), zero = 0;
    Triples v{};
    for (int i = first; i < points_; ++i) v.set(i - first, row(velocities, i));
    update_blocks(&zero, 1, friction, &at(b), v.run(), largest2);
    for (int i = first; i < points_; ++i) velocities.row(i) = v.get(i - first).transpose();
  }
  return *std::max_element(std::begin(largest2), std::end(largest2));
}

ContactSlots::Pushed ContactSlots::push_out(int b, const Seeker& seeker, const double* free,
                                            const Points& start, Points& positions) {
  const int first = first_of(b), count = std::min(block, static_cast<int>(start.rows()) - first);
  double distance[most], lift[most];
  Triples normal;
  signed_distances(seeker.collider.shape(), seeker.frame, run_from(positions, first), seeker.before,
                   run_from(start, first), count, distance, normal.run());
  lift_out(count, seeker.offset, free, distance, normal.run(), run_from(positions, first), lift);
  return {*std::min_element(distance, distance + count), *std::max_element(lift, lift + count)};
}

ContactImpulse ContactSlots::contact(int point, double friction) const {
  const Block& s = at(point / block);
  const int i = point % block;
  ContactImpulse result;
  result.normal = s.normal.get(i);
  result.surface_velocity = s.surface.get(i);
  result.slowest = s.slowest[i];
  result.friction = friction;
  result.push = s.push[i];
  result.drag = s.drag.get(i);
  return result;
}

int ContactSlots::count() const {
  int held = 0;
  for_each_held([&](int, const ContactImpulse&) { ++held; });
  return held;
}

}  // namespace clothsim
