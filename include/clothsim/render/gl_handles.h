#pragma once

#include <GL/glew.h>

#include <utility>

namespace clothsim {

/// Owns one OpenGL object: made with the handle, deleted with it, moved but not copied. The context
/// has to be current throughout.
template <class Kind>
class GlHandle {
 public:
  GlHandle() { Kind::create(&id_); }
  ~GlHandle() {
    if (id_ != 0) Kind::destroy(&id_);
  }
  GlHandle(GlHandle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

struct BufferKind {
  static void create(GLuint* id) { glGenBuffers(1, id); }
  static void destroy(GLuint* id) { glDeleteBuffers(1, id); }
};
struct VertexArrayKind {
  static void create(GLuint* id) { glGenVertexArrays(1, id); }
  static void destroy(GLuint* id) { glDeleteVertexArrays(1, id); }
};
struct TextureKind {
  static void create(GLuint* id) { glGenTextures(1, id); }
  static void destroy(GLuint* id) { glDeleteTextures(1, id); }
};
struct FramebufferKind {
  static void create(GLuint* id) { glGenFramebuffers(1, id); }
  static void destroy(GLuint* id) { glDeleteFramebuffers(1, id); }
};
struct RenderbufferKind {
  static void create(GLuint* id) { glGenRenderbuffers(1, id); }
  static void destroy(GLuint* id) { glDeleteRenderbuffers(1, id); }
};
struct ProgramKind {
  static void create(GLuint* id) { *id = glCreateProgram(); }
  static void destroy(GLuint* id) { glDeleteProgram(*id); }
};
template <GLenum stage>
struct ShaderKind {
  static void create(GLuint* id) { *id = glCreateShader(stage); }
  static void destroy(GLuint* id) { glDeleteShader(*id); }
};

using Buffer = GlHandle<BufferKind>;
using VertexArray = GlHandle<VertexArrayKind>;
using Texture = GlHandle<TextureKind>;
using Framebuffer = GlHandle<FramebufferKind>;
using Renderbuffer = GlHandle<RenderbufferKind>;
using Program = GlHandle<ProgramKind>;

/// Throws GlError where OpenGL reports an error since the last call; `doing` describes the
/// operation.
void check_gl(const char* doing);

}  // namespace clothsim
