#include "clothsim/constraints/contact_slots.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr int block_size = ContactSlots::block;
using Triples = ContactSlots::Triples;
using Block = ContactSlots::Block;

/// Velocity of a solid about `origin`, in the world.
struct SolidMotion {
  Vector3 velocity;  // [m/s]
  Vector3 angular;   // [rad/s]
  Vector3 origin;    // [m]
};

/// The places for the detection of contact. For a point with an impulse: where it lies when
/// impulses act, as if it followed the surface from there on, `impulse_time` [s] back along the
/// velocity that brought it to x. For others, which may still pass by: x.
CLOTHSIM_TARGET_CLONES
void go_back(int count, double impulse_time, const SolidMotion& motion, PointRun x,
             PointRun drifted, Block* slots, MutablePointRun from) {
  const Vector3 v = motion.velocity, w = motion.angular, origin = motion.origin;
  for (int first = 0; first < count; first += block_size, ++slots) {
    Block& s = *slots;
    for_each_lane(std::min(block_size, count - first), [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double rx = x.x[i] - origin[0], ry = x.y[i] - origin[1], rz = x.z[i] - origin[2];
      const double ux = v[0] + (w[1] * rz - w[2] * ry);
      const double uy = v[1] + (w[2] * rx - w[0] * rz);
      const double uz = v[2] + (w[0] * ry - w[1] * rx);
      const double back = s.normal_impulse[lane] > 0 ? impulse_time : 0;
      s.surface.x[lane] = ux;
      s.surface.y[lane] = uy;
      s.surface.z[lane] = uz;
      from.x[i] = x.x[i] - back * (drifted.x[i] - ux);
      from.y[i] = x.y[i] - back * (drifted.y[i] - uy);
      from.z[i] = x.z[i] - back * (drifted.z[i] - uz);
    });
  }
}

/// Data of some points for the detection of contact.
struct Approach {
  double h;             // [s]
  double impulse_time;  // [s] see go_back()
  double offset;        // distance that points keep from the surface [m]
  const double* inv_mass;
  const double* distance;  // [m]
  PointRun normal;
  PointRun velocity;  // [m/s]
  PointRun drifted;   // [m/s]
};

/// Marks points in contact, with their target velocity: towards the surface at most as fast as uses
/// up the gap, the one at the step's end if they only followed the surface. `touching`: number of
/// such points by block.
CLOTHSIM_TARGET_CLONES
void mark_touching(int count, const Approach& a, Block* slots, long* touching) {
  const double h = a.h, impulse_time = a.impulse_time, offset = a.offset;
  const PointRun n = a.normal, v = a.velocity, drifted = a.drifted;
  const double *const inv_mass = a.inv_mass, *const distance = a.distance;
  for (int first = 0; first < count; first += block_size, ++slots, ++touching) {
    Block& s = *slots;
    long here = 0;
    for_each_lane(std::min(block_size, count - first), [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double ux = s.surface.x[lane], uy = s.surface.y[lane], uz = s.surface.z[lane];
      const double rate = n.x[i] * (v.x[i] - ux) + n.y[i] * (v.y[i] - uy) + n.z[i] * (v.z[i] - uz);
      const double drift = n.x[i] * (drifted.x[i] - ux) + n.y[i] * (drifted.y[i] - uy) +
                           n.z[i] * (drifted.z[i] - uz);
      const bool held = s.normal_impulse[lane] > 0;
      const double gap = distance[i] - offset - (held ? 0 : impulse_time * drift);
      const double target = -(gap > 0 ? gap : 0) / h;
      // Other constraints may still push a point on the surface into it.
      const bool touches = (inv_mass[i] > 0) & (held | (rate < target) | (gap <= 0));
      s.normal.x[lane] = n.x[i];
      s.normal.y[lane] = n.y[i];
      s.normal.z[lane] = n.z[i];
      s.target_velocity[lane] = touches ? target : -infinity;
      here += touches;
    });
    *touching = here;
  }
}

