#pragma once

#include <cstdint>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/draw_item.h"

namespace clothsim {

/// A point within this distance of a surface is on it, not behind it [m].
constexpr double on_surface = 1e-4;

/// Numbers, ascending, of those `points` of a cloth [m, N x 3] that the camera sees: in the image,
/// between the near and the far plane, and not occluded. Surfaces of the `items`, including the
/// cloth, occlude as in the mask, with two exceptions: displaced surfaces occlude where they were,
/// and a point is occluded neither by the triangles around it nor, if the cloth is a `rope`, by its
/// tube. Spheres are exact.
std::vector<std::uint32_t> visible_points(const Camera&, const Points& points, bool rope,
                                          const std::vector<DrawItem>& items);

}  // namespace clothsim
