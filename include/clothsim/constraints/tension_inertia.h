#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// Added inertia that keeps steps stable under tension.
///
/// A tension T in a spring of length l makes its ends oscillate across it: neighbours that move
/// against each other at omega^2 = 2 sum(T / l) / m. Impulses that hold springs at their limit have
/// the direction of one step, so a step is stable for h omega < 2, or h^2 sum(T / l) < 2 m. Instead
/// of shorter steps, points get 0.4 h^2 sum(T / l) more inertia, with the largest recent tension:
/// then the sum may be 10 m (Andrews, Teichmann & Kry 2017, "Geometric stiffness for real-time
/// constrained multibody dynamics"). Gravity acts on the mass without it, so rest shapes are the
/// same. A cloth that nothing holds keeps its momentum and angular momentum: added inertia resists
/// relative motion of points alone.
class TensionInertia {
 public:
  explicit TensionInertia(const Cloth&);

  /// Before a step of h [s] that begins with `state`: sets inverse masses [1/kg].
  void add_tension_mass(const Cloth&, double h, const State& state, Scalars& inv_mass,
                        const Workers& = {});

  /// After the step: gives a free cloth back the momentum that the added inertia has taken.
  /// `displacement_factor`: the method's own, see Integrator.
  void give_back(const Cloth&, double h, double displacement_factor, State&);

  /// Added mass in a step of h [s] over the mass of all points.
  double mass_ratio(double h) const;
  /// The same where tension makes every point oscillate at a frequency [rad/s].
  static double mass_ratio_at(double frequency, double h);

  /// Highest frequency [rad/s] at which tension makes a point oscillate across its springs between
  /// fixed neighbours, without added inertia: omega^2 = sum T / (m l).
  double frequency(const Cloth&) const;

  /// After a step's impulses: fade() reduces the stored values, then add() raises that of a free
  /// point to its sum of T / l [N/m] if that is more.
  void fade();
  void add(int point, double stiffness);

  void reset();

  /// Takes the values of `last`, of a cloth with other masses.
  void take_over(TensionInertia&& last);

  /// `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  int count() const { return static_cast<int>(stiffness_.size()); }

  double mass_;              // of the cloth [kg]
  Scalars stiffness_;        // by point, sum of T / l, recent maximum [N/m]
  bool is_tense_ = false;    // any of it is not 0
  bool is_free_ = false;     // nothing holds the cloth of this step
  Points start_velocities_;  // of this step, for a free and tense cloth [m/s]
};

}  // namespace clothsim
