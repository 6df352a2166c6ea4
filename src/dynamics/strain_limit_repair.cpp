// Repairs of positions: what the impulses of strain_limit.cpp have left over.

#include <algorithm>

#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/strain_limit.h"

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
      if (c.mass == 0) return;
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
          pull_together(cloth, c.a, c.b, c.mass * excess / length * d, positions);
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

}  // namespace clothsim
