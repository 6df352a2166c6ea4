#include "clothsim/dynamics/xpbd_lines.h"

#include <algorithm>
#include <utility>

#include "clothsim/dynamics/drag.h"
#include "clothsim/dynamics/springs.h"
#include "line_kernels.h"

namespace clothsim {
namespace {

struct Spring {
  int a;
  int b;
  double rest_length;  // [m]
  double compliance;   // 1 / (k h^2) [m/J]
};

/// Springs of one offset, no two of which begin at the same point.
struct Direction {
  int offset;
  std::vector<int> of_point;  // the spring that begins there; -1: none
};

std::vector<Direction> directions_of(const std::vector<Spring>& springs, int points) {
  std::vector<Direction> all;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto a = static_cast<std::size_t>(springs[s].a);
    const int offset = springs[s].b - springs[s].a;
    auto found = std::find_if(all.begin(), all.end(), [&](const Direction& d) {
      return d.offset == offset && d.of_point[a] < 0;
    });
    if (found == all.end()) {
      found = all.insert(found, {offset, std::vector<int>(static_cast<std::size_t>(points), -1)});
    }
    found->of_point[a] = static_cast<int>(s);
  }
  return all;
}

/// Its lines, each by the numbers of its springs, the longest first.
std::vector<std::vector<int>> lines_of(const Direction& direction) {
  const std::vector<int>& springs = direction.of_point;
  const auto offset = static_cast<std::size_t>(direction.offset);
  std::vector<std::vector<int>> lines;
  for (std::size_t first = 0; first < springs.size(); ++first) {
    const bool begins = first < offset || springs[first - offset] < 0;
    if (!begins || springs[first] < 0) continue;
    lines.emplace_back();
    for (std::size_t i = first; i < springs.size() && springs[i] >= 0; i += offset) {
      lines.back().push_back(springs[i]);
    }
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return lines;
}

constexpr std::size_t lanes = num_lanes;

/// Springs that a thread solves at least.
constexpr std::size_t springs_a_band = 1024;

}  // namespace

/// Numbers of the solution of one bundle, by point or spring along its lines.
struct XpbdLines::Scratch {
  LineRows rows(Bundle& bundle) {
    const std::size_t springs = bundle.springs();
    std::vector<Lanes>* const all[] = {&at[0],  &at[1],     &at[2],    &u[0],     &u[1],
                                       &u[2],   &moves[0],  &moves[1], &moves[2], &lengths,
                                       &pivots, &couplings, &changes};
    for (std::vector<Lanes>* numbers : all) {
      if (numbers->size() <= springs) numbers->resize(springs + 1);
    }
    return {static_cast<int>(springs),
            bundle.points.data(),
            bundle.inv_mass.data(),
            bundle.compliance.data(),
            bundle.target.data(),
            bundle.lambda.data(),
            {at[0].data(), at[1].data(), at[2].data()},
            {u[0].data(), u[1].data(), u[2].data()},
            {moves[0].data(), moves[1].data(), moves[2].data()},
            lengths.data(),
            pivots.data(),
            couplings.data(),
            changes.data()};
  }

