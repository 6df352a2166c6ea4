// Projection of positions: violations that the impulses of strain_limit.cpp leave.

#include <algorithm>
#include <numeric>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/springs.h"

namespace clothsim {
namespace {

/// Springs longer than this multiple of their limit are left to the impulses: a projection at once
/// would throw their ends about.
constexpr double max_projected_ratio = 1.5;

/// points_a += w_a d, points_b -= w_b d.
void pull_together(const Cloth& cloth, int a, int b, const Vector3& d, Points& points) {
  const double weight_a = cloth.inv_mass[a];
  const double weight_b = cloth.inv_mass[b];
  for (int axis = 0; axis < 3; ++axis) {
    points(a, axis) += weight_a * d[axis];
    points(b, axis) -= weight_b * d[axis];
  }
}

}  // namespace

/// Do the springs hold their limit after solve()? Inactive springs were within it, and have grown
/// by the displacements of their ends at most.
bool StrainLimit::holds(double tolerance) const {
  return solved_alone_ && 2 * moved_ <= tolerance * shortest_ &&
         !any_longer(active_.data(), lengths_.data(), fours(), 1 + tolerance / (1 + most_limit_),
                     positions_.data());
}

int StrainLimit::project_positions(const Cloth& cloth, double tolerance, int max_passes,
                                   Points& positions, const Workers& workers) {
  if (yields_ || is_slack() || holds(tolerance)) return 0;
  flag_beyond_limit_by(tolerance, positions, workers);
  bool any = false;
  for_each_flagged([&](int id) { any = add_over(cloth, id, tolerance, positions) || any; });

  int passes = 0;
  while (any && passes < max_passes) {
    // Passes over the springs above the limit until they hold it; then a check of those that share
    // a point with one that has moved.
    for (bool moves = true; moves && passes < max_passes; ++passes) {
      moves = false;
      for (const std::vector<int>& ids : over_) {
        if (budget_) budget_->spend(static_cast<std::int64_t>(ids.size()));
        moves = project_springs(cloth, ids, tolerance, positions, workers) || moves;
      }
    }
    any = find_over_again(cloth, tolerance, positions);
  }
  for (std::vector<int>& ids : over_) ids.clear();
  return passes;
}

bool StrainLimit::is_beyond_repair(double violation) const {
  return violation > (max_projected_ratio - 1) * (1 + least_limit_);
}

/// Lists a spring if it needs projection. Returns whether it does.
bool StrainLimit::add_over(const Cloth& cloth, int id, double tolerance, const Points& positions) {
  const Constraint c = constraint(id);
  if (cloth.inv_mass[c.a] + cloth.inv_mass[c.b] == 0 || !is_limited(id)) return false;
  const double length2 = (row(positions, c.b) - row(positions, c.a)).squaredNorm();
  const double longest = (c.longest + tolerance) * c.rest_length;
  const double farthest = max_projected_ratio * c.longest * c.rest_length;
  if (length2 <= longest * longest || length2 > farthest * farthest) return false;
  over_[index(c.colour)].push_back(id);
  return true;
}

/// Shortens those of `ids`, of one colour, that are over their limit. Returns whether there were
/// any.
bool StrainLimit::project_springs(const Cloth& cloth, const std::vector<int>& ids, double tolerance,
                                  Points& positions, const Workers& workers) {
  projected_.assign(ids.size(), 0);
  const auto project_band = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Constraint c = constraint(ids[index(i)]);
      const Vector3 d = row(positions, c.b) - row(positions, c.a);
      const double length = d.norm();
      if (length <= (c.longest + tolerance) * c.rest_length) continue;
      const double target = c.longest + tolerance - tolerance / tolerance_per_residual;
      const double excess = length - target * c.rest_length;
      const double mass = 1 / (cloth.inv_mass[c.a] + cloth.inv_mass[c.b]);
      pull_together(cloth, c.a, c.b, mass * excess / length * d, positions);
      projected_[index(i)] = 1;
    }
  };
  workers.parallel_for(static_cast<int>(ids.size()), project_band, near_at_once);

  bool any = false;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!projected_[i]) continue;
    any = true;
    const Constraint c = constraint(ids[i]);
    for (const int point : {c.a, c.b}) {
      if (has_moved_[index(point)]) continue;
      has_moved_[index(point)] = 1;
      moved_points_.push_back(point);
    }
  }
  return any;
}

/// Lists the springs over their limit at points that have moved since the last time. Returns
/// whether there are any.
bool StrainLimit::find_over_again(const Cloth& cloth, double tolerance, const Points& positions) {
  if (first_spring_.empty()) list_springs_of_points(cloth);
  for (std::vector<int>& ids : over_) ids.clear();
  bool any = false;
  for (const int point : moved_points_) {
    has_moved_[index(point)] = 0;
    for (int i = first_spring_[index(point)]; i < first_spring_[index(point + 1)]; ++i) {
      any = add_over(cloth, springs_of_points_[index(i)], tolerance, positions) || any;
    }
  }
  moved_points_.clear();
  for (std::vector<int>& ids : over_) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  }
  return any;
}

void StrainLimit::list_springs_of_points(const Cloth& cloth) {
  const auto for_each_end = [&](auto&& visit) {
    for (int id = 0; id < Piece::length * static_cast<int>(pieces_.size()); ++id) {
      if (id % Piece::length >= pieces_[index(id / Piece::length)].count) continue;
      const Constraint c = constraint(id);
      visit(id, c.a);
      visit(id, c.b);
    }
  };
  first_spring_.assign(index(cloth.num_points()) + 1, 0);
  for_each_end([&](int, int point) { ++first_spring_[index(point) + 1]; });
  std::partial_sum(first_spring_.begin(), first_spring_.end(), first_spring_.begin());
  springs_of_points_.resize(2 * index(num_springs_));
  std::vector<int> next(first_spring_.begin(), first_spring_.end() - 1);
  for_each_end([&](int id, int point) { springs_of_points_[index(next[index(point)]++)] = id; });
}

void StrainLimit::flag_beyond_limit_by(double stretch, const Points& positions,
                                       const Workers& workers) {
  const auto look = [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const int i = order_[index(k)];
      const Piece& piece = pieces_[index(i)];
      const double longest = (piece.longest + stretch) * piece.rest_length;
      flags_[index(i)] =
          limited_[index(i)] & longer_bits(&positions(piece.first, 0), &positions(piece.first, 1),
                                           &positions(piece.first, 2), piece.offset, piece.count,
                                           longest * longest);
    }
  };
  workers.parallel_for(static_cast<int>(order_.size()), look, near_at_once / Piece::length);
}

}  // namespace clothsim
