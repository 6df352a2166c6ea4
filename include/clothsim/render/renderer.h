#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/render/camera.h"
#include "clothsim/render/snapshot.h"

namespace clothsim {

struct RendererOptions {
  std::string shaders;              // folder of the shader files
  std::optional<int> egl_device{};  // index of egl_devices(); empty: the best
  int samples = 4;                  // per pixel, for the edges of the colour image; 1: none
  bool measure = false;             // wait between stages to measure each of them
};

/// The images to make; the others are left empty and cost nothing.
struct WantedImages {
  bool color = true;
  bool depth = true;
  bool mask = true;
  bool uv = false;
  bool normals = false;
  bool flow = false;
  bool visible_points = false;

  bool any() const { return color || depth || mask || uv || normals || flow || visible_points; }
};

/// Images of one instant, row 0 on top.
struct Images {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> color;  // r, g, b of each pixel, sRGB
  std::vector<float> depth;         // [m] along the optical axis; +inf where there is nothing
  std::vector<std::uint8_t> mask;   // 0 nothing, 1 cloth, 2 the first collider, ...
                                    // then the second of several cloths, ...
  std::vector<float> uv;            // u, v of the cloth (Cloth::uv); NaN where there is none
  std::vector<float> normals;  // unit normal x, y, z in the optical frame; NaN where there is none

  /// Optical flow [pixel], right and down: the displacement of the surface point in a pixel since
  /// the last picture, from its pixel in that picture to this one. NaN without a surface, for
  /// surfaces that were not there or were before the near plane, and everywhere unless the last
  /// picture had flow, too.
  std::vector<float> flow;

  /// Numbers of the cloth's visible points, ascending: visible_points(). Empty: not wanted, or no
  /// cloth.
  std::optional<std::vector<std::uint32_t>> visible_points;
};

/// Seconds of the last render(). Without `measure`, `read` includes the wait for the drawing.
struct RenderTimes {
  double upload = 0;
  double draw = 0;
  double read = 0;
};

/// Draws snapshots without window or display. Make, use and destroy it in one thread.
///
/// All images but colour show the surface of each object, without lines, opacity or antialiasing;
/// spheres in them are exact for any mesh.
class Renderer {
 public:
  /// Throws NoContext where OpenGL is not available, InvalidValue for a device that does not exist.
  explicit Renderer(const RendererOptions&);
  ~Renderer();

  /// Draws into `images`, whose memory is reused. Snapshot and camera must be valid (see the
  /// validate() of their parts). Throws ShaderError and GlError.
  void render(const Snapshot&, const Camera&, const WantedImages&, Images& images);

  /// The device of the OpenGL context.
  const std::string& device() const;

  const RenderTimes& times() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
