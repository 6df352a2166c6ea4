#include "clothsim/render/targets.h"

#include "clothsim/render/gl_error.h"

namespace clothsim {
namespace {

void make_storage(const Renderbuffer& buffer, GLenum format, int width, int height, int samples) {
  glBindRenderbuffer(GL_RENDERBUFFER, buffer.id());
  // One sample a pixel is asked for as none: a buffer of its own kind.
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width,
                                   height);
}

void attach(const Renderbuffer& buffer, GLenum attachment) {
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
}

void check_complete() {
  check_gl("making a framebuffer");
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GlError("the driver has no framebuffer of the kind and size asked for");
}

}  // namespace

ColorTarget::ColorTarget(int width, int height, int samples) : width_(width), height_(height) {
  make_storage(samples_, GL_SRGB8_ALPHA8, width, height, samples);
  make_storage(depth_, GL_DEPTH_COMPONENT32F, width, height, samples);
  glBindFramebuffer(GL_FRAMEBUFFER, drawn_.id());
  attach(samples_, GL_COLOR_ATTACHMENT0);
  attach(depth_, GL_DEPTH_ATTACHMENT);
  check_complete();

  make_storage(resolved_, GL_SRGB8_ALPHA8, width, height, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, read_.id());
  attach(resolved_, GL_COLOR_ATTACHMENT0);
  check_complete();
}

void ColorTarget::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, drawn_.id()); }

void ColorTarget::resolve_for_reading() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, read_.id());
  glEnable(GL_FRAMEBUFFER_SRGB);  // the mean of the samples' light, whatever was drawn since
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, read_.id());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
}

TruthTarget::TruthTarget(int width, int height) : width_(width), height_(height) {
  make_storage(depth_image_, GL_R32F, width, height, 1);
  make_storage(mask_, GL_R8, width, height, 1);
  make_storage(depth_, GL_DEPTH_COMPONENT32F, width, height, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  attach(depth_image_, GL_COLOR_ATTACHMENT0);
  attach(mask_, GL_COLOR_ATTACHMENT1);
  attach(depth_, GL_DEPTH_ATTACHMENT);
  const GLenum images[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, images);
  check_complete();
}

void TruthTarget::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id()); }

void TruthTarget::bind_depth_for_reading() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
}

void TruthTarget::bind_mask_for_reading() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glReadBuffer(GL_COLOR_ATTACHMENT1);
}

}  // namespace clothsim
