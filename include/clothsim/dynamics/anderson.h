#pragma once

#include <deque>

#include "clothsim/model/types.h"

namespace clothsim {

/// Anderson acceleration of an iteration x -> x + change(x): the next iterate is the combination of
/// the last ones, with weights of sum 1, whose change is smallest if changes were linear in x.
/// Walker & Ni 2011, "Anderson acceleration for fixed-point iterations", with differences of
/// iterates and changes as they give them.
class Anderson {
 public:
  /// `window`: differences combined, at least 0; 0 leaves the plain iteration.
  explicit Anderson(int window) : window_(window) {}

  /// Forgets all iterates.
  void reset();

  /// Replaces the iterate x, N x 3, that changes by `change`, by the next one.
  void next(const Points& change, Points& x);

 private:
  int window_;
  bool has_last_ = false;
  Points last_x_;
  Points last_change_;
  std::deque<Points> x_steps_;       // differences of iterates, oldest first
  std::deque<Points> change_steps_;  // and of their changes
};

}  // namespace clothsim
