#include "clothsim/constraints/strain_limit.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"

namespace clothsim {
namespace {

/// Rate [1/s] at which impulses correct a violation, where drag is faster.
constexpr double violation_rate = 5;

/// That rate over drag's, where drag is slower. Warm-started impulses integrate: a slow wave x of
/// tension, of which the passes of a step find a share a, has x'' = -c x' - p and p' = (a / h) (x'
/// + rate x), and grows where rate > c.
constexpr double drag_share = 0.95;

/// Strength of the limit, as x = h^2 sum(T / l) / m of a point, for the impulses that a step begins
/// with: below it neighbours that oscillate against each other under tension are stable.
constexpr double max_tension = 2;

/// The same for a spring within the passes, as h^2 T / (m l).
constexpr double max_tension_in_passes = 8;

/// Factor on the strength for a step of h [s] that is longer than longest_step: such steps belong
/// to implicit methods, which damp oscillations, and a tension is the same force in them.
double times_carried(double h) {
  const double longer = std::max(h / longest_step, 1.0);
  return longer * longer;
}

Quad quad(const Points& points, int i) { return {points(i, 0), points(i, 1), points(i, 2), 0}; }

/// Springs of a colour from which on several threads are faster than one, measured where a write
/// reaches another core after 0.3 us.
constexpr std::size_t springs_a_colour = 4096;

/// Calls visit(i, points[i]) for different points.
template <typename Visitor>
void for_each_point(const std::vector<int>& points, const Workers& workers, const Visitor& visit) {
  workers.parallel_for(static_cast<int>(points.size()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto place = static_cast<std::size_t>(i);
      visit(place, points[place]);
    }
  });
}

/// First and number of the fours of segment `k`. `ends`: one more than the last of each segment.
std::pair<std::size_t, std::size_t> segment(const std::vector<int>& ends, int k) {
  const int begin = k > 0 ? ends[static_cast<std::size_t>(k - 1)] : 0;
  return {begin, ends[static_cast<std::size_t>(k)] - begin};
}

void set_row(Points& points, int i, const Quad& q) {
  points(i, 0) = q.x;
  points(i, 1) = q.y;
  points(i, 2) = q.z;
}

}  // namespace

StrainLimit::StrainLimit(const Cloth& cloth, WorkBudget* budget)
    : shortest_(shortest_rest_length(cloth)),
      inertia_(cloth),
      num_springs_(cloth.num_springs()),
      budget_(budget) {
  int direction = -1;
  const SpringRun* last = nullptr;
  for (const SpringRun& run : cloth.springs) {
    const bool new_direction = !last || last->batch != run.batch ||
                               (!cloth.is_mesh() && last->offset != run.offset) ||
                               last->family != run.family;
    if (new_direction) ++direction;
    last = &run;
    const double limit = cloth.strain_limit_at(run.first).value_or(infinity);
    least_limit_ = std::min(least_limit_, limit);
    if (limit < infinity) most_limit_ = std::max(most_limit_, limit);
    for (int done = 0; done < run.count; done += Piece::length) {
      const int count = std::min<int>(Piece::length, run.count - done);
      Piece piece{run.first + done, count, run.offset, direction, run.rest_length, 1 + limit, 0};
      // Springs of one offset share a point only where their first points differ by that offset.
      for (int i = 0; i < count; ++i) {
        const bool second = !cloth.is_mesh() && (piece.first + i) / run.offset % 2 == 1;
        piece.second |= std::uint64_t{second} << i;
      }
      pieces_.push_back(piece);
    }
  }
  over_.resize(index(2 * (direction + 1)));
  order_.resize(pieces_.size());
  std::iota(order_.begin(), order_.end(), 0);
  const auto neighbourhood = [&](int i) { return pieces_[index(i)].first / near_at_once; };
  std::stable_sort(order_.begin(), order_.end(),
                   [&](int i, int j) { return neighbourhood(i) < neighbourhood(j); });
  local_.assign(index(cloth.num_points()), -1);
  has_moved_.assign(index(cloth.num_points()), 0);
  flags_.assign(pieces_.size(), 0);
  limited_.assign(pieces_.size(), ~std::uint64_t{0});
  close_active();
}

