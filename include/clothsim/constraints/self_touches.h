#pragma once

#include <array>
#include <functional>

#include "clothsim/model/types.h"

namespace clothsim {

/// Where a cloth touches itself: points of one layer above points of another.
struct SelfTouch {
  std::array<int, 4> points;
  std::array<double, 4> weights;  // of the points: > 0 above, < 0 below, 0: none of it
  Vector3 normal;                 // unit, from below to above
  double nearest;                 // room that both layers need between their middles [m]
};

/// Calls what it is given for each place.
using SelfTouches = std::function<void(const std::function<void(const SelfTouch&)>& visit)>;

}  // namespace clothsim
