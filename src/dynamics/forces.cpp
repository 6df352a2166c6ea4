#include "clothsim/dynamics/forces.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/force_blocks.h"
#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {

void compute_forces(const Cloth& cloth, const Loads& loads, const Points& positions, Points& forces,
                    const Workers& workers, const Points* velocities) {
  forces.resize(cloth.num_points(), 3);
  if (cloth.is_mesh()) {
    return compute_triangle_forces(cloth, loads, positions, forces, workers, velocities);
  }
  static thread_local Points relative;
  if (velocities != nullptr && has_damped_bends(cloth)) {
    remove_rotation(cloth, positions, *velocities, relative, workers);
    velocities = &relative;
  }
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    for (ForceBlocks<double> blocks(cloth, loads, positions, begin, end, velocities);
         blocks.next();) {
      for (int axis = 0; axis < 3; ++axis) blocks.sum(axis, &forces(blocks.first(), axis));
    }
  });
}

}  // namespace clothsim