void StrainLimit::add_impulses(Points& sum) const {
  for_each_active([&](const FourSprings& s, std::size_t k, int id) {
    const Constraint c = constraint(id);
    const Vector3 impulse = s.mass[k] * s.velocity_impulse[k] * Vector3(s.x[k], s.y[k], s.z[k]);
    sum.row(c.a) += impulse.transpose();
    sum.row(c.b) -= impulse.transpose();
  });
}

/// By point of touched_, sum of h T / (m l) [1/s] of the impulses: h omega^2.
std::vector<double> StrainLimit::tension_across() const {
  std::vector<double> across(touched_.size() + 1, 0.0);
  for (std::size_t i = 0; i < fours(); ++i) {
    const FourSprings& s = active_[i];
    for (std::size_t k = 0; k < FourSprings::count; ++k) {
      const double both = s.velocity_impulse[k] / lengths_[FourSprings::count * i + k];
      const double of_a = s.share[k] * both;
      across[index(FourSprings::point(s.a[k]))] += of_a;
      across[index(FourSprings::point(s.b[k]))] += both - of_a;
    }
  }
  return across;
}

/// Reduces the impulses, before they are scaled for a step `scale` times as long, to the strength
/// of the limit in it.
void StrainLimit::bound_impulses(double scale) {
  const std::vector<double> across = tension_across();
  const double h = scale * step_.h;
  const double max_across = max_tension * times_carried(h) / (scale * h);
  yields_ = *std::max_element(across.begin(), across.end()) > max_across;
  if (!yields_) return;
  for (std::size_t i = 0; i < fours(); ++i) {
    FourSprings& s = active_[i];
    for (std::size_t k = 0; k < FourSprings::count; ++k) {
      const double x = std::max(across[index(FourSprings::point(s.a[k]))],
                                across[index(FourSprings::point(s.b[k]))]);
      if (x > max_across) s.velocity_impulse[k] *= max_across / x;
    }
  }
}

/// Threads wait for each other after each colour: they gain where that takes less time than their
/// springs.
const Workers& StrainLimit::threads_for_passes(const Workers& workers) const {
  static const Workers one;
  return shares_passes() ? workers : one;
}

bool StrainLimit::shares_passes() const {
  return num_active_ >= springs_a_colour * colour_ends_.size();
}

/// No two springs of a colour share a point, so the result does not depend on threads.
template <typename OfPoints, typename OfSprings>
void StrainLimit::by_stages(const Workers& workers, const OfPoints& of_points,
                            const OfSprings& of_springs) const {
  const int parts = stages_forth_.front();
  threads_for_passes(workers).in_stages(stages_forth_, [&](int part) {
    if (part < parts) {
      const std::size_t begin = index(part) * points_at_once;
      return of_points(begin, std::min(begin + points_at_once, touched_.size()));
    }
    const auto [begin, count] = segment(segment_ends_, part - parts);
    of_springs(begin, count);
  });
}

void StrainLimit::warm_start(double h, double displacement_factor, State& state,
                             const Workers& workers) {
  const double scale = step_.h > 0 ? h / step_.h : 0;  // for the same forces
  if (scale > 0) bound_impulses(scale);
  step_ = {h, displacement_factor, 0, 0};
  max_velocity_impulse_ = max_tension_in_passes * times_carried(h) * shortest_ / h;
  slack_ -= h;
  given_.back() = {};
  by_stages(
      workers,
      [&](std::size_t begin, std::size_t end) { std::fill(&given_[begin], &given_[end], Quad{}); },
      [&](std::size_t begin, std::size_t count) {
        const std::size_t first = FourSprings::count * begin;
        warm_start_springs(scale, count, &active_[begin], &velocity_impulses_[first],
                           &masses_[first], given_.data());
      });
  const double impulse_time = displacement_factor * h;
  for_each_point(touched_, workers, [&](std::size_t i, int point) {
    const Quad& given = given_[i];
    const Quad v = quad(state.velocities, point);
    const Quad x = quad(state.positions, point);
    warm_started_[i] = {v.x + given.x, v.y + given.y, v.z + given.z, 0};
    positions_[i] = {x.x + impulse_time * given.x, x.y + impulse_time * given.y,
                     x.z + impulse_time * given.z, 0};
    set_row(state.velocities, point, warm_started_[i]);
    set_row(state.positions, point, positions_[i]);
  });
}

