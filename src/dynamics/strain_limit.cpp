#include "clothsim/dynamics/strain_limit.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Where in the tolerance correct() aims: inside, or the last bits take for ever, yet not far, or
/// springs that hold others up go slack.
constexpr double aim = 0.95;

/// A spring this many times longer than its limit is left to the impulses: to repair it at once
/// would throw its ends about.
constexpr double beyond_repair = 1.5;

/// Neighbours in the order of points that are looked at together.
constexpr int patch = 64;

/// Springs of a colour that a thread takes at least: a microsecond of work.
constexpr int least_shared = 512;

/// The row of an N x 3 matrix as a vector.
Vector3 row(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2)}; }

Quad quad(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2), 0}; }

void set_row(Points& points, int i, const Quad& q) {
  points(i, 0) = q.x;
  points(i, 1) = q.y;
  points(i, 2) = q.z;
}

/// points_a += w_a d, points_b -= w_b d.
void pull_together(const Cloth& cloth, int a, int b, const Vector3& d, Points& points) {
  const double weight_a = cloth.inv_mass[a];
  const double weight_b = cloth.inv_mass[b];
  for (int axis = 0; axis < 3; ++axis) {
    points(a, axis) += weight_a * d[axis];
    points(b, axis) -= weight_b * d[axis];
  }
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

/// One pass over active_, colour by colour: within one, springs share no point.
double StrainLimit::sweep_active(const Workers& workers) {
  if (workers.threads() == 1) {
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

/// Do the springs hold their limit after solve()? Those that it has not swept were within it, and
/// are longer by what their ends have moved at most.
bool StrainLimit::holds(double tolerance) const {
  return solved_alone_ && 2 * moved_ <= tolerance * shortest_ &&
         !any_longer(active_.data(), lengths_.data(), active_.size(), 1 + tolerance / longest_,
                     positions_.data());
}

int StrainLimit::correct(const Cloth& cloth, double tolerance, int max_sweeps, Points& positions) {
  if (holds(tolerance)) return 0;
  int sweeps = 0;
  while (sweeps < max_sweeps) {
    // All springs are checked, later those whose ends may have moved since; those over the limit
    // are swept until they hold.
    if (sweeps == 0) {
      flag_longer_than(cloth, longest_ + tolerance, positions);
    } else {
      flag_moved_longer_than(cloth, longest_ + tolerance, positions);
    }
    has_moved_.assign(index(cloth.num_points() / patch + 1), 0);
    for (std::vector<int>& ids : over_) ids.clear();
    bool any = false;
    for_each_flagged([&](int id) {
      const Constraint& c = constraints_[index(id)];
      if (c.inv_mass == 0) return;
      const Vector3 d = row(positions, c.b) - row(positions, c.a);
      if (d.norm() > beyond_repair * longest_ * c.rest_length) return;
      over_[index(c.colour)].push_back(id);
      any = true;
    });
    if (!any) break;

    for (bool moved = true; moved && sweeps < max_sweeps; ++sweeps) {
      moved = false;
      for (const std::vector<int>& ids : over_) {
        for (const int id : ids) {
          const Constraint& c = constraints_[index(id)];
          const Vector3 d = row(positions, c.b) - row(positions, c.a);
          const double length = d.norm();
          if (length <= (longest_ + tolerance) * c.rest_length) continue;
          if (length > beyond_repair * longest_ * c.rest_length) continue;
          const double excess = length - (longest_ + aim * tolerance) * c.rest_length;
          pull_together(cloth, c.a, c.b, excess / (c.inv_mass * length) * d, positions);
          has_moved_[index(c.a / patch)] = has_moved_[index(c.b / patch)] = 1;
          moved = true;
        }
      }
    }
  }
  return sweeps;
}

void StrainLimit::flag_longer_than(const Cloth& cloth, double stretch, const Points& positions) {
  over_length_.resize(index(cloth.num_points()));
  auto flags = flags_.begin();
  for_each_band(cloth, [&](const SpringBand& band) {
    const int a = band.first();
    const double longest = stretch * band.begin->rest_length;
    flag_longer(&positions(a, 0), &positions(a, 1), &positions(a, 2), band.begin->offset,
                band.count(), longest * longest, over_length_.data());
    for (const SpringRun* run = band.begin; run != band.end; ++run) {
      flags = std::copy_n(over_length_.begin() + (run->first - a), run->count, flags);
    }
  });
}

void StrainLimit::flag_moved_longer_than(const Cloth& cloth, double stretch,
                                         const Points& positions) {
  std::fill(flags_.begin(), flags_.end(), 0);
  const auto has_moved = [&](int point) { return has_moved_[index(point / patch)] != 0; };
  unsigned char* flags = flags_.data();
  for (const SpringRun& run : cloth.springs) {
    const double longest = stretch * run.rest_length;
    const int end = run.first + run.count;
    for (int a = run.first, next = a; a < end; a = next) {
      next = std::min(end, (a / patch + 1) * patch);
      const int b = a + run.offset;
      if (!has_moved(a) && !has_moved(b) && !has_moved(next - 1 + run.offset)) continue;
      flag_longer(&positions(a, 0), &positions(a, 1), &positions(a, 2), run.offset, next - a,
                  longest * longest, flags + (a - run.first));
    }
    flags += run.count;
  }
}

template <typename Visitor>
void StrainLimit::for_each_flagged(Visitor&& visit) const {
  // Most springs are slack: look at eight flags at a time.
  for (std::size_t word = 0; word < flags_.size(); word += 8) {
    std::uint64_t any;
    std::memcpy(&any, &flags_[word], sizeof any);
    if (any == 0) continue;
    for (std::size_t id = word; id < word + 8; ++id) {
      if (flags_[id]) visit(static_cast<int>(id));
    }
  }
}

}  // namespace clothsim
