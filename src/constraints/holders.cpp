#include "clothsim/constraints/holders.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Weights of the cloth that a holder bears by default. A cloth that falls from level into its pins
/// loads each with up to 1.4; a cloth that a tf frame turns by a right angle in a third of a second
/// loads the tf frame with 5.
constexpr double borne_weights = 10;

/// Stretch up to which a holder pulls a cloth without strain limit.
constexpr double usual_stretch = 0.1;

/// Share f of the strength that acts as friction where a point slips.
constexpr double slip_friction = 0.1;

/// A point that has slipped returns at a speed of distance / return_time [s], at recovery_speed at
/// most.
constexpr double return_time = 0.1;

/// A point that slips sticks again at this distance from its target, as a share of the shortest
/// spring.
constexpr double stick_share = 1e-3;

/// A held point presses on a collider if it approaches faster than this [m/s]: lower speeds are
/// rounding, as where one tf frame carries both.
constexpr double min_approach = 1e-6;

Vector3 clamped(const Vector3& v, double max_norm) {
  const double length = v.norm();
  return length > max_norm ? Vector3(max_norm / length * v) : v;
}

/// Does a point that a holder moves at velocity `v` [m/s] press on a collider in contact with it?
bool is_pressed_into(const MovingCollider& collider, const Vector3& x, const Vector3& v,
                     double offset) {
  if (!collider.reaches({x, x}, 2 * offset)) return false;
  const Vector3 local = to_local(collider.pose(), x);
  const Distance distance = signed_distance(collider.shape(), local, local);
  if (distance.value >= offset) return false;
  const Vector3 normal = collider.pose().orientation * distance.normal;
  return normal.dot(v - collider.velocity_at(x)) < -min_approach;
}

/// Is a point at its place, except for the rounding of some thousand steps?
bool is_at(const Vector3& x, const Vector3& place) {
  constexpr double rounding = 1e4 * std::numeric_limits<double>::epsilon();
  return (x - place).norm() <= rounding * std::max({1.0, x.norm(), place.norm()});
}

}  // namespace

void Holders::hold(const std::vector<Hold>& holds,
                   const std::vector<std::optional<double>>& strengths, const Cloth& cloth,
                   const Scalars& weights, const Points& positions) {
  const std::vector<Point> last = std::move(points_);
  points_.clear();
  for (const Hold& h : holds) {
    const auto known = std::find_if(last.begin(), last.end(),
                                    [&](const Point& p) { return p.hold.point == h.point; });
    if (known != last.end()) {
      points_.push_back(*known);
      points_.back().hold = h;
      continue;
    }
    Point p;
    p.hold = h;
    p.start = p.target = row(positions, h.point);
    points_.push_back(p);
  }
  of_holder_.assign(strengths.size(), {});
  for (std::size_t i = 0; i < points_.size(); ++i) {
    points_[i].mass = cloth.mass[points_[i].hold.point];
    of_holder_[static_cast<std::size_t>(points_[i].hold.holder)].push_back(i);
  }
  stick_distance_ = stick_share * std::min(shortest_rest_length(cloth), 1.0);
  list_springs(cloth);
  Scalars usual = borne_weights * weights;
  add_pulls_at_limit(cloth, usual);
  strengths_.clear();
  for (std::size_t k = 0; k < strengths.size(); ++k) {
    strengths_.push_back(strengths[k].value_or(usual[static_cast<Eigen::Index>(k)]));
  }
  count_slipping();
}

/// Adds by holder the pull of the springs and cells at its points that are stretched to the limit
/// [N].
void Holders::add_pulls_at_limit(const Cloth& cloth, Scalars& pulls) const {
  const auto add = [&](std::size_t point, double stiffness, double rest_length) {
    const Hold& hold = points_[point].hold;
    const double stretch = cloth.strain_limit_at(hold.point).value_or(usual_stretch);
    pulls[hold.holder] += stiffness * stretch * rest_length;
  };
  for (const Spring& s : springs_) add(s.point, s.stiffness, s.rest_length);
  for (const auto& [point, cell, corner] : cells_) {
    const std::size_t d = Cell::diagonal_of(corner);
    const double by2 = cell.gradients(cloth.rest_positions)[d].squaredNorm();
    add(point, cell.stiffness * by2, cell.diagonals(cloth.rest_positions)[d].norm());
  }
  if (cloth.is_mesh()) {
    std::vector<std::optional<std::size_t>> held(static_cast<std::size_t>(cloth.num_points()));
    for (std::size_t k = 0; k < points_.size(); ++k) {
      held[static_cast<std::size_t>(points_[k].hold.point)] = k;
    }
    for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
      for (const int end : {a, b}) {
        const auto& k = held[static_cast<std::size_t>(end)];
        if (k) add(*k, run.stiffness, run.rest_length);
      }
    });
  }
}