/// Time until a spring may reach its limit [s], while its ends move against each other no faster
/// than any point does relative to the cloth.
double StrainLimit::slack(const Cloth& cloth, const State& state) const {
  const double speed = 2 * (longest_beyond_mean(state.velocities) + others_);
  if (least_limit_ * shortest_ <= speed * step_.h) return 0;  // by far the cheaper check
  return (least_limit_ - worst_stretch(cloth, state.positions)) * shortest_ / speed;
}

void StrainLimit::prepare(const Cloth& cloth, double displacement_factor, State& state,
                          const Workers& workers, const Points* before) {
  turn_impulses(cloth, displacement_factor, state, workers, before);
  store(state.velocities, workers);
}

/// Takes back the impulses of warm_start(), and applies them along the present directions.
void StrainLimit::turn_impulses(const Cloth& cloth, double displacement_factor, State& state,
                                const Workers& workers, const Points* before) {
  step_.displacement_factor = displacement_factor;
  solved_alone_ = false;
  if (is_slack()) return;
  const bool changes = find_active(state.positions, workers);
  if (changes || before) {
    for_each_point(touched_, workers, [&](std::size_t i, int point) {
      positions_[i] = quad(state.positions, point);
      warm_started_[i] = quad(state.velocities, point);
    });
  }
  if (changes) {
    for_each_point(last_touched_, workers, [&](std::size_t i, int point) {
      const Quad& given = last_given_[i];
      state.velocities.row(point) -= Eigen::RowVector3d(given.x, given.y, given.z);
    });
    load(state.velocities, workers);
  } else {
    for_each_point(touched_, workers, [&](std::size_t i, int) {
      const Quad &from = warm_started_[i], &given = given_[i];
      velocities_[i] = {from.x - given.x, from.y - given.y, from.z - given.z, 0};
    });
  }
  step_.active = static_cast<double>(num_active_) / num_springs_;
  step_.rate = std::min(violation_rate, drag_share * cloth.damping);
  turn_springs(cloth, workers, before);
  if (num_active_ == 0) slack_ = slack(cloth, state);
}

void StrainLimit::turn_springs(const Cloth& cloth, const Workers& workers, const Points* before) {
  if (before) before_.resize(velocities_.size());
  by_stages(
      workers,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          positions_[i].w = cloth.inv_mass[touched_[i]];
          if (before) before_[i] = quad(*before, touched_[i]);
        }
      },
      [&](std::size_t begin, std::size_t count) {
        const std::size_t first = FourSprings::count * begin;
        prepare_springs(step_,
                        {positions_.data(), warm_started_.data(), before ? before_.data() : nullptr,
                         &lengths_[first], &velocity_impulses_[first], &masses_[first]},
                        count, &active_[begin], velocities_.data());
      });
}

void StrainLimit::load(const Points& velocities, const Workers& workers) {
  for_each_point(touched_, workers,
                 [&](std::size_t i, int point) { velocities_[i] = quad(velocities, point); });
}

void StrainLimit::store(Points& velocities, const Workers& workers) const {
  for_each_point(touched_, workers,
                 [&](std::size_t i, int point) { set_row(velocities, point, velocities_[i]); });
}

