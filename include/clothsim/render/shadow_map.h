#pragma once

#include <optional>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/draw_item.h"
#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// A camera at the light, positions relative to the picture's camera [m], that sees all that casts
/// shadows, or the 150 degrees about its middle. Empty: nothing does, or the light is in that
/// middle.
std::optional<Camera> light_camera(const Vector3& light, const std::vector<DrawItem>& items);

/// Whether an object casts a shadow: lines and planes do not, the latter as they end nowhere.
bool casts_shadow(const DrawItem&);

/// How far the light gets in each direction (Williams 1978, "Casting curved shadows on curved
/// surfaces"): a depth texture that shaders compare with.
class ShadowMap {
 public:
  static constexpr int side = 2048;  // [pixel] 1 m at 1 m away is 1 mm, for 4 million pixels

  ShadowMap();

  /// Binds it for drawing, with nothing in the light's way yet.
  void clear() const;

  /// Binds it for shaders to read.
  void bind(int unit) const;

 private:
  Texture depth_;
  Framebuffer framebuffer_;
};

}  // namespace clothsim
