#include "clothsim/render/shading_uniforms.h"
#include "renderer_impl.h"

namespace clothsim {
namespace {

/// The uniform block of all shaders in std140 layout (shaders/frame.glsl).
struct FrameBlock {
  Eigen::Matrix4f clip_from_eye;
  Eigen::Vector4f right, down, forward, depth_terms, light_position, light;
  Eigen::Matrix4f shadow_from_eye;
  Eigen::Vector4f shadow;
};

Eigen::Vector4f padded(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), 0};
}

/// From positions relative to another camera, along the world's axes, to the clip space of a camera
/// at `origin` there.
Eigen::Matrix4f clip_matrix(const Camera& camera, const Vector3& origin) {
  const Eigen::Matrix3d to_optical =
      camera.pose.orientation.normalized().toRotationMatrix().transpose();
  Eigen::Matrix4d optical_from_eye = Eigen::Matrix4d::Identity();
  optical_from_eye.topLeftCorner<3, 3>() = to_optical;
  optical_from_eye.topRightCorner<3, 1>() = -to_optical * origin;
  return (projection_matrix(camera) * optical_from_eye).cast<float>();
}

void upload_block(const FrameBlock& block, const Buffer& buffer) {
  glBindBuffer(GL_UNIFORM_BUFFER, buffer.id());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(block), &block, GL_STREAM_DRAW);
}

}  // namespace

void Renderer::Impl::set_frame(const Snapshot& snapshot, const Camera& camera,
                               const std::optional<Camera>& light) {
  const Eigen::Matrix4d projection = projection_matrix(camera);
  FrameBlock block{};
  block.clip_from_eye = clip_matrix(camera, Vector3::Zero());
  block.right = padded(optical_axes.col(0));
  block.down = padded(optical_axes.col(1));
  block.forward = padded(optical_axes.col(2));
  block.depth_terms =
      Eigen::Vector4d(projection(2, 2), projection(2, 3), camera.near, camera.far).cast<float>();
  block.light_position = padded(snapshot.light.position - camera.pose.position);
  block.light = padded(Vector3(snapshot.light.intensity, snapshot.light.ambient, 0));
  if (light) {
    block.shadow_from_eye = clip_matrix(*light, light->pose.position);
    block.shadow = padded(Vector3(1 / light->fx, 0, 0));
    shadow_map->bind(shadow_unit);
  }
  upload_block(block, frame_buffer);
}

/// Empty: there are no shadows.
std::optional<Camera> Renderer::Impl::draw_shadow_map(const Snapshot& snapshot,
                                                      const Camera& camera) {
  if (!snapshot.light.shadows) return std::nullopt;
  const std::optional<Camera> light =
      light_camera(snapshot.light.position - camera.pose.position, items);
  if (!light) return std::nullopt;
  if (!shadow_map) shadow_map.emplace();
  shadow_map->clear();
  FrameBlock block{};
  block.clip_from_eye = clip_matrix(*light, light->pose.position);
  upload_block(block, frame_buffer);
  for (const DrawItem& item : items) {
    if (!casts_shadow(item)) continue;
    use_item(item, "shadow.frag");
    item.mesh->draw_triangles(item.own_triangles);
  }
  check_gl("drawing the shadow map");
  return light;
}

}  // namespace clothsim