/// ContactImpulse::warm_start() for these blocks; adds the impulses to the velocities.
CLOTHSIM_TARGET_CLONES
void warm_start_blocks(const std::vector<int>& blocks, int points, double scale,
                       const double* inv_mass, Block* slots, MutablePointRun v) {
  for (const int b : blocks) {
    Block& s = slots[b];
    const int first = b * block_size;
    for_each_lane(std::min(block_size, points - first), [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double kept = inv_mass[i] > 0 ? scale : 0;
      const double normal_impulse = kept * s.normal_impulse[lane];
      const double nx = s.normal.x[lane], ny = s.normal.y[lane], nz = s.normal.z[lane];
      const double dx = kept * s.friction_impulse.x[lane], dy = kept * s.friction_impulse.y[lane],
                   dz = kept * s.friction_impulse.z[lane];
      const double along = nx * dx + ny * dy + nz * dz;
      s.normal_impulse[lane] = normal_impulse;
      s.friction_impulse.x[lane] = dx - along * nx;
      s.friction_impulse.y[lane] = dy - along * ny;
      s.friction_impulse.z[lane] = dz - along * nz;
      v.x[i] += normal_impulse * nx + s.friction_impulse.x[lane];
      v.y[i] += normal_impulse * ny + s.friction_impulse.y[lane];
      v.z[i] += normal_impulse * nz + s.friction_impulse.z[lane];
      s.left.x[lane] = std::numeric_limits<double>::quiet_NaN();
    });
  }
}

/// ContactImpulse::update() of slot i, for a single point whose velocity has changed since the last
/// pass: other points of its block make no difference to the last bit. Returns the square of the
/// change.
[[gnu::always_inline]] inline double update(Block& s, double friction, const MutablePointRun& v,
                                            int i) {
  const double nx = s.normal.x[i], ny = s.normal.y[i], nz = s.normal.z[i];
  const double vx = v.x[i] - s.surface.x[i];
  const double vy = v.y[i] - s.surface.y[i];
  const double vz = v.z[i] - s.surface.z[i];
  const double rate = nx * vx + ny * vy + nz * vz;
  const double wanted = s.normal_impulse[i] + (s.target_velocity[i] - rate);
  const double normal_impulse = wanted > 0 ? wanted : 0;

  double dx = s.friction_impulse.x[i] - (vx - rate * nx);
  double dy = s.friction_impulse.y[i] - (vy - rate * ny);
  double dz = s.friction_impulse.z[i] - (vz - rate * nz);
  const double max_friction = friction * normal_impulse;
  const double length2 = dx * dx + dy * dy + dz * dz;
  const double shrunk = max_friction / std::sqrt(length2);
  const double share = length2 > max_friction * max_friction ? shrunk : 1;
  dx *= share;
  dy *= share;
  dz *= share;

  const bool rests = (v.x[i] == s.left.x[i]) & (v.y[i] == s.left.y[i]) & (v.z[i] == s.left.z[i]);
  const double more = normal_impulse - s.normal_impulse[i];
  const double cx = rests ? 0 : more * nx + dx - s.friction_impulse.x[i];
  const double cy = rests ? 0 : more * ny + dy - s.friction_impulse.y[i];
  const double cz = rests ? 0 : more * nz + dz - s.friction_impulse.z[i];
  s.normal_impulse[i] = rests ? s.normal_impulse[i] : normal_impulse;
  s.friction_impulse.x[i] = rests ? s.friction_impulse.x[i] : dx;
  s.friction_impulse.y[i] = rests ? s.friction_impulse.y[i] : dy;
  s.friction_impulse.z[i] = rests ? s.friction_impulse.z[i] : dz;
  s.left.x[i] = v.x[i] += cx;
  s.left.y[i] = v.y[i] += cy;
  s.left.z[i] = v.z[i] += cz;
  return cx * cx + cy * cy + cz * cz;
}

/// Bits of half of a block's numbers: the difference of all is faster to gather than a comparison
/// of each.
using Bits = std::uint64_t __attribute__((vector_size(32), aligned(8), may_alias));
[[gnu::always_inline]] inline const Bits& bits(const double* numbers) {
  return *reinterpret_cast<const Bits*>(numbers);
}

