// Which substeps run detection, and which use known contacts.
//
// Stiff, light springs need much shorter steps than the motion does. So a substep with detection
// plans how many others may use its results: the others update known contacts, and neither detect
// further ones nor run the guard. Bounds on the displacements of points and colliders exclude
// contact with anything else, and the next detection covers their whole path. The last substep of a
// frame always runs detection.

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/springs.h"
#include "simulator_impl.h"

namespace clothsim {

bool Simulator::Impl::is_settled() const {
  return (!strain_limit || strain_limit->is_idle()) && collider_contacts.is_settled() &&
         !holders.any_slips() && attachments.empty();
}

void Simulator::Impl::plan_detection(double h) {
  frame_context.planned_steps = 1;
  frame_context.max_undetected_move = frame_context.collider_speed = 0;
  // If the scene sets the number of substeps, or the method is implicit, all substeps run
  // detection, except with lagged contact. With self contact they do there, too: the friction of
  // layers would be off by 3 %.
  const bool has_own_step = scene.simulation.substeps || !std::isfinite(method->stability_limit());
  const bool may_skip = !has_own_step || (frame_context.lags && !self_contacts);
  const double longest = std::min(longest_step, frame_context.motion_step);
  if (!may_skip || 2 * h > longest || !is_settled()) return;

  const double max_displacement = max_undetected();
  const double speed = max_speed(start_velocities);
  const double time = std::min(longest, max_displacement / speed);
  const double until_last = std::round(frame_context.left / h) - 1;
  frame_context.planned_steps = static_cast<int>(std::max(1.0, std::min(time / h, until_last)));
  if (frame_context.planned_steps > 1) {
    frame_context.max_undetected_move =
        std::min(max_displacement, 2 * h * frame_context.planned_steps * speed);
  }
}

double Simulator::Impl::max_undetected() {
  double max_displacement = motion_share * shortest_rest_length(cloth);
  if (self_contacts) max_displacement = std::min(max_displacement, 2 * cloth.min_thickness());
  if (!std::isfinite(max_displacement)) return 0;

  const Vector3 reach = Vector3::Constant(max_displacement);
  const Eigen::AlignedBox3d box(state.positions.colwise().minCoeff().transpose() - reach,
                                state.positions.colwise().maxCoeff().transpose() + reach);
  for (const MovingCollider& collider : colliders) {
    const double speed = collider.max_speed_in(box);
    const Clearance keeps = clearance(collider.shape(), cloth, stretch_after(longest_step));
    if (!collider.reaches(box, speed * longest_step + keeps.points)) continue;
    frame_context.collider_speed = std::max(frame_context.collider_speed, speed);
  }
  return max_displacement;
}

void Simulator::Impl::end_detection(double h) {
  frame_context.since = frame_context.undetected_move = 0;
  frame_context.steps_left = may_skip_detection(h) ? frame_context.planned_steps - 1 : 0;
  frame_context.planned_steps = 0;
}

void Simulator::Impl::count_displacement(double h) {
  frame_context.undetected_move += h * max_speed(state.velocities);
  frame_context.recovers = frame_context.recovers || collider_contacts.recovers();
  frame_context.steps_left = may_skip_detection(h) ? frame_context.steps_left - 1 : 0;
}

bool Simulator::Impl::may_skip_detection(double h) const {
  const double next = 2 * h * max_speed(state.velocities);  // at most twice as fast
  return is_settled() && frame_context.undetected_move + next <= frame_context.max_undetected_move;
}

}  // namespace clothsim