  Axes<std::vector<Lanes>> at;
  Axes<std::vector<Lanes>> u;
  Axes<std::vector<Lanes>> moves;
  std::vector<Lanes> lengths;
  std::vector<Lanes> pivots;
  std::vector<Lanes> couplings;
  std::vector<Lanes> changes;
};

void XpbdLines::clear() {
  bundles_.clear();
  direction_ends_.clear();
}

void XpbdLines::build(const Cloth& cloth, double h) {
  clear();
  const double time2 = h * Drag(cloth.damping, h).distance;
  const double damped = 1 + cloth.internal_damping[0] / h;
  std::vector<Spring> springs;
  for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
    if (run.stiffness == 0) return;
    springs.push_back({a, b, run.rest_length, 1 / (run.stiffness * damped * time2)});
  });
  for (const Direction& direction : directions_of(springs, cloth.num_points())) {
    const std::vector<std::vector<int>> lines = lines_of(direction);
    for (std::size_t first = 0, next; first < lines.size(); first = next) {
      const std::size_t length = lines[first].size();
      next = first;
      while (next < lines.size() && next < first + lanes && lines[next].size() == length) ++next;
      const std::vector<Lanes> zeros(length);
      Bundle bundle{next - first,
                    std::vector<LanePoints>(length + 1),
                    std::vector<Lanes>(length + 1),
                    zeros,
                    zeros,
                    zeros,
                    zeros,
                    false};
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const std::vector<int>& line = lines[lane < bundle.lines ? first + lane : first];
        for (std::size_t k = 0; k < length; ++k) {
          const Spring& spring = springs[static_cast<std::size_t>(line[k])];
          bundle.points[k][lane] = spring.a;
          bundle.points[k + 1][lane] = spring.b;
          bundle.rest_length[k][lane] = bundle.target[k][lane] = spring.rest_length;
          bundle.compliance[k][lane] = spring.compliance;
        }
        for (std::size_t k = 0; k <= length; ++k) {
          const double inv_mass = cloth.inv_mass[bundle.points[k][lane]];
          bundle.inv_mass[k][lane] = inv_mass;
          bundle.is_held = bundle.is_held || inv_mass == 0;
        }
      }
      bundles_.push_back(std::move(bundle));
    }
    direction_ends_.push_back(static_cast<int>(bundles_.size()));
  }
}

void XpbdLines::set_targets(const Points& positions, double damping, double h) {
  const double share = damping / h;
  for (Bundle& bundle : bundles_) {
    for (std::size_t k = 0; k < bundle.springs(); ++k) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const int a = bundle.points[k][lane], b = bundle.points[k + 1][lane];
        const double past = (positions.row(b) - positions.row(a)).norm();
        bundle.target[k][lane] = (bundle.rest_length[k][lane] + share * past) / (1 + share);
      }
    }
  }
}

void XpbdLines::begin_step() {
  for (Bundle& bundle : bundles_) {
    std::fill(bundle.lambda.begin(), bundle.lambda.end(), Lanes{});
  }
}

void XpbdLines::solve(Bundle& bundle, Points& positions, Points& reactions, Scratch& scratch) {
  const LineRows rows = scratch.rows(bundle);
  for (int axis = 0; axis < 3; ++axis) load_points(rows, &positions(0, axis), axis);
  measure_springs(rows);
  eliminate(rows);
  set_impulses(rows);
  move_points(rows);
  for (int axis = 0; axis < 3; ++axis) store_points(rows, bundle.lines, axis, &positions(0, axis));
  if (!bundle.is_held) return;
  turn_impulses(rows);
  react(bundle, scratch, reactions);
}

void XpbdLines::react(const Bundle& bundle, const Scratch& scratch, Points& reactions) {
  for (std::size_t k = 0; k <= bundle.springs(); ++k) {
    for (std::size_t lane = 0; lane < bundle.lines; ++lane) {
      if (bundle.inv_mass[k][lane] > 0) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const std::vector<Lanes>& impulses = scratch.u[static_cast<std::size_t>(axis)];
        double& sum = reactions(bundle.points[k][lane], axis);
        if (k > 0) sum -= impulses[k - 1][lane];
        if (k < bundle.springs()) sum += impulses[k][lane];
      }
    }
  }
}

void XpbdLines::solve(bool back, Points& positions, Points& reactions, const Workers& workers) {
  for (std::size_t k = 0; k < direction_ends_.size(); ++k) {
    const std::size_t d = back ? direction_ends_.size() - 1 - k : k;
    const int first = d > 0 ? direction_ends_[d - 1] : 0;
    const std::size_t springs = bundles_[static_cast<std::size_t>(first)].springs() * lanes;
    const auto min_band = static_cast<int>(1 + springs_a_band / springs);
    workers.parallel_for(
        direction_ends_[d] - first,
        [&](int from, int to) {
          static thread_local Scratch scratch;
          for (int b = first + from; b < first + to; ++b) {
            solve(bundles_[static_cast<std::size_t>(b)], positions, reactions, scratch);
          }
        },
        min_band);
  }
}

}  // namespace clothsim
