// Which substeps seek what touches, and which go on with what is near.
//
// Stiff, light springs ask for much shorter steps than the motion does. So a substep that seeks
// plans how many others may go by what it finds: those aim anew what is near, and neither look for
// more nor guard the cloth from crossing itself. Bounds on how far points and colliders go keep
// them from meeting anything else, and all that they did is judged by the next search. The last
// substep of a frame always seeks.

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/springs.h"
#include "simulator_impl.h"

namespace clothsim {

bool Simulator::Impl::is_settled() const {
  return (!strain_limit || strain_limit->is_idle()) && collider_contacts.is_settled() &&
         !holders.any_slips();
}

void Simulator::Impl::plan_search(double h) {
  course.planned = 1;
  course.may_go = course.collider_speed = 0;
  // What a scene names, or a method bears, is for all.
  const bool has_own_step = scene.simulation.substeps || !std::isfinite(method->stability_limit());
  const double longest = std::min(longest_step, course.motion_step);
  if (has_own_step || 2 * h > longest || !is_settled()) return;

  const double most = most_unsought();
  const double speed = fastest(start_velocities);
  const double time = std::min(longest, most / speed);
  const double until_last = std::round(course.left / h) - 1;
  course.planned = static_cast<int>(std::max(1.0, std::min(time / h, until_last)));
  if (course.planned > 1) course.may_go = std::min(most, 2 * h * course.planned * speed);
}

double Simulator::Impl::most_unsought() {
  double most = way_share * shortest_rest_length(cloth);
  if (self_contacts) most = std::min(most, 2 * cloth.thickness);
  if (!std::isfinite(most)) return 0;

  const Vector3 way = Vector3::Constant(most);
  const Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose() - way,
                                state.positions.colwise().maxCoeff().transpose() + way);
  for (const MovingCollider& collider : colliders) {
    const double speed = collider.fastest_in(box);
    const Clearance keeps = clearance(collider.shape(), cloth, stretch_after(longest_step));
    if (!collider.reaches(box, speed * longest_step + keeps.points)) continue;
    course.collider_speed = std::max(course.collider_speed, speed);
    // Triangles that have touched with corners alone may sink in, beside what they are left in.
    if (keeps.faces) most = std::min(most, may_sink / 2);
  }
  return most;
}

void Simulator::Impl::end_search(double h) {
  course.since = course.gone = 0;
  course.served = may_go_on(h) ? course.planned - 1 : 0;
  course.planned = 0;
}

void Simulator::Impl::count_way(double h) {
  course.gone += h * fastest(state.velocities);
  course.recovers = course.recovers || collider_contacts.recovers();
  course.served = may_go_on(h) ? course.served - 1 : 0;
}

bool Simulator::Impl::may_go_on(double h) const {
  const double next = 2 * h * fastest(state.velocities);  // twice as fast, at most
  return is_settled() && course.gone + next <= course.may_go;
}

}  // namespace clothsim