/// The same for a block whose points have changed since the last pass. `largest`: of the squares so
/// far, by lane.
[[gnu::always_inline]] inline void update_block(Block& s, double friction, const MutablePointRun& v,
                                                double* largest) {
  Bits differ = {};
  for (int i = 0; i < block_size; i += half_size) {
    differ |= (bits(v.x + i) ^ bits(s.left.x + i)) | (bits(v.y + i) ^ bits(s.left.y + i)) |
              (bits(v.z + i) ^ bits(s.left.z + i));
  }
  std::uint64_t changed = 0;
  for (int i = 0; i < half_size; ++i) changed |= differ[i];
  if (changed == 0) return;
#pragma GCC ivdep
  for (int i = 0; i < block_size; ++i) {
    const double change2 = update(s, friction, v, i);
    largest[i] = change2 > largest[i] ? change2 : largest[i];
  }
}

/// The same for all these blocks, none of which ends beyond `v`.
CLOTHSIM_TARGET_CLONES
void update_blocks(const int* blocks, std::size_t count, double friction, Block* slots,
                   MutablePointRun v, double* largest) {
  for (std::size_t k = 0; k < count; ++k) {
    const int first = blocks[k] * block_size;
    update_block(slots[blocks[k]], friction, {v.x + first, v.y + first, v.z + first}, largest);
  }
}

/// Lifts free points that are less than `offset` away from the surface to it. `highest`: the
/// largest displacement so far, by lane.
CLOTHSIM_TARGET_CLONES
void lift_out(int count, double offset, const double* free, const double* distance, PointRun n,
              MutablePointRun x, double* highest) {
  for (int first = 0; first < count; first += block_size) {
    for_each_lane(std::min(block_size, count - first), [&](int lane) CLOTHSIM_INLINE {
      const int i = first + lane;
      const double missing = offset - distance[i];
      const double push = (free[i] > 0) & (missing > 0) ? missing : 0;
      x.x[i] += push * n.x[i];
      x.y[i] += push * n.y[i];
      x.z[i] += push * n.z[i];
      highest[lane] = push > highest[lane] ? push : highest[lane];
    });
  }
}

/// Distances and normals of the points of a span.
struct SpanDistances {
  static constexpr int capacity = Span::longest * block_size;

  double value[capacity];
  double x[capacity];
  double y[capacity];
  double z[capacity];

  MutablePointRun normals() { return {x, y, z}; }
};

}  // namespace

ContactSlots::Detector::Detector(const MovingCollider& c, const Cloth& all, double kept,
                                 const MeshQuery& a)
    : collider(c), cloth(all), frame(c.pose()), before(c.previous()), offset(kept), query_(a) {}

void ContactSlots::Detector::add_nearer(int first, int count, double* distances) const {
  if (cloth.thicknesses.size() == 0) return;
  for (int i = 0; i < count; ++i) distances[i] += cloth.nearer_by(first + i);
}

MeshQuery ContactSlots::Detector::query(int first) const {
  return {query_.near, query_.neighbourhoods ? query_.neighbourhoods + first : nullptr};
}

void ContactSlots::reset(const Cloth& cloth) {
  points_ = cloth.num_points();
  Block empty{};
  std::fill(std::begin(empty.target_velocity), std::end(empty.target_velocity), -infinity);
  blocks_.assign(static_cast<std::size_t>(num_blocks(cloth)), empty);
  is_active_.assign(blocks_.size(), 0);
  active_.clear();
}

void ContactSlots::find(const Span& span, const Detector& detector, const Cloth& cloth,
                        const ContactStep& step, const State& state, double* nearest) {
  const int first = first_of(span.begin), count = end_of(span.end - 1) - first;
  const MovingCollider& collider = detector.collider;
  const double impulse_time = step.displacement_factor * step.h;
  const PointRun drifted = run_from(step.drifted, first);
  double x[SpanDistances::capacity], y[SpanDistances::capacity], z[SpanDistances::capacity];
  SpanDistances distances;
  go_back(count, impulse_time,
          {collider.velocity(), collider.angular_velocity(), detector.frame.origin},
          run_from(state.positions, first), drifted, &at(span.begin), {x, y, z});
  signed_distances(collider.shape(), detector.frame, {x, y, z}, detector.before,
                   run_from(step.start, first), count, detector.query(first), distances.value,
                   distances.normals());
  for (int b = span.begin; b < span.end; ++b) {
    nearest[b - span.begin] = least_distance(b, distances.value + first_of(b) - first);
  }
  detector.add_nearer(first, count, distances.value);
  long touching[Span::longest];
  mark_touching(count,
                {step.h, impulse_time, detector.offset, &cloth.inv_mass[first], distances.value,
                 distances.normals(), run_from(state.velocities, first), drifted},
                &at(span.begin), touching);
  for (int b = span.begin; b < span.end; ++b) {
    if (touching[b - span.begin] == 0) continue;
    is_active_[static_cast<std::size_t>(b)] = 1;
    active_.push_back(b);
  }
}

