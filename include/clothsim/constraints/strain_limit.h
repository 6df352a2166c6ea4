#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "clothsim/constraints/limited_spring.h"
#include "clothsim/constraints/momentum.h"
#include "clothsim/constraints/sleep_bounds.h"
#include "clothsim/constraints/tension_inertia.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Ratio of the strain tolerance to the residual of a substep's rates, since residuals add up from
/// step to step. The projection shortens springs to the tolerance less a share of 1 /
/// tolerance_per_residual of it: with the whole tolerance as target it would not end because of
/// rounding, and with a smaller target springs that hold others up would go slack.
inline constexpr double tolerance_per_residual = 20;

/// Keeps every spring within (1 + limit) times its rest length (Provot 1995), of several cloths
/// each within its own limit.
///
/// A spring at its limit may not lengthen: impulses p >= 0 along the springs, weighted by inverse
/// mass, take its rate of elongation out of the velocities, and points follow (Moreau's time
/// stepping; Jean 1999, "The non-smooth contact dynamics method"). Impulses are found by projected
/// Gauss-Seidel with Nesterov's momentum, with passes forward and backward where many are needed.
/// They start from those of the last step, so a hanging cloth starts almost solved. They may also
/// shrink, so the rest shape does not depend on the order of the springs. Every impulse is equal
/// and opposite, so momentum is conserved; impulses act along the directions of the springs in the
/// middle of the step, so angular momentum is conserved, too.
///
/// A violation beyond a tolerance, left by a shock, is projected out of positions alone. The
/// velocities are solved already: if they changed as well, a soft cloth would shake for ever.
///
/// The limit has a strength: a bound on the impulses that a step begins with. Without it these
/// impulses would throw points from side to side. Where the bound acts, the limit yields
/// (yields()): springs stretch beyond their limit, against their own stiffness alone, and the
/// step has no projection.
///
/// Each step checks all springs, but passes visit only those at their limit. Passes go colour by
/// colour; no two springs of a colour share a point, so the result does not depend on the division
/// of a colour over threads.
class StrainLimit {
 public:
  /// Needs cloth.strain_limit; every other call must be given the same cloth, with any masses.
  /// `budget`: counts the visits of passes, if given.
  explicit StrainLimit(const Cloth& cloth, WorkBudget* budget = nullptr);

  /// Begins a frame in which other causes add no more than `speed` [m/s] to the points. Springs
  /// that cannot reach their limit at such speeds are not checked until they may.
  void begin_frame(double speed) {
    others_ = speed;
    wake();
  }
  /// Makes the next step check all springs, whatever the speeds.
  void wake() { slack_ = 0; }

  /// Inertia of the points for stable steps under the tension of the limit.
  TensionInertia& inertia() { return inertia_; }
  const TensionInertia& inertia() const { return inertia_; }

  /// After a step of h [s], gives the points the impulses of the last step along the directions of
  /// that step. `displacement_factor`: the method's own, see Integrator.
  void warm_start(double h, double displacement_factor, State&, const Workers& = {});

  /// Finds the springs at their limit, and turns the warm-started impulses to their present
  /// directions. After warm_start() other constraints may move the points and change their
  /// velocities by their own warm starts: `before` must then be the velocities at the step's start,
  /// else null.
  void prepare(const Cloth& cloth, double displacement_factor, State&, const Workers& = {},
               const Points* before = nullptr);

  /// One pass over the springs at the limit. Returns the largest change of a rate of elongation as
  /// a displacement in h [m].
  double solve_pass(Points& velocities, const Workers& workers = {}) {
    return solve_passes(0, 1, velocities, workers).change;
  }

  /// The number of passes, and the change of the last one [m], as in solve_pass().
  struct Passes {
    int count;
    double change;
  };

  /// Passes until one changes no more than `enough` [m], at most `max_passes`.
  Passes solve_passes(double enough, int max_passes, Points& velocities, const Workers& = {});

  /// prepare(), and passes until the last changes no rate by more than `enough` [m] as a
  /// displacement, at least `min_passes` and at most `max_passes`; then moves the points by the
  /// impulses since warm_start(). For a cloth on which only the limit acts. After steps of
  /// `min_passes` passes momentum carries over, up to a strength of `min_passes`: at rest each step
  /// solves the same problem.
  Passes solve(const Cloth& cloth, double displacement_factor, double enough, int min_passes,
               int max_passes, State&, const Workers& = {});

  /// Updates inertia() with the tension of the last step's impulses.
  void learn_tension(const Workers& = {});

