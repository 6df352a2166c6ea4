#include "clothsim/dynamics/strain_limit.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <utility>

#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Springs of a colour that a thread takes at least: a microsecond of work.
constexpr int least_shared = 512;

Quad quad(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2), 0}; }

void set_row(Points& points, int i, const Quad& q) {
  points(i, 0) = q.x;
  points(i, 1) = q.y;
  points(i, 2) = q.z;
}

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

StrainLimit::StrainLimit(const Cloth& cloth)
    : longest_(1 + cloth.strain_limit.value()), shortest_(shortest_rest_length(cloth)) {
  int direction = -1;
  const SpringRun* last = nullptr;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const bool new_direction = !last || last->offset != run.offset || last->family != run.family;
    if (new_direction) ++direction;
    last = &run;
    // Springs of one offset share a point only where their first points differ by that offset.
    const int colour = 2 * direction + (a / run.offset) % 2;
    constraints_.push_back({a, b, run.rest_length, cloth.inv_mass[a] + cloth.inv_mass[b], colour});
  });
  assert(2 * (direction + 1) <= num_colours);

  const std::size_t points = index(cloth.num_points());
  positions_.resize(points);
  predicted_.resize(points);
  velocities_.resize(points);
  given_.assign(points, Quad{});
  is_touched_.assign(points, 0);
  across_.assign(points, 0.0);
  kept_.assign(constraints_.size(), 0.0);
  flags_.assign((constraints_.size() + 7) / 8 * 8, 0);
}

void StrainLimit::add_impulses(double scale, Points& sum) const {
  for (const LimitedSpring& s : active_) {
    const Vector3 impulse =
        scale * s.impulse * Vector3(s.direction.x, s.direction.y, s.direction.z);
    sum.row(s.a) += impulse.transpose();
    sum.row(s.b) -= impulse.transpose();
  }
}

double StrainLimit::tension_frequency(const Cloth& cloth) {
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const LimitedSpring& s = active_[i];
    const double across = s.impulse / lengths_[i];
    across_[index(s.a)] += across;
    across_[index(s.b)] += across;
  }
  double omega2 = 0;
  for (const int point : touched_) {
    double& across = across_[index(point)];
    omega2 = std::max(omega2, across * cloth.inv_mass[point]);
    across = 0;
  }
  return step_.h > 0 ? std::sqrt(omega2 / step_.h) : 0;
}

void StrainLimit::take_over(StrainLimit&& last) {
  assert(constraints_.size() == last.constraints_.size());
  active_ = std::move(last.active_);
  ids_ = std::move(last.ids_);
  lengths_ = std::move(last.lengths_);
  touched_ = std::move(last.touched_);
  step_ = last.step_;
}

void StrainLimit::reset() {
  last_flags_.clear();
  active_.clear();
  ids_.clear();
  lengths_.clear();
  touched_.clear();
  step_ = {};
}

void StrainLimit::write(MemoryWriter& memory) const {
  memory.add(step_.h);
  const auto pulls = [](const LimitedSpring& s) { return s.impulse > 0; };
  memory.add(static_cast<double>(std::count_if(active_.begin(), active_.end(), pulls)));
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const LimitedSpring& s = active_[i];
    if (!pulls(s)) continue;
    memory.add(ids_[i]);
    memory.add(s.impulse);
    memory.add(Vector3(s.direction.x, s.direction.y, s.direction.z));
  }
}

void StrainLimit::read(MemoryReader& memory) {
  reset();
  step_.h = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int id = memory.index(constraints_.size());
    add_active(id, std::max(0.0, memory.number()));
    const Vector3 direction = memory.vector();
    active_.back().direction = {direction.x(), direction.y(), direction.z(), 0};
  }
  for (const int point : touched_) is_touched_[index(point)] = 0;
}

void StrainLimit::predict(const Cloth& cloth, double h, double reach, State& state) {
  const double scale = step_.h > 0 ? h / step_.h : 0;  // the same forces over this step's length
  step_ = {h, reach, 0};
  for (LimitedSpring& s : active_) s.impulse *= scale;

  for (const int point : touched_) given_[index(point)] = {0, 0, 0, cloth.inv_mass[point]};
  pull_points(active_.data(), active_.size(), given_.data());
  for (const int point : touched_) {
    const Quad& given = given_[index(point)];
    const double way = reach * h;
    state.velocities(point, 0) += given.x;
    state.velocities(point, 1) += given.y;
    state.velocities(point, 2) += given.z;
    state.positions(point, 0) += way * given.x;
    state.positions(point, 1) += way * given.y;
    state.positions(point, 2) += way * given.z;
  }
}

void StrainLimit::begin(const Cloth& cloth, double reach, State& state) {
  step_.reach = reach;
  solved_alone_ = false;
  find_active(cloth, state);
  step_.active = static_cast<double>(active_.size()) / static_cast<double>(constraints_.size());

  // Take back what predict() has given, and give it anew along the present directions.
  aim_springs(step_, positions_.data(), predicted_.data(), lengths_.data(), active_.size(),
              active_.data());
  for (const int point : touched_) {
    const std::size_t i = index(point);
    const Quad& from = predicted_[i];
    Quad& given = given_[i];
    velocities_[i] = {from.x - given.x, from.y - given.y, from.z - given.z, cloth.inv_mass[point]};
    given = {};
  }
  for (const int point : last_touched_) {
    Quad& given = given_[index(point)];
    state.velocities.row(point) -= Eigen::RowVector3d(given.x, given.y, given.z);
    given = {};
  }
  pull_points(active_.data(), active_.size(), velocities_.data());
  store(state.velocities);
}

