#pragma once

#include <cstddef>
#include <cstdint>

#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// Brings an image from the framebuffer bound for reading back to main memory through a pixel
/// buffer that is used again and again. start() several readers, then finish() each, so that the
/// transfers overlap.
class PixelReader {
 public:
  void start(int width, int height, GLenum format, GLenum type, std::size_t bytes_per_pixel);

  /// Waits and copies the image to `pixels`, which has room for it.
  void finish(void* pixels);

 private:
  Buffer buffer_;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

}  // namespace clothsim
