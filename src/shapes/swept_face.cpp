#include "clothsim/shapes/swept_face.h"

#include <algorithm>

#include "shape_parts.h"

namespace clothsim {
namespace {

Triangle local_at(const MovingCollider& collider, const Triangle& from, const Triangle& to,
                  double share) {
  const Pose pose = collider.pose_at(share);
  Triangle t;
  for (std::size_t i = 0; i < 3; ++i) t[i] = to_local(pose, from[i] + share * (to[i] - from[i]));
  return t;
}

}  // namespace

std::optional<FaceDistance> swept_face_distance(const MovingCollider& collider,
                                                const Triangle& from, const Triangle& to,
                                                double offset) {
  // Bound on the way of the triangle's points in the collider's frame.
  const Vector3 moved = collider.pose().position - collider.previous().position;
  double max_displacement = 0, arm = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    max_displacement = std::max(max_displacement, (to[i] - from[i] - moved).norm());
    arm = std::max({arm, (from[i] - collider.previous().position).norm(),
                    (to[i] - collider.pose().position).norm()});
  }
  max_displacement += collider.last_turn() * arm;

  double share = 0;
  for (int step = 0; step < max_approaches && share < 1; ++step) {
    const Triangle t = local_at(collider, from, to, share);
    auto found = face_distance(collider.shape(), t, offset + (1 - share) * max_displacement);
    if (!found) return std::nullopt;
    if (found->value > offset && step + 1 < max_approaches) {
      share += (found->value - offset / 2) / max_displacement;
      continue;
    }
    if (share == 0 && found->value < 0) return std::nullopt;
    const Triangle end = local_at(collider, from, to, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      found->value += found->weights[i] * found->normal.dot(end[i] - t[i]);
    }
    return found;
  }
  return std::nullopt;
}

}  // namespace clothsim