/// Springs longer than their limit, and those an impulse still holds.
void StrainLimit::find_active(const Cloth& cloth, const State& state) {
  flag_longer_than(cloth, longest_, state.positions);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if (active_[i].impulse > 0) flags_[index(ids_[i])] = 1;
  }
  if (flags_ == last_flags_) {  // as ever at rest
    last_touched_.clear();
    load_points(state);
    return;
  }
  last_flags_ = flags_;

  for (std::size_t i = 0; i < active_.size(); ++i) kept_[index(ids_[i])] = active_[i].impulse;
  last_touched_.swap(touched_);
  last_ids_.swap(ids_);
  active_.clear();
  ids_.clear();
  lengths_.clear();
  touched_.clear();
  const auto add = [&](int id) { add_active(id, kept_[index(id)]); };
  const auto add_second_colour = [&] {
    for (const int id : second_colour_) add(id);
    second_colour_.clear();
  };
  int direction = 0;
  for_each_flagged([&](int id) {
    const Constraint& c = constraints_[index(id)];
    if (c.inv_mass == 0) return;  // between two pins
    if (c.colour / 2 != direction) add_second_colour();
    direction = c.colour / 2;
    if (c.colour % 2 == 1) {
      second_colour_.push_back(id);
    } else {
      add(id);
    }
  });
  add_second_colour();
  for (const int id : last_ids_) kept_[index(id)] = 0;

  colour_ends_.clear();
  const auto colour_of = [&](std::size_t i) { return constraints_[index(ids_[i])].colour; };
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const bool is_last = i + 1 == ids_.size() || colour_of(i + 1) != colour_of(i);
    if (is_last) colour_ends_.push_back(static_cast<int>(i + 1));
  }

  for (const int point : touched_) is_touched_[index(point)] = 0;
  load_points(state);
}

void StrainLimit::load_points(const State& state) {
  for (const int point : touched_) {
    positions_[index(point)] = quad(state.positions, point);
    predicted_[index(point)] = quad(state.velocities, point);
  }
}

void StrainLimit::add_active(int id, double impulse) {
  const Constraint& c = constraints_[index(id)];
  active_.push_back({{}, impulse, 1 / c.inv_mass, 0, c.a, c.b});
  ids_.push_back(id);
  lengths_.push_back(longest_ * c.rest_length);
  for (const int point : {c.a, c.b}) {
    if (is_touched_[index(point)]) continue;
    is_touched_[index(point)] = 1;
    touched_.push_back(point);
  }
}

void StrainLimit::store(Points& velocities) const {
  for (const int point : touched_) set_row(velocities, point, velocities_[index(point)]);
}

/// One pass over active_, colour by colour: within one, springs share no point. A few are not worth
/// sharing.
double StrainLimit::sweep_active(const Workers& workers) {
  const bool are_few = active_.size() < 2 * index(least_shared) * colour_ends_.size();
  if (workers.threads() == 1 || are_few) {
    return sweep_springs(active_.data(), active_.size(), velocities_.data());
  }
  std::atomic<double> largest{0};
  int first = 0;
  for (const int end : colour_ends_) {
    const auto sweep_band = [&](int from, int to) {
      const double change =
          sweep_springs(&active_[index(first + from)], index(to - from), velocities_.data());
      double seen = largest;
      while (change > seen && !largest.compare_exchange_weak(seen, change)) {
      }
    };
    workers.share(end - first, sweep_band, least_shared);
    first = end;
  }
  return largest;
}

double StrainLimit::sweep(const Cloth& cloth, Points& velocities, const Workers& workers) {
  for (const int point : touched_) {
    Quad& v = velocities_[index(point)];
    v = quad(velocities, point);
    v.w = cloth.inv_mass[point];
  }
  const double change = sweep_active(workers);
  store(velocities);
  return step_.h * change;
}

int StrainLimit::solve(double enough, int least, int most, State& state, const Workers& workers) {
  int passes = 0;
  double change = 0;
  do {
    change = step_.h * sweep_active(workers);
    ++passes;
  } while (passes < most && (passes < least || change > enough));

  const double way = step_.reach * step_.h;
  double moved2 = 0;
  for (const int point : touched_) {
    const std::size_t i = index(point);
    const Quad& v = velocities_[i];
    const Quad& from = predicted_[i];
    Quad& x = positions_[i];
    const Quad move{way * (v.x - from.x), way * (v.y - from.y), way * (v.z - from.z), 0};
    x = {x.x + move.x, x.y + move.y, x.z + move.z, 0};
    set_row(state.positions, point, x);
    moved2 = std::max(moved2, move.x * move.x + move.y * move.y + move.z * move.z);
  }
  store(state.velocities);
  moved_ = std::sqrt(moved2);
  solved_alone_ = true;
  return passes;
}

}  // namespace clothsim
