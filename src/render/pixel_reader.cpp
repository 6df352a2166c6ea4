#include "clothsim/render/pixel_reader.h"

#include <cstring>

#include "clothsim/render/gl_error.h"

namespace clothsim {

void PixelReader::start(int width, int height, GLenum format, GLenum type,
                        std::size_t bytes_per_pixel) {
  size_ = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * bytes_per_pixel;
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  if (size_ != capacity_) {
    glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(size_), nullptr, GL_STREAM_READ);
    capacity_ = size_;
  }
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, format, type, nullptr);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

void PixelReader::finish(void* pixels) {
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_.id());
  const void* mapped =
      glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(size_), GL_MAP_READ_BIT);
  if (mapped) std::memcpy(pixels, mapped, size_);
  const bool intact = mapped && glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (!intact) throw GlError("the driver did not hand back an image");
}

}  // namespace clothsim
