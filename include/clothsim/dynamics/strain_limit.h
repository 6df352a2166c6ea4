#pragma once

#include <array>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Keeps every spring within (1 + limit) times its rest length (Provot 1995).
///
/// A spring at its limit may not lengthen: impulses p >= 0 along the springs, weighted by inverse
/// mass, take its rate of elongation out of the velocities, and points follow (Moreau's time
/// stepping; Jean 1999, "The non-smooth contact dynamics method"). Impulses are found by projected
/// Gauss-Seidel, kept from step to step and free to shrink again, so a hanging cloth starts each
/// step almost solved and its rest shape does not depend on the order of the springs. Acting on
/// velocities instead of lengths is what makes kept impulses stable when a step's sweeps stop
/// early. Every impulse is equal and opposite, so momentum is conserved; impulses act along the
/// springs as they lie in the middle of the step, so angular momentum is too.
///
/// What a shock leaves over the limit beyond a tolerance is taken out of positions alone: the
/// velocities have been solved already, and following this too would shake a soft cloth for ever.
///
/// Only springs at the limit are swept; all are checked. Springs are swept by colour, no two of a
/// colour sharing a point, so the result does not depend on how a colour is split over threads.
class StrainLimit {
 public:
  /// Needs cloth.strain_limit; every other call must be given the same cloth.
  explicit StrainLimit(const Cloth& cloth);

  /// Gives the points, after a step of h [s], the impulses of the last step along the directions
  /// of then. `reach`: the method's own, see Integrator.
  void predict(const Cloth& cloth, double h, double reach, State&);

  /// Finds the springs at their limit, and turns the kept impulses into their present directions.
  void begin(const Cloth& cloth, double reach, State&);

  /// One pass over the springs at the limit. Returns the largest change of a rate of elongation as
  /// the displacement it makes in h [m].
  double sweep(const Cloth& cloth, Points& velocities);

  /// Shortens springs until none is over its limit by more than `tolerance` times its rest length,
  /// in at most `max_sweeps` passes. Returns the passes taken.
  int correct(const Cloth& cloth, double tolerance, int max_sweeps, Points& positions);

  /// Adds the impulses [N s] of the last step, times `scale`, to those of their points, N x 3.
  void add_impulses(double scale, Points& sum) const;

  /// Goes on with the impulses of `last`, a limit on the same springs.
  void take_over(StrainLimit&& last);

  /// Forgets the impulses.
  void reset();

  /// The impulses and their directions. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  static constexpr int num_colours = 12;

  struct Constraint {
    int a;
    int b;
    double rest_length;  // [m]
    double inv_mass;     // of both ends together [1/kg]
    int colour;
  };

  /// A spring at its limit in this step.
  struct Active {
    int id;  // of the constraint
    int a;
    int b;
    double inv_mass;    // of both ends together [1/kg]
    Vector3 direction;  // from a to b
    double fastest;     // largest rate of elongation allowed [m/s]
  };

  void flag_longer_than(const Cloth& cloth, double stretch, const Points& positions);
  template <typename Visitor>
  void for_each_flagged(Visitor&& visit) const;

  double longest_;                                       // 1 + limit
  double h_ = 0;                                         // step that impulses_ belong to [s]
  std::vector<Constraint> constraints_;                  // in the order of cloth.springs
  std::vector<double> impulses_;                         // [N s], >= 0, as constraints_
  std::vector<unsigned char> flags_;                     // as constraints_, padded to whole words
  std::vector<unsigned char> over_length_;               // by first point, scratch of one direction
  std::array<std::vector<Active>, num_colours> active_;  // by colour
  std::array<std::vector<Active>, num_colours> last_active_;  // of the step before
  std::array<std::vector<int>, num_colours> over_;  // constraint ids, scratch of correct()
};

}  // namespace clothsim
