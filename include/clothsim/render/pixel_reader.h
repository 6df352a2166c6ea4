#pragma once

#include <cstddef>

#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// Reads an image from the framebuffer bound for reading, through a pixel buffer that is reused.
/// start() several readers, then finish() each, so that the transfers overlap.
class PixelReader {
 public:
  void start(int width, int height, GLenum format, GLenum type, std::size_t bytes_per_pixel);

  /// Waits and copies the image to `pixels`, which must be large enough.
  void finish(void* pixels);

 private:
  Buffer buffer_;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

}  // namespace clothsim
