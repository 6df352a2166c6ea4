#include "clothsim/render/gl_handles.h"

#include <sstream>

#include "clothsim/render/gl_error.h"

namespace clothsim {

void check_gl(const char* doing) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  std::ostringstream message;
  message << "OpenGL error 0x" << std::hex << error << " while " << doing;
  throw GlError(message.str());
}

}  // namespace clothsim
