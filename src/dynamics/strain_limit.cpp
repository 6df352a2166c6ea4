#include "clothsim/dynamics/strain_limit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/target_clones.h"

namespace clothsim {
namespace {

/// Share of a length violation that the impulses work off each step. Kept impulses integrate the
/// violation, so a large share overshoots where sweeps stop early, and worst where nearly all
/// springs are at their limit: with ks 50 on pinned2, 0.005 rings for ever, 0.002 comes to rest.
constexpr double violation_share = 0.002;

/// Largest share of its length that a spring is shortened in a step for turning: that of a turn by
/// 0.1. Beyond, the middle of a step says too little about its end.
constexpr double most_turning = 0.005;

/// Where in the tolerance correct() aims: inside, or the last bits take for ever, yet not far, or
/// springs that hold others up go slack.
constexpr double aim = 0.95;

/// A spring this many times longer than its limit is left to the impulses: to repair it at once
/// would throw its ends about.
constexpr double beyond_repair = 1.5;

/// flags[i] = 1 where spring (i, i + offset) is longer than sqrt(longest2).
CLOTHSIM_TARGET_CLONES
void check_run(const double* x, const double* y, const double* z, int offset, int count,
               double longest2, unsigned char* __restrict flags) {
  for (int i = 0; i < count; ++i) {
    const double dx = x[i + offset] - x[i];
    const double dy = y[i + offset] - y[i];
    const double dz = z[i + offset] - z[i];
    flags[i] = dx * dx + dy * dy + dz * dz > longest2;
  }
}

/// The row of an N x 3 matrix as a vector.
Vector3 row(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2)}; }

/// points_a += w_a d, points_b -= w_b d.
[[gnu::always_inline]] inline void pull_together(const Cloth& cloth, int a, int b, const Vector3& d,
                                                 Points& points) {
  const double weight_a = cloth.inv_mass[a];
  const double weight_b = cloth.inv_mass[b];
  for (int axis = 0; axis < 3; ++axis) {
    points(a, axis) += weight_a * d[axis];
    points(b, axis) -= weight_b * d[axis];
  }
}

}  // namespace

StrainLimit::StrainLimit(const Cloth& cloth) : longest_(1 + cloth.strain_limit.value()) {
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

  flags_.assign((constraints_.size() + 7) / 8 * 8, 0);
  reset();
}

void StrainLimit::add_impulses(double scale, Points& sum) const {
  for (const std::vector<Active>& springs : active_) {
    for (const Active& s : springs) {
      const Vector3 impulse = scale * impulses_[static_cast<std::size_t>(s.id)] * s.direction;
      sum.row(s.a) += impulse.transpose();
      sum.row(s.b) -= impulse.transpose();
    }
  }
}

void StrainLimit::take_over(StrainLimit&& last) {
  assert(constraints_.size() == last.constraints_.size());
  impulses_ = std::move(last.impulses_);
  active_ = std::move(last.active_);
  h_ = last.h_;
}

void StrainLimit::reset() {
  impulses_.assign(constraints_.size(), 0.0);
  for (std::vector<Active>& springs : active_) springs.clear();
  h_ = 0;
}

void StrainLimit::write(MemoryWriter& memory) const {
  memory.add(h_);
  const auto kept = [](double impulse) { return impulse != 0; };
  memory.add(static_cast<double>(std::count_if(impulses_.begin(), impulses_.end(), kept)));
  for (std::size_t id = 0; id < impulses_.size(); ++id) {
    if (!kept(impulses_[id])) continue;
    memory.add(static_cast<double>(id));
    memory.add(impulses_[id]);
  }
  for (const std::vector<Active>& springs : active_) {
    memory.add(static_cast<double>(springs.size()));
    for (const Active& s : springs) {
      memory.add(s.id);
      memory.add(s.direction);
    }
  }
}

void StrainLimit::read(MemoryReader& memory) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int id = memory.index(impulses_.size());
    impulses_[static_cast<std::size_t>(id)] = std::max(0.0, memory.number());
  }
  for (std::vector<Active>& springs : active_) {
    for (std::size_t left = memory.count(); left > 0; --left) {
      const int id = memory.index(constraints_.size());
      const Constraint& c = constraints_[static_cast<std::size_t>(id)];
      springs.push_back({id, c.a, c.b, c.inv_mass, memory.vector(), 0});
    }
  }
}

void StrainLimit::predict(const Cloth& cloth, double h, double reach, State& state) {
  const double scale = h_ > 0 ? h / h_ : 0;  // the same forces over this step's length
  h_ = h;
  for (const std::vector<Active>& springs : active_) {
    for (const Active& s : springs) {
      double& impulse = impulses_[static_cast<std::size_t>(s.id)];
      if (impulse == 0) continue;
      impulse *= scale;
      pull_together(cloth, s.a, s.b, impulse * s.direction, state.velocities);
      pull_together(cloth, s.a, s.b, reach * h * impulse * s.direction, state.positions);
    }
  }
}

