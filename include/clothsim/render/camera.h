#pragma once

#include <Eigen/Core>

#include "clothsim/model/types.h"
#include "clothsim/render/depth_noise.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// Pinhole camera. Pixel (u, v) is the centre of the pixel, as in ROS and OpenCV: the point (x, y,
/// z) in the camera's frame lies at u = fx x/z + cx, v = fy y/z + cy, and a centred principal point
/// is ((width - 1) / 2, (height - 1) / 2).
struct Camera {
  int width = 640;
  int height = 480;
  double fx = 554.25625842204;  // [pixel]; with 640 pixels a field of view of 60 degrees
  double fy = 554.25625842204;  // [pixel]
  double cx = 319.5;            // [pixel]
  double cy = 239.5;            // [pixel]
  Pose pose;                    // optical frame in the world: x right, y down, z forward
  double near = 0.05;           // [m] along z; nearer surfaces are clipped
  double far = 100;             // [m] along z
  DepthNoise depth_noise;       // of the depth image
};

/// Camera with square pixels and a centred principal point, at the world's origin, looking up.
/// `horizontal_fov` [rad] spans the image from edge to edge. Throws InvalidValue.
Camera camera_with_fov(int width, int height, double horizontal_fov);

/// Pose of an optical frame at `eye` [m] that looks at `target` [m] with world +z up in the image,
/// or +y where it looks along z. Throws InvalidValue where the two points coincide.
Pose look_at(const Vector3& eye, const Vector3& target);

/// Throws InvalidValue, with keys such as {"fx"}.
void validate(const Camera&);

/// Where the camera sees a point of its optical frame [m], which is in front of it [pixel].
Eigen::Vector2d pixel_of(const Camera&, const Vector3& point);

/// From the optical frame to OpenGL's clip space, in which image row 0 is the lowest row, so that
/// pixels come back in image order without a flip.
Eigen::Matrix4d projection_matrix(const Camera&);

}  // namespace clothsim
