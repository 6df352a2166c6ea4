#include "clothsim/constraints/strain_limit.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/errors.h"

namespace clothsim {
namespace {

/// Fours of springs of a colour that a thread takes at least: half a microsecond of work.
constexpr int least_shared = 128;

/// Visits that it takes to look at four, see WorkBudget.
constexpr int visits_of_four = 2;

/// Violation [of a rest length] from which on a step counts for more time, in proportion, until the
/// limit yields: where springs are twice their length, patience would fling the cloth about.
constexpr double usual_violation = 0.05;

/// h omega of a tension that steps cannot follow: `auto` chooses them for 1.2 at most, and at 2 a
/// point flies from side to side.
constexpr double fastest_swing = 1.5;

/// How much of a step's doubt one that can be met takes back once the limit yields. It settles
/// where most can.
constexpr double relief = 0.1;

/// Largest h^2 omega^2 of a spring's impulses where the limit yields, of those kept and of all that
/// a step gives. Of neighbours that stay, T swings a point across its spring at omega^2 = T / (m
/// l), so that this is the kick T h / m over the speed l / h. With much more, steps swing: a point
/// has up to twelve springs. With no bound on a step's own, collider and limit outdo each other.
constexpr double most_kept_swing = 0.08;
constexpr double most_swing = 4 * most_kept_swing;

Quad quad(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2), 0}; }

void set_row(Points& points, int i, const Quad& q) {
  points(i, 0) = q.x;
  points(i, 1) = q.y;
  points(i, 2) = q.z;
}

}  // namespace

StrainLimit::StrainLimit(const Cloth& cloth, WorkBudget* budget)
    : longest_(1 + cloth.strain_limit.value()),
      shortest_(shortest_rest_length(cloth)),
      budget_(budget) {
  int direction = -1;
  const SpringRun* last = nullptr;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    const bool new_direction = !last || last->offset != run.offset || last->family != run.family;
    if (new_direction) ++direction;
    last = &run;
    // Springs of one offset share a point only where their first points differ by that offset.
    const int colour = 2 * direction + (a / run.offset) % 2;
    const double inv_mass = cloth.inv_mass[a] + cloth.inv_mass[b];
    const double mass = inv_mass > 0 ? 1 / inv_mass : 0;
    constraints_.push_back({a, b, run.rest_length, mass, cloth.inv_mass[a] * mass, colour});
  });
  assert(2 * (direction + 1) <= num_colours);

  local_.assign(index(cloth.num_points()), -1);
  has_moved_.assign(index(cloth.num_points()), 0);
  kept_.assign(constraints_.size(), 0.0);
  flags_.assign((constraints_.size() + 7) / 8 * 8, 0);
  close_active();
}

void StrainLimit::add_impulses(double scale, Points& sum) const {
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    const Constraint& c = constraints_[index(id)];
    const Vector3 impulse = scale * c.mass * s.kick[k] * Vector3(s.x[k], s.y[k], s.z[k]);
    sum.row(c.a) += impulse.transpose();
    sum.row(c.b) -= impulse.transpose();
  });
}

double StrainLimit::tension_frequency() {
  // omega^2 = sum T / (m l), with T h / m what an end takes of the kick.
  across_.assign(touched_.size() + 1, 0.0);
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const FourSprings& s = active_[i];
    for (std::size_t k = 0; k < FourSprings::count; ++k) {
      const double across = s.kick[k] / lengths_[FourSprings::count * i + k];
      const double of_a = s.share[k] * across;
      across_[index(FourSprings::point(s.a[k]))] += of_a;
      across_[index(FourSprings::point(s.b[k]))] += across - of_a;
    }
  }
  const double largest = *std::max_element(across_.begin(), across_.end());
  return step_.h > 0 ? std::sqrt(largest / step_.h) : 0;
}

bool StrainLimit::outruns_steps() { return step_.h * tension_frequency() > fastest_swing; }

void StrainLimit::learn(double violation) {
  if (violation > 0) {
    const double haste = yields() ? 1 : std::max(violation / usual_violation, 1.0);
    doubt_ = std::min(doubt_ + haste * step_.h, patience + most_doubt);
  } else {
    doubt_ = std::max(doubt_ - (yields() ? relief : 1) * step_.h, 0.0);
  }
}

double StrainLimit::insistence() const {
  return yields() ? std::exp2((patience - doubt_) / half_time) : 1;
}

void StrainLimit::take_over(StrainLimit&& last) {
  assert(constraints_.size() == last.constraints_.size());
  const StrainLimit kept = std::move(last);
  reset();
  doubt_ = kept.doubt_;
  step_ = kept.step_;
  kept.for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    const double mass = constraints_[index(id)].mass;  // perhaps another one
    const double scale = mass > 0 ? kept.constraints_[index(id)].mass / mass : 0;
    add_active(id, scale * s.kick[k], {s.x[k], s.y[k], s.z[k]});
  });
  close_active();
}

void StrainLimit::reset() {
  last_flags_.clear();
  clear_active();
  close_active();
  step_ = {};
  doubt_ = 0;
}