  /// Shortens springs until none is over its limit by more than `tolerance` times its rest length,
  /// in at most `max_passes` passes; none where the limit yields. Returns the passes taken.
  int project_positions(const Cloth& cloth, double tolerance, int max_passes, Points& positions,
                        const Workers& = {});

  /// Does project_positions() skip a spring that is this stretch beyond its limit, since it would
  /// throw its ends?
  bool is_beyond_repair(double violation) const;

  /// Have impulses reached the strength of the limit in the last step?
  bool yields() const { return yields_; }

  /// Are there so many springs at their limit that threads share the passes over them?
  bool shares_passes() const;

  /// Was no spring at its limit in the last step?
  bool is_idle() const { return num_active_ == 0; }

  /// Adds the impulses [N s] of the last step to those of their points, N x 3.
  void add_impulses(Points& sum) const;

  /// Adds the impulses' magnitudes [N s] times scale(point) to `sum`, one number per spring of the
  /// cloth. `scale`: by point, N.
  void add_impulse_magnitudes(const Scalars& scale, std::vector<double>& sum) const;

  /// Excludes springs with both ends at one holder from the limit: the holder keeps their length,
  /// whether the ends stick or slip. `holder_of_point`: a number for each point, -1 for a free one.
  void leave_to_holders(const std::vector<int>& holder_of_point);

  /// Continues with the impulses of `last`, a limit on the same springs.
  void take_over(StrainLimit&& last);

  /// Forgets the impulses.
  void reset();

  /// The impulses and their directions. `read` throws InvalidValue for data that is not from
  /// `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  static constexpr int points_at_once = 2 * near_at_once;  // in a part of a loop

  /// Up to 64 parallel springs that begin at successive points: one for each bit of a word. A
  /// spring's id is 64 times the place of its piece in pieces_, plus its place in the piece.
  struct Piece {
    enum { length = 64 };

    int first;  // of the points at which they begin
    int count;
    int offset;
    int direction;
    double rest_length;    // [m]
    double longest;        // by rest length, 1 + limit; infinity without limit
    std::uint64_t second;  // bits of those of the direction's second colour
  };

  struct Constraint {
    int a;
    int b;
    double rest_length;  // [m]
    double longest;      // by rest length
    int colour;
  };

  Constraint constraint(int id) const {
    const Piece& piece = pieces_[index(id / Piece::length)];
    const int place = id % Piece::length, a = piece.first + place;
    const auto colour = static_cast<int>(piece.second >> place & 1);
    return {a, a + piece.offset, piece.rest_length, piece.longest, 2 * piece.direction + colour};
  }
  bool is_limited(int id) const {
    return (limited_[index(id / Piece::length)] >> id % Piece::length & 1) != 0;
  }
  void flag(int id) { flags_[index(id / Piece::length)] |= std::uint64_t{1} << id % Piece::length; }
  void flag_beyond_limit_by(double stretch, const Points& positions, const Workers&);
  /// Calls visit(id) for springs of a piece whose `bits` are set.
  template <typename Visitor>
  static void for_each_bit(std::size_t piece, std::uint64_t bits, Visitor&& visit) {
    for (; bits != 0; bits &= bits - 1) {
      visit(Piece::length * static_cast<int>(piece) + __builtin_ctzll(bits));
    }
  }
  template <typename Visitor>
  void for_each_flagged(Visitor&& visit) const;
  template <typename Visitor>
  void for_each_active(Visitor&& visit) const;
  void turn_impulses(const Cloth& cloth, double displacement_factor, State&, const Workers&,
                     const Points* before);
  std::vector<double> tension_across() const;
  void bound_impulses(double scale);
  bool is_slack() const { return slack_ > step_.h; }
  double slack(const Cloth&, const State&) const;
  bool find_active(const Points& positions, const Workers&);
  void clear_active();
  /// Sets the impulse of entry `i` of ids_ to zero.
  void end_impulse(std::size_t i) {
    active_[i / FourSprings::count].velocity_impulse[i % FourSprings::count] = 0;
  }
  void list_active();
  void list(int id, const Piece& piece, std::size_t& next);
  void close_colour();
  void close_active();
  void list_stages();
  const Workers& threads_for_passes(const Workers&) const;
  /// Calls of_points(begin, end) for bands of touched_, and then of_springs(begin, count) for
  /// segments of active_, colour by colour.
  template <typename OfPoints, typename OfSprings>
  void by_stages(const Workers&, const OfPoints&, const OfSprings&) const;
  std::size_t fours() const { return ids_.size() / FourSprings::count; }
  int touch(int point);
  PassChange solve_active(double momentum, bool comes_back, const Workers&);
  Passes pass(double enough, int min_passes, int max_passes, Momentum&, const Workers&);
  void load(const Points& velocities, const Workers&);
  void store(Points& velocities, const Workers&) const;
  void turn_springs(const Cloth&, const Workers&, const Points* before);
  bool holds(double tolerance) const;
  bool add_over(const Cloth&, int id, double tolerance, const Points& positions);
  bool project_springs(const Cloth&, const std::vector<int>& ids, double tolerance,
                       Points& positions, const Workers&);
  bool find_over_again(const Cloth&, double tolerance, const Points& positions);
  void list_springs_of_points(const Cloth&);