/// One pass over active_, forth or forth and back, colour by colour, from extrapolated velocities.
/// Springs of one colour share no point. Sums are by segment, so they do not depend on threads.
PassChange StrainLimit::solve_active(double momentum, bool comes_back, const Workers& workers) {
  if (budget_) budget_->spend(static_cast<std::int64_t>((comes_back ? 2 : 1) * num_active_));
  const std::vector<int>& stages = comes_back ? stages_back_ : stages_forth_;
  const int points = stages.front(), segments = static_cast<int>(segment_ends_.size());
  changes_.resize(index(stages.back() - points));
  threads_for_passes(workers).in_stages(stages, [&](int part) {
    if (part < points) {
      const std::size_t begin = index(part) * points_at_once;
      const std::size_t count = std::min<std::size_t>(points_at_once, touched_.size() - begin);
      return extrapolate(momentum, count, &last_[begin], &velocities_[begin]);
    }
    const int place = part - points;
    const bool goes_back = place >= segments;
    const int k = goes_back ? stages_forth_.end()[-2] - points - 1 - (place - segments) : place;
    const auto [begin, count] = segment(segment_ends_, k);
    changes_[index(place)] = solve_springs(&active_[begin], count, goes_back ? 0 : momentum,
                                           goes_back, max_velocity_impulse_, velocities_.data());
  });
  PassChange change;
  for (const PassChange& of_segment : changes_) change.add(of_segment);
  return change;
}

/// Passes with momentum over velocities_ until one changes no rate by more than `enough` [m] as a
/// displacement, at least `min_passes` and at most `max_passes`. Those after the first `min_passes`
/// go forth and back: strong momentum amplifies the residual of passes in one order.
StrainLimit::Passes StrainLimit::pass(double enough, int min_passes, int max_passes,
                                      Momentum& momentum, const Workers& workers) {
  Passes passes{0, 0};
  do {
    if (passes.count == min_passes) momentum = Momentum();
    const PassChange change = solve_active(momentum.share(), passes.count >= min_passes, workers);
    if (!yields_) momentum.next(change.descent);  // else it would overshoot
    passes = {passes.count + 1, step_.h * change.largest};
  } while (passes.count < max_passes && (passes.count < min_passes || passes.change > enough));
  return passes;
}

StrainLimit::Passes StrainLimit::solve_passes(double enough, int max_passes, Points& velocities,
                                              const Workers& workers) {
  load(velocities, workers);
  Momentum momentum;
  const Passes passes = pass(enough, 1, max_passes, momentum, workers);
  store(velocities, workers);
  return passes;
}

StrainLimit::Passes StrainLimit::solve(const Cloth& cloth, double displacement_factor,
                                       double enough, int min_passes, int max_passes, State& state,
                                       const Workers& workers) {
  turn_impulses(cloth, displacement_factor, state, workers, nullptr);
  Momentum momentum(std::min(momentum_, static_cast<double>(min_passes)));
  const Passes passes = pass(enough, min_passes, max_passes, momentum, workers);
  // A step that needs more passes is a different problem.
  momentum_ = passes.count == min_passes ? momentum.strength() : 1;

  const double impulse_time = step_.displacement_factor * step_.h;
  struct Longest {
    double move2 = 0;
  };
  const auto bands = workers.gather<Longest>(
      static_cast<int>(touched_.size()),
      [&](int begin, int end, Longest& longest) {
        for (std::size_t i = index(begin); i < index(end); ++i) {
          const Quad &v = velocities_[i], &from = warm_started_[i];
          Quad& x = positions_[i];
          const Quad move{impulse_time * (v.x - from.x), impulse_time * (v.y - from.y),
                          impulse_time * (v.z - from.z), 0};
          x = {x.x + move.x, x.y + move.y, x.z + move.z, x.w};
          set_row(state.positions, touched_[i], x);
          longest.move2 =
              std::max(longest.move2, move.x * move.x + move.y * move.y + move.z * move.z);
        }
      },
      points_at_once, 1);
  store(state.velocities, workers);
  moved_ = 0;
  for (const Longest& longest : bands) moved_ = std::max(moved_, std::sqrt(longest.move2));
  solved_alone_ = true;
  return passes;
}

void StrainLimit::learn_tension(const Workers& workers) {
  inertia_.fade();
  tensions_.resize(touched_.size() + 1);
  tensions_.back() = 0;
  by_stages(
      workers,
      [&](std::size_t begin, std::size_t end) {
        std::fill(&tensions_[begin], &tensions_[end], 0.0);
      },
      [&](std::size_t begin, std::size_t count) {
        add_tensions(&active_[begin], &lengths_[FourSprings::count * begin], count,
                     tensions_.data());
      });
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    if (positions_[i].w > 0) inertia_.add(touched_[i], tensions_[i] / step_.h);
  }
}

}  // namespace clothsim
