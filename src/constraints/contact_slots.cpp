#include "clothsim/constraints/contact_slots.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clothsim/model/lanes.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int most = ContactSlots::block;

/// Numbers of the points of a block, with room for all.
struct BlockPoints {
  double x[most];
  double y[most];
  double z[most];

  MutablePointRun run() { return {x, y, z}; }
};

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

/// Contacts of some points, from the first on.
struct Slots {
  MutablePointRun normal;
  MutablePointRun surface;
  double* slowest;
  double* push;
  MutablePointRun drag;
};

/// See ContactImpulse::resume().
CLOTHSIM_TARGET_CLONES
void resume_all(int count, double scale, const double* inv_mass, Slots s, MutablePointRun v) {
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
  }
}

/// ContactImpulse::update() of slot i on a point alone. Returns the square of the change.
[[gnu::always_inline]] inline double update(const Slots& s, double friction,
                                            const MutablePointRun& v, int i) {
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
  v.x[i] += cx;
  v.y[i] += cy;
  v.z[i] += cz;
  return cx * cx + cy * cy + cz * cz;
}

/// The same of all slots of a block. `largest`: of the squares so far, by lane.
CLOTHSIM_TARGET_CLONES
void update_all(int count, double friction, Slots s, MutablePointRun v, double* largest) {
  int first = 0;
  for (; first + num_lanes <= count; first += num_lanes) {
#pragma GCC ivdep
    for (int lane = 0; lane < num_lanes; ++lane) {
      const double change2 = update(s, friction, v, first + lane);
      largest[lane] = change2 > largest[lane] ? change2 : largest[lane];
    }
  }
  for (; first < count; ++first) {
    largest[0] = std::max(largest[0], update(s, friction, v, first));
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
  const int n = cloth.num_points();
  for (Points* points : {&normal_, &surface_velocity_, &drag_}) points->setZero(n, 3);
  slowest_.setConstant(n, -infinity);
  push_.setZero(n);
  active_.clear();
  is_active_.assign(static_cast<std::size_t>(num_blocks(cloth)), 0);
}

void ContactSlots::find(int b, const Seeker& seeker, const Cloth& cloth, const ContactStep& step,
                        const State& state) {
  const int first = b * block, count = end_of(b) - first;
  const MovingCollider& collider = seeker.collider;
  const double way = step.reach * step.h;
  const PointRun drifted = run_from(step.drifted, first);
  BlockPoints from;
  double distance[most];
  go_back(count, way, {collider.velocity(), collider.angular_velocity(), seeker.frame.origin},
          &push_[first], run_from(state.positions, first), drifted,
          run_from(surface_velocity_, first), from.run());
  signed_distances(collider.shape(), seeker.frame, from.run(), seeker.before,
                   run_from(step.start, first), count, distance, run_from(normal_, first));
  const long touching =
      mark_touching(count,
                    {step.h, way, seeker.offset, &cloth.inv_mass[first], &push_[first], distance,
                     run_from(normal_, first), run_from(surface_velocity_, first),
                     run_from(state.velocities, first), drifted},
                    &slowest_[first]);
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
  const int first = b * block, count = end_of(b) - first;
  slowest_.segment(first, count).setConstant(-infinity);
  push_.segment(first, count).setZero();
  drag_.middleRows(first, count).setZero();
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
  normal_.row(point) = normal.transpose();
  surface_velocity_.row(point) = surface_velocity.transpose();
  slowest_[point] = slowest;
}

void ContactSlots::remove(int point) {
  slowest_[point] = -infinity;
  push_[point] = 0;
  drag_.row(point).setZero();
}

void ContactSlots::close() {
  std::sort(active_.begin(), active_.end());
  for (const int b : last_active_) {
    if (!has_active(b)) clear(b);
  }
}

void ContactSlots::hold(int point, const ContactImpulse& impulse) {
  activate(point / block);
  push_[point] = impulse.push;
  drag_.row(point) = impulse.drag.transpose();
}

void ContactSlots::resume(const Cloth& cloth, double scale, Points& velocities) {
  for (const int b : active_) {
    const int first = b * block;
    resume_all(end_of(b) - first, scale, &cloth.inv_mass[first],
               {run_from(normal_, first), run_from(surface_velocity_, first), &slowest_[first],
                &push_[first], run_from(drag_, first)},
               run_from(velocities, first));
  }
}

double ContactSlots::sweep(double friction, Points& velocities) {
  double largest2[num_lanes] = {};
  for (const int b : active_) {
    const int first = b * block;
    update_all(end_of(b) - first, friction,
               {run_from(normal_, first), run_from(surface_velocity_, first), &slowest_[first],
                &push_[first], run_from(drag_, first)},
               run_from(velocities, first), largest2);
  }
  return *std::max_element(std::begin(largest2), std::end(largest2));
}

ContactSlots::Pushed ContactSlots::push_out(int b, const Seeker& seeker, const double* free,
                                            const Points& start, Points& positions) {
  const int first = b * block, count = std::min(block, static_cast<int>(start.rows()) - first);
  double distance[most], lift[most];
  BlockPoints normal;
  signed_distances(seeker.collider.shape(), seeker.frame, run_from(positions, first), seeker.before,
                   run_from(start, first), count, distance, normal.run());
  lift_out(count, seeker.offset, free, distance, normal.run(), run_from(positions, first), lift);
  return {*std::min_element(distance, distance + count), *std::max_element(lift, lift + count)};
}

ContactImpulse ContactSlots::contact(int point, double friction) const {
  ContactImpulse result;
  result.normal = row(normal_, point);
  result.surface_velocity = row(surface_velocity_, point);
  result.slowest = slowest_[point];
  result.friction = friction;
  result.push = push_[point];
  result.drag = row(drag_, point);
  return result;
}

int ContactSlots::count() const {
  int held = 0;
  for_each_held([&](int, const ContactImpulse&) { ++held; });
  return held;
}

}  // namespace clothsim
