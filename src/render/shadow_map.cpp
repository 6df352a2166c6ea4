#include "clothsim/render/shadow_map.h"

#include <algorithm>
#include <cmath>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/render/gl_error.h"

namespace clothsim {
namespace {

/// Sine of the largest half angle of a map, 75 degrees: beyond, pixels at its middle get too large.
const double widest = std::sin(75 * M_PI / 180);

/// A light nearer to the middle of the objects that cast shadows has no direction to it [m].
constexpr double no_distance = 1e-6;

/// The map's near plane, where the light is among the objects that cast shadows, as a share of
/// their size.
constexpr double nearest_share = 1e-3;

}  // namespace

bool casts_shadow(const DrawItem& item) {
  return !item.is_unbounded && !std::holds_alternative<Wireframe>(*item.shading);
}

std::optional<Camera> light_camera(const Vector3& light, const std::vector<DrawItem>& items) {
  Box box;
  for (const DrawItem& item : items) {
    if (!casts_shadow(item)) continue;
    const auto& [first, count] = item.own_points;
    for (int i = first; i < first + count; ++i) {
      const Vector3 point = item.positions->row(i);
      box.extend(item.rotation * point + item.translation);
    }
  }
  if (box.isEmpty()) return std::nullopt;
  const Vector3 to_box = box.center() - light;
  const double distance = to_box.norm(),
               radius = std::max(0.5 * box.diagonal().norm(), no_distance);
  if (distance < no_distance) return std::nullopt;

  const double sine = std::min(widest, radius / distance);
  Camera camera;
  camera.width = camera.height = ShadowMap::side;
  camera.fx = camera.fy = 0.5 * ShadowMap::side * std::sqrt(1 - sine * sine) / sine;
  camera.cx = camera.cy = 0.5 * (ShadowMap::side - 1);
  camera.near = std::max(distance - radius, nearest_share * radius);
  camera.far = distance + radius;
  camera.pose = {light, Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), to_box)};
  return camera;
}

ShadowMap::ShadowMap() {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, depth_.id());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, side, side, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.id(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  check_gl("making a shadow map");
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GlError("the driver has no framebuffer for shadows");
}

void ShadowMap::clear() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, side, side);
  const float farthest = 1;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void ShadowMap::bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, depth_.id());
}

}  // namespace clothsim
