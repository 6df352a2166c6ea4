#pragma once

#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// What the colour image is drawn to: sRGB with several samples a pixel, resolved to one.
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

/// What depth (32 bits) and mask (8 bits) are drawn to, one sample a pixel.
class TruthTarget {
 public:
  TruthTarget(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }

  void bind() const;
  void bind_depth_for_reading() const;
  void bind_mask_for_reading() const;

 private:
  int width_, height_;
  Renderbuffer depth_image_, mask_, depth_;
  Framebuffer framebuffer_;
};

}  // namespace clothsim
