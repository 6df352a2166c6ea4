#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// Target of the colour image: sRGB with several samples a pixel, resolved to one.
class ColorTarget {
 public:
  ColorTarget(int width, int height, int samples);
  int width() const { return width_; }
  int height() const { return height_; }

  void bind() const;

  /// Averages the samples and binds the result for reading.
  void resolve_for_reading() const;

 private:
  int width_, height_;
  Renderbuffer samples_, depth_, resolved_;
  Framebuffer drawn_, read_;
};

/// The wanted images of the surfaces, in the order of the outputs in shaders/truth.glsl: depth,
/// mask, uv, normals, flow.
using TruthImages = std::array<bool, 5>;

/// The format of one of these images.
struct TruthFormat {
  GLenum storage;
  GLenum format, type;  // of the image read back
  std::size_t bytes;    // of a pixel read back
  float nothing;        // value of a pixel without a surface
};
extern const std::array<TruthFormat, std::tuple_size_v<TruthImages>> truth_formats;

/// Target of the wanted images of the surfaces, one sample a pixel.
class TruthTarget {
 public:
  TruthTarget(int width, int height, const TruthImages& wanted);
  int width() const { return width_; }
  int height() const { return height_; }

  const TruthImages& wanted() const { return wanted_; }

  /// Binds it for drawing, without surfaces.
  void clear() const;

  /// Binds a wanted image, by its index in TruthImages.
  void bind_for_reading(std::size_t image) const;

 private:
  int width_, height_;
  TruthImages wanted_;
  std::array<std::optional<Renderbuffer>, std::tuple_size_v<TruthImages>> images_;
  Renderbuffer depth_;
  Framebuffer framebuffer_;
};

}  // namespace clothsim
