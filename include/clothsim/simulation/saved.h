#pragma once

#include <vector>

#include "clothsim/shapes/moving_collider.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// A copy of all data on which the next frames depend: the cloth, its state, the memory of the
/// simulator (see Simulator::memory()), and the data that a memory does not contain.
struct Simulator::Saved {
  Cloth cloth;
  State state;
  std::vector<double> memory;
  std::vector<MovingCollider> colliders;
  std::vector<Vector3> pin_targets;
  Grips grips;
  std::vector<Wrench> collider_wrenches;
  Points forces;            // external forces [N]; no rows: none
  double last_substep;      // [s]
  int given_crossings;      // see Simulator::given_crossings()
  double frame_duration;    // [s]
  Vector3 gravity;          // [m/s^2]
  std::vector<char> leads;  // by collider: whether it leads a rigid body
};

}  // namespace clothsim
