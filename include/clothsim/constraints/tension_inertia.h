#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Inertia that keeps steps stable across springs under tension.
///
/// A tension T in a spring of length l swings its ends across it: neighbours that move against each
/// other at omega^2 = 2 sum(T / l) / m. Impulses that hold springs at their limit have the
/// direction of one step, so a step is stable for h omega < 2, or h^2 sum(T / l) < 2 m. Instead of
/// following that with shorter steps, points get 0.4 h^2 sum(T / l) more inertia, of the largest
/// tension of late: then it may be 10 m (Andrews, Teichmann & Kry 2017, "Geometric stiffness for
/// real-time constrained multibody dynamics"). Gravity pulls at what a point weighs, so that rest
/// shapes are the same. Of a cloth that nothing holds, momentum and angular momentum stay: added
/// inertia resists motion of points against each other alone.
class TensionInertia {
 public:
  explicit TensionInertia(const Cloth&);

  /// Before a step of h [s] that begins with `state`: sets inverse masses [1/kg].
  void add_tension_mass(const Cloth&, double h, const State& state, Scalars& inv_mass);

  /// After it: gives a free cloth back the momentum that inertia beyond its mass has taken.
  /// `displacement_factor`: the method's own, see Integrator.
  void give_back(const Cloth&, double h, double displacement_factor, State&);

  /// What is added in a step of h [s], of the mass of all points.
  double mass_ratio(double h) const;
  /// The same where tension lets every point swing at a frequency [rad/s].
  static double mass_ratio_at(double frequency, double h);

  /// Highest frequency [rad/s] at which it let a point swing across its springs between neighbours
  /// that stay, without it: omega^2 = sum T / (m l).
  double frequency(const Cloth&) const;

  /// After a step's impulses: what was before fades, then add() at each free point takes its sum of
  /// T / l [N/m] where that is more.
  void fade();
  void add(int point, double stiffness);

  void reset();

  /// Goes on with what `last` has learnt of a cloth that had other masses.
  void take_over(TensionInertia&& last);

  /// `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  int count() const { return static_cast<int>(stiffness_.size()); }

  double mass_;              // of the cloth [kg]
  Scalars stiffness_;        // by point, sum of T / l, largest of late [N/m]
  bool is_tense_ = false;    // any of it is not 0
  bool is_free_ = false;     // the cloth of this step: nothing holds it
  Points start_velocities_;  // of this step, of a cloth that is free and tense [m/s]
};

}  // namespace clothsim
