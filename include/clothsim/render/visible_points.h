#pragma once

#include <cstdint>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/draw_item.h"

namespace clothsim {

/// Closer than this to a surface a point is on it, and not behind it [m].
constexpr double on_surface = 1e-4;

/// Numbers, ascending, of those `points` of a cloth [m, N x 3] that the camera sees: in the image,
/// between the near and the far plane, and with nothing before them. Surfaces of the `items`, the
/// cloth's among them, hide as in the mask, but that displaced ones hide where they were, and that
/// neither the triangles around a point hide it nor, if it is a `rope`, its tube. Spheres are
/// exact.
std::vector<std::uint32_t> visible_points(const Camera&, const Points& points, bool rope,
                                          const std::vector<DrawItem>& items);

}  // namespace clothsim
