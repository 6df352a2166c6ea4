#include "clothsim/render/targets.h"

#include <limits>

#include "clothsim/render/gl_error.h"

namespace clothsim {
namespace {

void make_storage(const Renderbuffer& buffer, GLenum format, int width, int height, int samples) {
  glBindRenderbuffer(GL_RENDERBUFFER, buffer.id());
  // For one sample a pixel, 0 is passed: a buffer without multisampling.
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples > 1 ? samples : 0, format, width,
                                   height);
}

void attach(const Renderbuffer& buffer, GLenum attachment) {
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
}

GLenum attachment(std::size_t image) { return GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(image); }

void check_complete() {
  check_gl("making a framebuffer");
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GlError("the driver has no framebuffer of the kind and size asked for");
}

constexpr float no_depth = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

const std::array<TruthFormat, std::tuple_size_v<TruthImages>> truth_formats{{
    {GL_R32F, GL_RED, GL_FLOAT, sizeof(float), no_depth},
    {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 0},
    {GL_RG32F, GL_RG, GL_FLOAT, 2 * sizeof(float), nan},
    {GL_RGBA32F, GL_RGB, GL_FLOAT, 3 * sizeof(float), nan},  // drivers need not draw to GL_RGB32F
    {GL_RG32F, GL_RG, GL_FLOAT, 2 * sizeof(float), nan},
}};

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
  glEnable(GL_FRAMEBUFFER_SRGB);  // averages samples in linear light; draws may disable it
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, read_.id());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
}

TruthTarget::TruthTarget(int width, int height, const TruthImages& wanted)
    : width_(width), height_(height), wanted_(wanted) {
  make_storage(depth_, GL_DEPTH_COMPONENT32F, width, height, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  attach(depth_, GL_DEPTH_ATTACHMENT);
  std::array<GLenum, std::tuple_size_v<TruthImages>> outputs{};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    outputs[i] = wanted[i] ? attachment(i) : GL_NONE;
    if (!wanted[i]) continue;
    make_storage(images_[i].emplace(), truth_formats[i].storage, width, height, 1);
    attach(*images_[i], attachment(i));
  }
  glDrawBuffers(static_cast<GLsizei>(outputs.size()), outputs.data());
  check_complete();
}

void TruthTarget::clear() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    const float nothing = truth_formats[i].nothing;
    const float pixel[] = {nothing, nothing, nothing, nothing};
    if (wanted_[i]) glClearBufferfv(GL_COLOR, static_cast<GLint>(i), pixel);
  }
  const float farthest = 1;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void TruthTarget::bind_for_reading(std::size_t image) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glReadBuffer(attachment(image));
}

}  // namespace clothsim