double ContactSlots::least_distance(int b, const double* distances) const {
  double least = infinity;
  for (int i = 0; i < end_of(b) - first_of(b); ++i) {
    // Those with an impulse were not measured where they are.
    if (at(b).normal_impulse[i] > 0) return -infinity;
    least = std::min(least, distances[i]);
  }
  return least;
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
                       double target_velocity) {
  activate(point / block);
  Block& s = at(point / block);
  const int i = point % block;
  s.normal.set(i, normal);
  s.surface.set(i, surface_velocity);
  s.target_velocity[i] = target_velocity;
}

void ContactSlots::remove(int point) {
  Block& s = at(point / block);
  const int i = point % block;
  s.target_velocity[i] = -infinity;
  s.normal_impulse[i] = 0;
  s.friction_impulse.set(i, Vector3::Zero());
}

void ContactSlots::close() {
  if (!std::is_sorted(active_.begin(), active_.end())) std::sort(active_.begin(), active_.end());
  for (const int b : last_active_) {
    if (!has_active(b)) clear(b);
  }
}

void ContactSlots::set_impulse(int point, const ContactImpulse& impulse) {
  activate(point / block);
  at(point / block).normal_impulse[point % block] = impulse.normal_impulse;
  at(point / block).friction_impulse.set(point % block, impulse.friction_impulse);
}

void ContactSlots::warm_start(const Cloth& cloth, double scale, Points& velocities) {
  if (active_.empty()) return;
  warm_start_blocks(active_, points_, scale, cloth.inv_mass.data(), blocks_.data(),
                    run_from(velocities, 0));
}

double ContactSlots::solve_pass(double friction, Points& velocities) {
  if (active_.empty()) return 0;
  double largest2[block_size] = {};
  const bool ends_short = end_of(active_.back()) - first_of(active_.back()) < block;
  update_blocks(active_.data(), active_.size() - ends_short, friction, blocks_.data(),
                run_from(velocities, 0), largest2);
  if (ends_short) {  // slots without a point never touch
    const int b = active_.back(), first = first_of(b), zero = 0;
    Triples v{};
    for (int i = first; i < points_; ++i) v.set(i - first, row(velocities, i));
    update_blocks(&zero, 1, friction, &at(b), v.run(), largest2);
    for (int i = first; i < points_; ++i) velocities.row(i) = v.get(i - first).transpose();
  }
  return *std::max_element(std::begin(largest2), std::end(largest2));
}

double ContactSlots::project_positions(const Span& span, const Detector& detector,
                                       const double* free, const Points& start, Points& positions,
                                       double* min_distances) {
  const int first = first_of(span.begin);
  const int count = std::min(first_of(span.end), static_cast<int>(start.rows())) - first;
  SpanDistances distances;
  signed_distances(detector.collider.shape(), detector.frame, run_from(positions, first),
                   detector.before, run_from(start, first), count, detector.query(first),
                   distances.value, distances.normals());
  for (int i = 0; i < count; i += block_size) {
    min_distances[i / block_size] =
        *std::min_element(distances.value + i, distances.value + std::min(i + block_size, count));
  }
  detector.add_nearer(first, count, distances.value);
  double highest[block_size] = {};
  lift_out(count, detector.offset, free, distances.value, distances.normals(),
           run_from(positions, first), highest);
  return *std::max_element(std::begin(highest), std::end(highest));
}

ContactImpulse ContactSlots::contact(int point, double friction) const {
  const Block& s = at(point / block);
  const int i = point % block;
  ContactImpulse result;
  result.normal = s.normal.get(i);
  result.surface_velocity = s.surface.get(i);
  result.target_velocity = s.target_velocity[i];
  result.friction = friction;
  result.normal_impulse = s.normal_impulse[i];
  result.friction_impulse = s.friction_impulse.get(i);
  return result;
}

int ContactSlots::count() const {
  int held = 0;
  for_each_with_impulse([&](int, const ContactImpulse&) { ++held; });
  return held;
}

}  // namespace clothsim
