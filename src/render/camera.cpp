#include "clothsim/render/camera.h"

#include <cmath>

#include "ranges.h"

namespace clothsim {
namespace {

constexpr Range image_side{1, 8192, "pixel"};  // a size that every driver supports
constexpr Range focal_length{1e-3, 1e6, "pixel"};
constexpr Range principal_point{-1e6, 1e6, "pixel"};
constexpr Range plane_distance{1e-6, 1e7, "m"};
constexpr Range field_of_view{1e-3, M_PI - 1e-3, "rad"};
constexpr Range unit_part{-2, 2, ""};

// Below this distance the line of sight has no direction [m].
constexpr double shortest_sight = 1e-9;

}  // namespace

Camera camera_with_fov(int width, int height, double horizontal_fov) {
  check_range("field_of_view", horizontal_fov, field_of_view);
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.5 * width / std::tan(0.5 * horizontal_fov);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  validate(camera);
  return camera;
}

Pose look_at(const Vector3& eye, const Vector3& target) {
  check_range("eye", eye, coordinate_range);
  check_range("target", target, coordinate_range);
  const Vector3 sight = target - eye;
  if (sight.norm() < shortest_sight)
    throw InvalidValue({"target"}, "the eye's own position", "another point [m]");
  const Vector3 forward = sight.normalized();

  // The image's right is level and perpendicular to the line of sight.
  Vector3 right = forward.cross(Vector3::UnitZ());
  if (right.norm() < shortest_sight) right = forward.cross(Vector3::UnitY());
  right.normalize();

  Eigen::Matrix3d axes;
  axes << right, forward.cross(right), forward;
  return {eye, Eigen::Quaterniond(axes)};
}

void validate(const Camera& c) {
  check_range("width", c.width, image_side);
  check_range("height", c.height, image_side);
  check_range("fx", c.fx, focal_length);
  check_range("fy", c.fy, focal_length);
  check_range("cx", c.cx, principal_point);
  check_range("cy", c.cy, principal_point);
  check_range("near", c.near, plane_distance);
  check_range("far", c.far, {c.near, plane_distance.max, "m"});
  inside("depth_noise", [&] { validate(c.depth_noise); });
  check_range("position", c.pose.position, coordinate_range);
  check_range("orientation", c.pose.orientation.vec(), unit_part);
  check_range("orientation", c.pose.orientation.w(), unit_part);
}

Eigen::Vector2d pixel_of(const Camera& c, const Vector3& point) {
  return {c.fx * point.x() / point.z() + c.cx, c.fy * point.y() / point.z() + c.cy};
}

Eigen::Matrix4d projection_matrix(const Camera& c) {
  // A pixel extends by half a pixel to either side of its centre, hence the 0.5.
  Eigen::Matrix4d p = Eigen::Matrix4d::Zero();
  p(0, 0) = 2 * c.fx / c.width;
  p(0, 2) = 2 * (c.cx + 0.5) / c.width - 1;
  p(1, 1) = 2 * c.fy / c.height;
  p(1, 2) = 2 * (c.cy + 0.5) / c.height - 1;
  p(2, 2) = (c.far + c.near) / (c.far - c.near);
  p(2, 3) = -2 * c.far * c.near / (c.far - c.near);
  p(3, 2) = 1;
  return p;
}

}  // namespace clothsim
