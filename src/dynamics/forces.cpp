#include "clothsim/dynamics/forces.h"

#include "clothsim/dynamics/force_blocks.h"

namespace clothsim {

void compute_forces(const Cloth& cloth, const Loads& loads, const Points& positions,
                    Points& forces) {
  forces.resize(cloth.num_points(), 3);
  for (ForceBlocks blocks(cloth, loads, positions, 0, cloth.num_points()); blocks.next();) {
    for (int axis = 0; axis < 3; ++axis) blocks.sum(axis, &forces(blocks.first(), axis));
  }
}

}  // namespace clothsim