void StrainLimit::write(MemoryWriter& memory) const {
  memory.add(step_.h);
  memory.add(doubt_);
  std::size_t pulling = 0;
  for_each_active([&](const FourSprings& s, std::size_t k, int) { pulling += s.kick[k] > 0; });
  memory.add(static_cast<double>(pulling));
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    if (s.kick[k] <= 0) return;
    memory.add(id);
    memory.add(s.kick[k]);
    memory.add(Vector3(s.x[k], s.y[k], s.z[k]));
  });
}

void StrainLimit::read(MemoryReader& memory) {
  reset();
  step_.h = std::max(0.0, memory.number());
  doubt_ = std::clamp(memory.number(), 0.0, patience + most_doubt);
  std::pair<int, int> last{-1, -1};  // colour and id: the order of sweeps
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int id = memory.index(constraints_.size());
    const std::pair<int, int> here{constraints_[index(id)].colour, id};
    if (here <= last) {
      throw InvalidValue({"memory"}, "springs out of order", "those at their limit in order");
    }
    last = here;
    const double kick = std::max(0.0, memory.number());
    add_active(id, kick, memory.vector());
  }
  close_active();
}

void StrainLimit::predict(double h, double reach, State& state) {
  const double scale = step_.h > 0 ? h / step_.h : 0;  // the same forces over this step's length
  step_ = {h, reach, 0, insistence()};
  const double speed = yields() ? shortest_ / h : std::numeric_limits<double>::infinity();
  most_kick_ = most_swing * speed;
  for (FourSprings& s : active_) {
    for (double& kick : s.kick) kick = std::min(scale * kick, most_kept_swing * speed);
  }

  std::fill(given_.begin(), given_.end(), Quad{});
  pull_points(active_.data(), active_.size(), given_.data());
  const double way = reach * h;
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const int point = touched_[i];
    const Quad& given = given_[i];
    const Quad v = quad(state.velocities, point);
    const Quad x = quad(state.positions, point);
    predicted_[i] = {v.x + given.x, v.y + given.y, v.z + given.z, 0};
    positions_[i] = {x.x + way * given.x, x.y + way * given.y, x.z + way * given.z, 0};
    set_row(state.velocities, point, predicted_[i]);
    set_row(state.positions, point, positions_[i]);
  }
}

void StrainLimit::begin(const Cloth& cloth, double reach, State& state, const Workers& workers,
                        const Points* before) {
  turn_impulses(cloth, reach, state, workers, before);
  store(state.velocities);
}

/// Takes back what predict() has given, and gives it anew along the present directions.
void StrainLimit::turn_impulses(const Cloth& cloth, double reach, State& state,
                                const Workers& workers, const Points* before) {
  step_.reach = reach;
  solved_alone_ = false;
  if (find_active(cloth, state.positions, workers)) {
    for (std::size_t i = 0; i < touched_.size(); ++i) {
      positions_[i] = quad(state.positions, touched_[i]);
      predicted_[i] = quad(state.velocities, touched_[i]);
    }
    for (std::size_t i = 0; i < last_touched_.size(); ++i) {
      const Quad& given = last_given_[i];
      state.velocities.row(last_touched_[i]) -= Eigen::RowVector3d(given.x, given.y, given.z);
    }
    for (std::size_t i = 0; i < touched_.size(); ++i) {
      velocities_[i] = quad(state.velocities, touched_[i]);
    }
  } else {
    for (std::size_t i = 0; i < touched_.size(); ++i) {
      const Quad& from = predicted_[i];
      const Quad& given = given_[i];
      velocities_[i] = {from.x - given.x, from.y - given.y, from.z - given.z, 0};
    }
  }
  step_.active = static_cast<double>(num_active_) / static_cast<double>(constraints_.size());
  if (before) {
    before_.resize(velocities_.size());
    for (std::size_t i = 0; i < touched_.size(); ++i) before_[i] = quad(*before, touched_[i]);
  }
  aim_springs(step_, positions_.data(), predicted_.data(), before ? before_.data() : nullptr,
              lengths_.data(), active_.size(), active_.data());
  pull_points(active_.data(), active_.size(), velocities_.data());
}

/// Springs longer than their limit, and those an impulse still holds. False where they are those of
/// the last step.
bool StrainLimit::find_active(const Cloth& cloth, const Points& positions, const Workers& workers) {
  flag_longer_than(cloth, longest_, positions, workers);
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    if (s.kick[k] > 0) flags_[index(id)] = 1;
  });
  if (flags_ == last_flags_) return false;  // as ever at rest
  last_flags_ = flags_;

  for_each_active(
      [&](const FourSprings& s, std::size_t k, int id) { kept_[index(id)] = s.kick[k]; });
  last_touched_ = touched_;
  last_given_.swap(given_);
  last_ids_ = ids_;
  clear_active();
  const auto add = [&](int id) { add_active(id, kept_[index(id)], Vector3::Zero()); };
  const auto add_second_colour = [&] {
    for (const int id : second_colour_) add(id);
    second_colour_.clear();
  };
  int direction = 0;
  for_each_flagged([&](int id) {
    const Constraint& c = constraints_[index(id)];
    if (c.mass == 0) return;  // between two pins
    if (c.colour / 2 != direction) add_second_colour();
    direction = c.colour / 2;
    if (c.colour % 2 == 1) {
      second_colour_.push_back(id);
    } else {
      add(id);
    }
  });
  add_second_colour();
  close_active();
  for (const int id : last_ids_) {
    if (id >= 0) kept_[index(id)] = 0;
  }
  return true;
}