void StrainLimit::begin(const Cloth& cloth, double reach, State& state) {
  // Springs longer than their limit, and those an impulse still holds.
  flag_longer_than(cloth, longest_, state.positions);
  last_active_.swap(active_);
  for (const std::vector<Active>& springs : last_active_) {
    for (const Active& s : springs) {
      if (impulses_[static_cast<std::size_t>(s.id)] > 0) flags_[static_cast<std::size_t>(s.id)] = 1;
    }
  }

  // How fast each may still lengthen: up to its limit within a step, or shorter if it is over. A
  // spring that turns at speed v across grows by h^2 v^2 / 2 l in a step if it may not lengthen in
  // the middle of it: half its centripetal acceleration v^2 / l over h makes up for that.
  for (std::vector<Active>& springs : active_) springs.clear();
  for_each_flagged([&](int id) {
    const Constraint& c = constraints_[static_cast<std::size_t>(id)];
    if (c.inv_mass == 0) return;  // between two pins
    // Where the ends were when the step's impulses act: there they make no angular momentum.
    const Vector3 speed = row(state.velocities, c.b) - row(state.velocities, c.a);
    const Vector3 d = row(state.positions, c.b) - row(state.positions, c.a) - reach * h_ * speed;
    const double length = d.norm();
    if (length == 0) return;  // slack, and no direction to hold
    const Vector3 direction = d / length;
    const double across2 = (speed - speed.dot(direction) * direction).squaredNorm();
    const double excess = length - longest_ * c.rest_length;
    const double fastest = (excess > 0 ? violation_share : 1.0) * -excess / h_ -
                           std::min(h_ * across2 / (2 * length), most_turning * length / h_);
    active_[static_cast<std::size_t>(c.colour)].push_back(
        {id, c.a, c.b, c.inv_mass, direction, fastest});
  });

  // Turn the impulses.
  for (const std::vector<Active>& springs : last_active_) {
    for (const Active& s : springs) {
      const double impulse = impulses_[static_cast<std::size_t>(s.id)];
      if (impulse > 0) pull_together(cloth, s.a, s.b, -impulse * s.direction, state.velocities);
    }
  }
  for (const std::vector<Active>& springs : active_) {
    for (const Active& s : springs) {
      const double impulse = impulses_[static_cast<std::size_t>(s.id)];
      if (impulse > 0) pull_together(cloth, s.a, s.b, impulse * s.direction, state.velocities);
    }
  }
}

double StrainLimit::sweep(const Cloth& cloth, Points& velocities) {
  double residual = 0;
  for (const std::vector<Active>& springs : active_) {
    for (const Active& s : springs) {
      double& impulse = impulses_[static_cast<std::size_t>(s.id)];
      const double rate = s.direction.dot(row(velocities, s.b) - row(velocities, s.a));
      const double change = std::max(-impulse, (rate - s.fastest) / s.inv_mass);
      if (change == 0) continue;
      impulse += change;
      pull_together(cloth, s.a, s.b, change * s.direction, velocities);
      residual = std::max(residual, std::abs(change) * s.inv_mass * h_);
    }
  }
  return residual;
}

int StrainLimit::correct(const Cloth& cloth, double tolerance, int max_sweeps, Points& positions) {
  int sweeps = 0;
  while (sweeps < max_sweeps) {
    // All springs are checked, those over the limit are swept until they hold.
    flag_longer_than(cloth, longest_ + tolerance, positions);
    for (std::vector<int>& ids : over_) ids.clear();
    bool any = false;
    for_each_flagged([&](int id) {
      const Constraint& c = constraints_[static_cast<std::size_t>(id)];
      if (c.inv_mass == 0) return;
      const Vector3 d = row(positions, c.b) - row(positions, c.a);
      if (d.norm() > beyond_repair * longest_ * c.rest_length) return;
      over_[static_cast<std::size_t>(c.colour)].push_back(id);
      any = true;
    });
    if (!any) break;

    for (bool moved = true; moved && sweeps < max_sweeps; ++sweeps) {
      moved = false;
      for (const std::vector<int>& ids : over_) {
        for (const int id : ids) {
          const Constraint& c = constraints_[static_cast<std::size_t>(id)];
          const Vector3 d = row(positions, c.b) - row(positions, c.a);
          const double length = d.norm();
          if (length <= (longest_ + tolerance) * c.rest_length) continue;
          if (length > beyond_repair * longest_ * c.rest_length) continue;
          const double excess = length - (longest_ + aim * tolerance) * c.rest_length;
          pull_together(cloth, c.a, c.b, excess / (c.inv_mass * length) * d, positions);
          moved = true;
        }
      }
    }
  }
  return sweeps;
}

void StrainLimit::flag_longer_than(const Cloth& cloth, double stretch, const Points& positions) {
  const std::vector<SpringRun>& runs = cloth.springs;
  std::size_t id = 0;
  for (std::size_t first = 0, last = 0; first < runs.size(); first = last) {
    // Runs of one direction are checked as one, long enough for the widest vectors.
    const SpringRun& front = runs[first];
    int end = front.first;
    for (; last < runs.size(); ++last) {
      const SpringRun& run = runs[last];
      const bool same = run.offset == front.offset && run.rest_length == front.rest_length;
      if (!same || run.first < end) break;
      end = run.first + run.count;
    }
    const double longest = stretch * front.rest_length;
    over_length_.resize(static_cast<std::size_t>(cloth.num_points()));
    check_run(&positions(front.first, 0), &positions(front.first, 1), &positions(front.first, 2),
              front.offset, end - front.first, longest * longest, over_length_.data());

    // What lies between the runs is no spring.
    for (std::size_t i = first; i < last; ++i) {
      const auto from = over_length_.begin() + (runs[i].first - front.first);
      std::copy(from, from + runs[i].count, flags_.begin() + static_cast<std::ptrdiff_t>(id));
      id += static_cast<std::size_t>(runs[i].count);
    }
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
