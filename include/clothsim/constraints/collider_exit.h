#pragma once

#include "clothsim/model/types.h"

namespace clothsim {

/// How cloth leaves a collider that was turned on, or put, where the cloth is.
struct ColliderExit {
  enum class Way {
    nearest,    // each point by its nearest surface; also where no collider was put on the cloth
    undecided,  // the next detection chooses
    together    // all points in one direction
  };

  Way way = Way::nearest;
  Vector3 velocity{0, 0, 0};     // of points that leave together, in the world [m/s]
  bool has_turned_back = false;  // another collider blocked the first direction
  bool lags = false;    // a point outside is nearer than contact keeps it: the exit goes on
  double duration = 0;  // [s]

  bool is_nearest() const { return way == Way::nearest; }
  bool is_together() const { return way == Way::together; }
};

}  // namespace clothsim