  double least_limit_ = infinity;    // of the springs that have one
  double most_limit_ = 0;            // the same
  double shortest_;                  // rest length [m]
  LimitStep step_{};                 // of the impulses
  double momentum_ = 1;              // strength at the end of solve()
  double max_velocity_impulse_ = 0;  // of this step, see FourSprings [m/s]
  bool yields_ = false;
  double slack_ = 0;          // time until a spring may reach its limit [s]
  double others_ = infinity;  // see begin_frame() [m/s]
  TensionInertia inertia_;
  std::vector<Piece> pieces_;  // in the order of cloth.springs
  std::vector<int> order_;     // of pieces_, neighbourhood by neighbourhood
  int num_springs_;

  // The springs at their limit, in fours of one colour.
  std::vector<FourSprings> active_;        // in the order of passes; further ones are unused
  std::vector<int> ids_;                   // of their constraints, as active_; -1: no spring
  std::vector<double> lengths_;            // at the limit [m], as ids_
  std::vector<double> velocity_impulses_;  // given by warm_start() [m/s], as ids_
  std::vector<double> masses_;             // factor from these to impulses [kg]
  std::vector<int> segment_ends_;          // in active_, of the share that a thread takes at once
  std::vector<int> colour_ends_;           // in segment_ends_
  std::vector<int> stages_forth_;          // of a pass: ends of the parts of touched_, then of
                                           // the segments of each colour
  std::vector<int> stages_back_;           // the same of a pass forth and back
  std::vector<int> touched_;               // points of active_, which refers to their places here
  std::size_t num_active_ = 0;             // springs
  bool solved_alone_ = false;              // by solve() in this step
  WorkBudget* budget_;                     // for passes; none: no bound
  double moved_ = 0;                       // largest displacement of a point by solve() [m]

  // As touched_, and one more for unused springs. All w are 0 except in positions_.
  std::vector<Quad> positions_;     // w: inverse mass
  std::vector<Quad> warm_started_;  // velocities after warm_start()
  std::vector<Quad> velocities_;    // when solved
  std::vector<Quad> last_;          // before the last pass
  std::vector<Quad> before_;        // at the step's start, from prepare()
  std::vector<Quad> given_;         // velocities given by warm_start()
  std::vector<int> local_;          // places in touched_ by point; -1: none

  // Scratch.
  std::vector<double> tensions_;        // sum of T h / l of the last impulses, as touched_ [N s/m]
  std::vector<std::uint64_t> limited_;  // springs that no holder has
  std::vector<std::uint64_t> flags_;    // a bit for each constraint
  std::vector<std::uint64_t> last_flags_;  // those that active_ is for; empty: list it anew
  std::vector<PassChange> changes_;        // by segment, forth and then back
  std::vector<int> last_ids_;
  std::vector<double> last_velocity_impulses_;  // as last_ids_
  std::vector<double> last_masses_;
  std::vector<int> last_touched_;
  std::vector<Quad> last_given_;  // as last_touched_

  // For project_positions(). Springs by point are listed at the first request.
  std::vector<std::vector<int>> over_;    // constraint ids by colour; none between calls
  std::vector<unsigned char> projected_;  // by place in a list of over_
  std::vector<unsigned char> has_moved_;  // by point; all 0 between calls
  std::vector<int> moved_points_;         // none between calls
  std::vector<int> first_spring_;         // by point, in springs_of_points_; and the end
  std::vector<int> springs_of_points_;    // constraint ids
};

template <typename Visitor>
void StrainLimit::for_each_flagged(Visitor&& visit) const {
  for (std::size_t i = 0; i < flags_.size(); ++i) for_each_bit(i, flags_[i], visit);
}

template <typename Visitor>
void StrainLimit::for_each_active(Visitor&& visit) const {
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (ids_[i] < 0) continue;
    visit(active_[i / FourSprings::count], i % FourSprings::count, ids_[i]);
  }
}

}  // namespace clothsim
