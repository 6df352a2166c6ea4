#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
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

/// How much closer than the strain tolerance a substep's rates are solved: what is left of them
/// adds up, from step to step. Repairs aim so much inside of it, or their last bits take for ever,
/// yet not further, or springs that hold others up go slack.
inline constexpr double precision = 20;

/// Keeps every spring within (1 + limit) times its rest length (Provot 1995).
///
/// A spring at its limit may not lengthen: impulses p >= 0 along the springs, weighted by inverse
/// mass, take its rate of elongation out of the velocities, and points follow (Moreau's time
/// stepping; Jean 1999, "The non-smooth contact dynamics method"). Impulses are found by projected
/// Gauss-Seidel with Nesterov's momentum, forth and back where it takes many passes, kept from step
/// to step and free to shrink again, so a hanging cloth starts each step almost solved and its rest
/// shape does not depend on the order of the springs. Every impulse is equal and opposite, so
/// momentum is conserved; impulses act along the springs as they lie in the middle of the step, so
/// angular momentum is too.
///
/// What a shock leaves over the limit beyond a tolerance is taken out of positions alone: the
/// velocities have been solved already, and following this too would shake a soft cloth for ever.
///
/// The limit has a strength: the impulses that a step begins with are no more than it can carry, or
/// they would throw points from side to side. Where that bites, springs stretch beyond their limit,
/// by their own stiffness, and the step repairs none.
///
/// Only springs at the limit are swept; all are checked. Springs are swept by colour, no two of a
/// colour sharing a point, so the result does not depend on how a colour is split over threads.
class StrainLimit {
 public:
  /// Needs cloth.strain_limit; every other call must be given the same cloth, of whatever masses.
  /// `budget`: what passes take their visits from, if any.
  explicit StrainLimit(const Cloth& cloth, WorkBudget* budget = nullptr);

  /// Begins a frame in which others give the points no more than `speed` [m/s]. Springs that cannot
  /// reach their limit at such speeds are not looked at until they may.
  void begin_frame(double speed) {
    others_ = speed;
    wake();
  }
  /// Has the next step look at all springs, whatever speeds say.
  void wake() { slack_ = 0; }

  /// What its tension asks of the points' inertia, so that steps can follow.
  TensionInertia& inertia() { return inertia_; }
  const TensionInertia& inertia() const { return inertia_; }

  /// Gives the points, after a step of h [s], the impulses of the last step along the directions
  /// of then. `displacement_factor`: the method's own, see Integrator.
  void warm_start(double h, double displacement_factor, State&);

  /// Finds the springs at their limit, and turns the kept impulses into their present directions.
  /// Between warm_start() and this others may have moved the points and changed their velocities,
  /// by their own kept impulses: springs are held where all of them lead. `before`: then, the
  /// velocities that the step began with; else none.
  void prepare(const Cloth& cloth, double displacement_factor, State&, const Workers& = {},
               const Points* before = nullptr);

  /// One pass over the springs at the limit. Returns the largest change of a rate of elongation as
  /// the displacement it makes in h [m].
  double solve_pass(Points& velocities, const Workers& workers = {}) {
    return solve_passes(0, 1, velocities, workers).change;
  }

  /// What passes came to: how many, and what the last one changed [m], as solve_pass() tells it.
  struct Passes {
    int count;
    double change;
  };

  /// Passes until one changes no more than `enough` [m], at most `max_passes`.
  Passes solve_passes(double enough, int max_passes, Points& velocities, const Workers& = {});

  /// prepare(), and as many passes as it takes for the last to change no rate by more than `enough`
  /// [m] as a displacement, at least `min_passes` and at most `max_passes`; then moves the points
  /// as the impulses since warm_start() ask for. For where nothing but the limit acts on the cloth.
  /// From steps of `min_passes` passes momentum goes on, up to a strength of `min_passes`: at rest
  /// each solves what the last one did.
  Passes solve(const Cloth& cloth, double displacement_factor, double enough, int min_passes,
               int max_passes, State&, const Workers& = {});

  /// Has inertia() learn of the tension that the last step's impulses have.
  void learn_tension();

  /// Shortens springs until none is over its limit by more than `tolerance` times its rest length,
  /// in at most `max_passes` passes; none where the limit gives way. Returns the passes taken.
  int project_positions(const Cloth& cloth, double tolerance, int max_passes, Points& positions,
                        const Workers& = {});

  /// Does project_positions() leave a spring of this stretch alone, since it would fling its ends?
  bool is_beyond_repair(double stretch) const;

  /// Have impulses reached its strength in the last step?
  bool gives_way() const { return gives_way_; }

  /// Was no spring at its limit in the last step?
  bool is_idle() const { return num_active_ == 0; }

  /// Adds the impulses [N s] of the last step, times `scale`, to those of their points, N x 3.
  void add_impulses(double scale, Points& sum) const;

  /// Adds their strengths, times `scale`, to `sum`, one number a spring of the cloth.
  void add_strengths(double scale, std::vector<double>& sum) const;

  /// Goes on with the impulses of `last`, a limit on the same springs.
  void take_over(StrainLimit&& last);

