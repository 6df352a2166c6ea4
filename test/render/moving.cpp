#include "moving.h"

#include <cmath>

namespace clothsim {

int id(const Images& images, int u, int v) {
  return images.mask[static_cast<std::size_t>(v * images.width + u)];
}

Eigen::Vector2d project(const Camera& c, const Vector3& point) {
  const Vector3 p = c.pose.orientation.conjugate() * (point - c.pose.position);
  return {c.fx * p.x() / p.z() + c.cx, c.fy * p.y() / p.z() + c.cy};
}

Moving::Moving() {
  ColliderView box;
  box.shape = Cuboid{{0.3, 0.2, 0.25}};
  box.pose.position = {0.15, 0.8, 0.3};
  stage.snapshot.colliders.push_back(box);
  now = stage.snapshot;
  Points moved = *now.positions;
  for (Eigen::Index i = 0; i < moved.rows(); ++i)
    moved.row(i) += 0.05 * Vector3(std::sin(3 * moved(i, 1)), moved(i, 0), moved(i, 1)).transpose();
  move_cloth(now, moved);
  for (ColliderView& collider : now.colliders) {
    collider.pose.position += Vector3(0.03, -0.02, 0.04);
    collider.pose.orientation =
        Eigen::AngleAxisd(0.2, Vector3(1, 2, -1).normalized()) * collider.pose.orientation;
  }
  camera_now = stage.camera;
  camera_now.pose = look_at({-0.25, -0.55, 1.25}, {0.62, 0.43, 0.12});
  camera_now.fx *= 1.1;
  camera_now.cy -= 2;
}

}  // namespace clothsim
