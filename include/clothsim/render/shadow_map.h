#pragma once

#include <optional>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/draw_item.h"
#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// A camera at the light, positions relative to the picture's camera [m], that sees all objects
/// that cast shadows, or the 150 degrees about their middle. Empty: no object casts one, or the
/// light is in their middle.
std::optional<Camera> light_camera(const Vector3& light, const std::vector<DrawItem>& items);

/// Whether an object casts a shadow: lines and planes do not, as planes are unbounded.
bool casts_shadow(const DrawItem&);

/// Distances of lit surfaces from the light in each direction (Williams 1978, "Casting curved
/// shadows on curved surfaces"): a depth texture for comparison in shaders.
class ShadowMap {
 public:
  static constexpr int side = 2048;  // [pixel] 1 m at 1 m away is 1 mm, for 4 million pixels

  ShadowMap();

  /// Binds it for drawing, without occluders.
  void clear() const;

  /// Binds it for reading by shaders.
  void bind(int unit) const;

 private:
  Texture depth_;
  Framebuffer framebuffer_;
};

}  // namespace clothsim