  /// Forgets the impulses.
  void reset();

  /// The impulses and their directions. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  /// Springs that begin at neighbours, as many as a word has bits. A spring's id is 64 times its
  /// piece's place in pieces_, and its own in the piece.
  struct Piece {
    enum { length = 64 };

    int first;  // of the points they begin at
    int count;
    int offset;
    int direction;
    double rest_length;    // [m]
    std::uint64_t second;  // bits of those of the direction's second colour
  };

  struct Constraint {
    int a;
    int b;
    double rest_length;  // [m]
    int colour;
  };

  Constraint constraint(int id) const {
    const Piece& piece = pieces_[index(id / Piece::length)];
    const int place = id % Piece::length, a = piece.first + place;
    const auto colour = static_cast<int>(piece.second >> place & 1);
    return {a, a + piece.offset, piece.rest_length, 2 * piece.direction + colour};
  }
  void flag(int id) { flags_[index(id / Piece::length)] |= std::uint64_t{1} << id % Piece::length; }
  void flag_longer_than(double stretch, const Points& positions, const Workers&);
  /// Calls visit(id) for those of a piece whose `bits` are set.
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
  void list_active();
  void list(int id, const Piece& piece, std::size_t& next);
  void close_colour();
  void close_active();
  std::size_t fours() const { return ids_.size() / FourSprings::count; }
  int touch(int point);
  PassChange solve_colour(int colour, double momentum, bool goes_back, const Workers&);
  PassChange solve_active(double momentum, bool comes_back, const Workers&);
  Passes pass(double enough, int min_passes, int max_passes, Momentum&, const Workers&);
  void store(Points& velocities) const;
  bool holds(double tolerance) const;
  bool add_over(const Cloth&, int id, double tolerance, const Points& positions);
  bool project_springs(const Cloth&, const std::vector<int>& ids, double tolerance,
                       Points& positions, const Workers&);
  bool find_over_again(const Cloth&, double tolerance, const Points& positions);
  void list_springs_of_points(const Cloth&);

  double longest_;                   // 1 + limit
  double shortest_;                  // rest length [m]
  LimitStep step_{};                 // that the impulses belong to
  double momentum_ = 1;              // strength that solve() ended with
  double max_velocity_impulse_ = 0;  // of this step, see FourSprings [m/s]
  bool gives_way_ = false;
  double slack_ = 0;  // time until a spring may reach its limit [s]
  double others_ = std::numeric_limits<double>::infinity();  // see begin_frame() [m/s]
  TensionInertia inertia_;
  std::vector<Piece> pieces_;  // in the order of cloth.springs
  std::vector<int> order_;     // of pieces_: a neighbourhood's one after the other
  int num_springs_;

  // The springs at their limit, in fours of one colour.
  std::vector<FourSprings> active_;  // in the order of their sweeps; more are left from before
  std::vector<int> ids_;             // of their constraints, as active_; -1 where there is none
  std::vector<double> lengths_;      // at the limit [m], as ids_
  std::vector<double> velocity_impulses_;  // given by warm_start() [m/s], likewise
  std::vector<double> masses_;             // over which they are impulses [kg]
  std::vector<int> segment_ends_;          // in active_, of what a thread takes at once
  std::vector<int> colour_ends_;           // in segment_ends_
  std::vector<int> touched_;    // points of active_, which knows them by their places here
  std::size_t num_active_ = 0;  // springs
  bool solved_alone_ = false;   // by solve() in this step
  WorkBudget* budget_;          // what passes may take of it; none: any
  double moved_ = 0;            // farthest that solve() has moved a point [m]

  // As touched_, and one more for springs that are none. All w are 0 but in positions_.
  std::vector<Quad> positions_;     // w: inverse mass
  std::vector<Quad> warm_started_;  // velocities after warm_start()
  std::vector<Quad> velocities_;    // when solved
  std::vector<Quad> last_;          // before the last pass
  std::vector<Quad> before_;        // at the step's start, of prepare()
  std::vector<Quad> given_;         // velocities given by warm_start()
  std::vector<int> local_;          // places in touched_ by point; -1: in none

  // Scratch.
  std::vector<double> tensions_;      // sum of T h / l of the last impulses, as touched_ [N s/m]
  std::vector<std::uint64_t> flags_;  // a bit for each constraint
  std::vector<std::uint64_t> last_flags_;  // what active_ is of; none: of fewer
  std::vector<PassChange> changes_;        // by segment
  std::vector<int> last_ids_;
  std::vector<double> last_velocity_impulses_;  // as last_ids_
  std::vector<double> last_masses_;
  std::vector<int> last_touched_;
  std::vector<Quad> last_given_;  // as last_touched_

  // Of project_positions(). Springs by point are listed when they are first asked for.
  std::vector<std::vector<int>> over_;    // constraint ids by colour; none between calls
  std::vector<unsigned char> projected_;  // by the place in a list of over_
  std::vector<unsigned char> has_moved_;  // by point; all 0 between calls
  std::vector<int> moved_points_;         // none between calls
  std::vector<int> first_spring_;         // by point, in springs_of_points_; one more
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