double Holders::force(int holder, double dt) const {
  double sum = 0;
  for (const std::size_t i : of_holder_[static_cast<std::size_t>(holder)]) {
    sum += points_[i].frame_impulse.norm() / dt;
  }
  return sum;
}

double Holders::work() const {
  double sum = 0;
  for (const Point& p : points_) sum += p.slips ? p.work : 0;
  return sum;
}

bool Holders::holds(int point) const {
  return std::any_of(points_.begin(), points_.end(),
                     [&](const Point& p) { return p.hold.point == point; });
}

std::vector<int> Holders::holder_of_points(const Cloth& cloth) const {
  std::vector<int> holders(static_cast<std::size_t>(cloth.num_points()), -1);
  for (const Point& p : points_) holders[static_cast<std::size_t>(p.hold.point)] = p.hold.holder;
  return holders;
}

void Holders::clear_rows(Points& impulses) const {
  for (const Point& p : points_) impulses.row(p.hold.point).setZero();
}

void Holders::add_end_impulses(const Cloth& cloth, double h, const Points& at_end,
                               Points& impulses) const {
  for (const Point& p : points_) {
    const int i = p.hold.point;
    impulses.row(i) += impulse_as_force(cloth, i, h) * at_end.row(i);
  }
}

void Holders::count_slipping() {
  slipping_ = static_cast<std::size_t>(
      std::count_if(points_.begin(), points_.end(), [](const Point& p) { return p.slips; }));
}

void Holders::apply(Cloth& cloth) const {
  cloth.held.assign(points_.empty() ? 0 : static_cast<std::size_t>(cloth.num_points()), 0);
  for (const Point& p : points_) {
    cloth.held[static_cast<std::size_t>(p.hold.point)] = 1;
    cloth.inv_mass[p.hold.point] = p.slips ? 1 / cloth.mass[p.hold.point] : 0;
  }
}

Vector3 Holders::velocity_now(const Point& p) const {
  return (p.target - p.start) / (dt_ - p.begun);
}

/// Place of the point on its holder now.
Vector3 Holders::place_now(const Point& p) const {
  const double left = dt_ - p.begun;
  return left > 0 ? Vector3(p.start + (elapsed_ - p.begun) / left * (p.target - p.start)) : p.start;
}

void Holders::begin_frame(const std::vector<Vector3>& targets, double dt, State& state) {
  dt_ = dt;
  elapsed_ = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    Point& p = points_[i];
    p.start = p.slips ? p.target : row(state.positions, p.hold.point);
    p.begun = 0;
    p.target = targets[i];
    p.frame_impulse.setZero();
    p.work = 0;
    if (!p.slips) state.velocities.row(p.hold.point) = (p.target - p.start).transpose() / dt;
  }
}

void Holders::end_frame(State& state) const {
  for (const Point& p : points_) {
    if (p.slips || !is_at(row(state.positions, p.hold.point), p.target)) continue;
    state.positions.row(p.hold.point) = p.target.transpose();
  }
}

void Holders::place(std::size_t hold, const Vector3& target, State& state) {
  Point& p = points_[hold];
  p.start = p.target = target;
  p.slips = false;
  state.positions.row(p.hold.point) = target.transpose();
  count_slipping();
}

void Holders::release(Point& p, double max_force, const Vector3& impulse) {
  p.slips = true;
  p.max_force = max_force;
  p.impulse = impulse;
}

bool Holders::begin_substep(double h, const Cloth& cloth,
                            const std::vector<MovingCollider>& colliders, const Points& positions) {
  elapsed_ += h;
  bool changes = false;
  for (Point& p : points_) {
    const Vector3 x = row(positions, p.hold.point);
    p.is_pressed = std::any_of(colliders.begin(), colliders.end(), [&](const MovingCollider& c) {
      return is_pressed_into(c, x, velocity_now(p), cloth.offset_at(p.hold.point));
    });
    if (!p.is_pressed || p.slips) continue;
    release(p, strengths_[static_cast<std::size_t>(p.hold.holder)], Vector3::Zero());
    changes = true;
  }
  if (changes) count_slipping();
  return changes;
}

