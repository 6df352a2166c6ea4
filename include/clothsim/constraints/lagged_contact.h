#pragma once

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/constraints/self_contacts.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// The impulses of contact in the last steps, smoothed, for the steps of implicit methods.
///
/// Contact acts after the step of a method. An implicit method lets a point of mass m on an edge
/// and the mass M that hangs from it fall together, and contact then moves the point alone back. So
/// the springs stay longer by (1 + M / m) g h^2. With the impulses of contact in the step its end
/// is in balance. After the step they are taken back, and the impulses of contact act instead:
/// momentum does not depend on the lagged ones.
///
/// In each step they follow those of contact by a share s of the difference, an integral control of
/// the springs' elongation d. With e = m / (M + m), the velocity V of M, d in units of h and an
/// impulse that exceeds the balance by m Q,
///   V' = (1 - e) V - e (Q + d),  d' = d + V',  Q' = Q + s d',
/// which is stable for s < e. A line of N cells has e > 1 / N under its own weight. Where contact
/// changes a velocity by dv in a step, more than by the weight of N cells, e is about g h / dv.
/// Shares are a fixed part of the lesser of both; where contact has ended, of 1.
class LaggedContact {
 public:
  /// The changes of velocities by these impulses in a step of h [s], N x 3 [m/s]; 0 for points
  /// without inverse mass. They must outlive the step.
  const Points& begin_step(double h, const Cloth&);

  /// Takes them back from the velocities after the step of a method.
  void take_back(Points& velocities) const { velocities -= lagged_; }

  /// Follows the impulses of a step of contact. `self`: null for none. `gravity`: [m/s^2]. `cells`:
  /// along the cloth.
  void follow(const ColliderContacts&, const SelfContacts* self, double gravity, double cells);

  void reset() { h_ = 0; }

  /// `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&, const Cloth&);

 private:
  double h_ = 0;   // of the last step [s]; 0: no impulses
  Points lagged_;  // changes of velocities by them in such a step [m/s], N x 3
  Points given_;   // the same by contact
};

}  // namespace clothsim