void StrainLimit::clear_active() {
  for (const int point : touched_) local_[index(point)] = -1;
  touched_.clear();
  active_.clear();
  ids_.clear();
  lengths_.clear();
  colour_ends_.clear();
  num_active_ = 0;
}

/// To be called in the order of colours.
void StrainLimit::add_active(int id, double kick, const Vector3& direction) {
  const Constraint& c = constraints_[index(id)];
  const bool new_colour = active_.empty() || c.colour != colour_;
  if (new_colour || lane_ == FourSprings::count) {
    if (new_colour && !active_.empty()) colour_ends_.push_back(static_cast<int>(active_.size()));
    active_.push_back({});
    ids_.insert(ids_.end(), FourSprings::count, -1);
    lengths_.insert(lengths_.end(), FourSprings::count, 1.0);
    colour_ = c.colour;
    lane_ = 0;
  }
  FourSprings& s = active_.back();
  s.x[lane_] = direction.x();
  s.y[lane_] = direction.y();
  s.z[lane_] = direction.z();
  s.kick[lane_] = kick;
  s.share[lane_] = c.share;
  s.a[lane_] = FourSprings::place(touch(c.a));
  s.b[lane_] = FourSprings::place(touch(c.b));
  const std::size_t place = ids_.size() - FourSprings::count + lane_;
  ids_[place] = id;
  lengths_[place] = longest_ * c.rest_length;
  ++lane_;
  ++num_active_;
}

/// Place of a point in touched_.
int StrainLimit::touch(int point) {
  int& place = local_[index(point)];
  if (place < 0) {
    place = static_cast<int>(touched_.size());
    touched_.push_back(point);
  }
  return place;
}

void StrainLimit::close_active() {
  if (!active_.empty()) colour_ends_.push_back(static_cast<int>(active_.size()));
  const std::size_t nobody = touched_.size();
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i] >= 0) continue;
    FourSprings& s = active_[i / FourSprings::count];
    const std::size_t lane = i % FourSprings::count;
    s.a[lane] = s.b[lane] = FourSprings::place(static_cast<int>(nobody));
  }
  for (std::vector<Quad>* quads : {&positions_, &predicted_, &velocities_, &given_}) {
    quads->resize(nobody + 1);
    quads->back() = {};
  }
}

void StrainLimit::store(Points& velocities) const {
  for (std::size_t i = 0; i < touched_.size(); ++i)
    set_row(velocities, touched_[i], velocities_[i]);
}

/// One pass over active_, colour by colour: within one, springs share no point. A few are not worth
/// sharing.
double StrainLimit::sweep_active(const Workers& workers) {
  if (budget_) budget_->spend(visits_of_four * static_cast<std::int64_t>(active_.size()));
  const bool are_few = active_.size() < 2 * index(least_shared) * colour_ends_.size();
  if (workers.threads() == 1 || are_few) {
    return sweep_springs(active_.data(), active_.size(), most_kick_, velocities_.data());
  }
  std::atomic<double> largest{0};
  int first = 0;
  for (const int end : colour_ends_) {
    const auto sweep_band = [&](int from, int to) {
      const double change = sweep_springs(&active_[index(first + from)], index(to - from),
                                          most_kick_, velocities_.data());
      double seen = largest;
      while (change > seen && !largest.compare_exchange_weak(seen, change)) {
      }
    };
    workers.share(end - first, sweep_band, least_shared);
    first = end;
  }
  return largest;
}

double StrainLimit::sweep(Points& velocities, const Workers& workers) {
  for (std::size_t i = 0; i < touched_.size(); ++i) velocities_[i] = quad(velocities, touched_[i]);
  const double change = sweep_active(workers);
  store(velocities);
  return step_.h * change;
}

int StrainLimit::solve(const Cloth& cloth, double reach, double enough, int least, int most,
                       State& state, const Workers& workers) {
  turn_impulses(cloth, reach, state, workers, nullptr);
  int passes = 0;
  double change = 0;
  do {
    change = step_.h * sweep_active(workers);
    ++passes;
  } while (passes < most && (passes < least || change > enough));

  const double way = step_.reach * step_.h;
  double moved2 = 0;
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const Quad& v = velocities_[i];
    const Quad& from = predicted_[i];
    Quad& x = positions_[i];
    const Quad move{way * (v.x - from.x), way * (v.y - from.y), way * (v.z - from.z), 0};
    x = {x.x + move.x, x.y + move.y, x.z + move.z, 0};
    set_row(state.positions, touched_[i], x);
    moved2 = std::max(moved2, move.x * move.x + move.y * move.y + move.z * move.z);
  }
  store(state.velocities);
  moved_ = std::sqrt(moved2);
  solved_alone_ = true;
  return passes;
}

}  // namespace clothsim
