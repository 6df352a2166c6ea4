#pragma once

#include <array>
#include <functional>

#include "clothsim/model/types.h"

namespace clothsim {

/// A self contact: points of one layer above points of another.
struct SelfTouch {
  std::array<int, 4> points;
  std::array<double, 4> weights;  // of the points: > 0 above, < 0 below, 0: not involved
  Vector3 normal;                 // unit, from below to above
  double nearest;                 // distance that the middles of both layers keep [m]
};

/// Calls its argument for each self contact.
using SelfTouches = std::function<void(const std::function<void(const SelfTouch&)>& visit)>;

}  // namespace clothsim