void Holders::warm_start(const Cloth& cloth, const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  if (!any_slips()) return;
  for (Point& p : points_) {
    if (!p.slips) continue;
    const int i = p.hold.point;
    p.carried = velocity_now(p);
    p.time = Drag(cloth.damping_at(i), h_).distance;
    const Vector3 x =
        row(state.positions, i) - step.displacement_factor * step.h * row(step.drifted, i);
    const Vector3 to_place = place_now(p) - x;
    const double distance = to_place.norm();
    p.want = distance > 0 ? Vector3(std::min(1 / return_time, recovery_speed / distance) * to_place)
                          : Vector3::Zero();
    p.impulse = clamped(scale * p.impulse, p.max_force * p.time);
    state.velocities.row(i) += cloth.inv_mass[i] * p.impulse.transpose();
  }
}

double Holders::solve_pass(Points& velocities) {
  double largest = 0;
  for (Point& p : points_) {
    if (!p.slips) continue;
    const double strongest = p.max_force * p.time, returning = (1 - slip_friction) * strongest;
    // The impulse that would stop the point relative to its holder. If it pulls towards the target
    // with at least the returning strength, the point moves away.
    const Vector3 rest = p.impulse - p.mass * (row(velocities, p.hold.point) - p.carried);
    const bool leaves = rest.dot(p.want) >= 0 && rest.norm() >= returning;
    const Vector3 impulse =
        leaves ? clamped(rest, strongest) : clamped(rest + p.mass * p.want, returning);
    const Vector3 change = (impulse - p.impulse) / p.mass;
    p.impulse = impulse;
    velocities.row(p.hold.point) += change.transpose();
    largest = std::max(largest, change.norm());
  }
  return largest;
}

bool Holders::update_slipping(const Cloth& cloth, double h, const Vector3& gravity,
                              const Points& impulses, State& state) {
  for (Point& p : points_) {
    const int i = p.hold.point;
    const Vector3 v = row(state.velocities, i);
    if (p.slips) {
      p.given = -impulse_as_force(cloth, i, h) * p.impulse;
    } else {
      p.given = row(impulses, i) + h * p.mass * (gravity - cloth.damping_at(i) * v);
    }
    p.frame_impulse += p.given;
    p.work += std::abs(p.given.dot(v));
  }

  bool changes = false;
  for (Point& p : points_) {
    const Vector3 x = row(state.positions, p.hold.point), place = place_now(p);
    if (!p.slips) {
      if (is_at(x, place)) continue;
      release(p, p.max_force, -p.given);  // the cloth was in its way
    } else {
      const bool holds = p.impulse.norm() < (1 - slip_friction) * p.max_force * p.time;
      if (p.is_pressed || !holds || (place - x).norm() > stick_distance_) continue;
      p.slips = false;
      p.start = x;
      p.begun = elapsed_;
      const double left = dt_ - elapsed_;
      if (left > h / 2) state.velocities.row(p.hold.point) = (p.target - x).transpose() / left;
    }
    changes = true;
  }
  for (std::size_t k = 0; k < strengths_.size(); ++k) {
    changes = release_overloaded(of_holder_[k], strengths_[k], h) || changes;
  }
  h_ = h;
  if (changes) count_slipping();
  return changes;
}

/// Shares a holder's strength S among its points, with a common bound b on their loads F_i: sum
/// min(F_i, b) = S. Points with a higher load slip.
bool Holders::release_overloaded(const std::vector<std::size_t>& points, double strength,
                                 double h) {
  std::vector<double> loads;  // [N] of those that stick
  for (const std::size_t i : points) {
    if (!points_[i].slips) loads.push_back(points_[i].given.norm() / h);
  }
  std::sort(loads.begin(), loads.end());
  double left = strength;
  std::size_t sharers = points.size();
  for (const double load : loads) {
    if (load * static_cast<double>(sharers) > left) break;
    left -= load;
    --sharers;
  }
  const double max_force = sharers > 0 ? left / static_cast<double>(sharers) : infinity;
  bool changes = false;
  for (const std::size_t i : points) {
    Point& p = points_[i];
    p.max_force = sharers > 0 ? max_force : strength;
    if (p.slips || p.given.norm() <= max_force * h) continue;
    release(p, max_force, clamped(-p.given, max_force * h));
    changes = true;
  }
  return changes;
}

void Holders::write(MemoryWriter& memory) const {
  memory.add(h_);
  for (const Point& p : points_) {
    memory.add(p.slips);
    memory.add(p.max_force);
    memory.add(p.impulse);
    memory.add(p.target);
  }
}

std::size_t Holders::memory_size() const { return 1 + points_.size() * (1 + 1 + 3 + 3); }

void Holders::read(MemoryReader& memory) {
  h_ = std::max(0.0, memory.number());
  for (Point& p : points_) {
    p.slips = memory.index(2) == 1;
    p.max_force = std::max(0.0, memory.number());
    p.impulse = memory.vector();
    p.target = memory.vector();
  }
  count_slipping();
}

}  // namespace clothsim
