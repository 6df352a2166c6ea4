#include "clothsim/render/mesh.h"
#include "renderer_impl.h"

namespace clothsim {
namespace {

/// The matrix from a position relative to a camera, along the world's axes, to (u, v, 1) times its
/// depth.
Eigen::Matrix3d pixel_matrix(const Camera& c) {
  Eigen::Matrix3d k;
  k << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1;
  return k * c.pose.orientation.normalized().toRotationMatrix().transpose();
}

}  // namespace

void Renderer::Impl::set_truth(const Camera& camera, const DrawItem& item,
                               const ShaderProgram& program) const {
  program.set("id", static_cast<double>(item.id));
  program.set("ray_of_pixel", Eigen::Matrix3d(pixel_matrix(camera).inverse()));
  const bool was_there = camera_before && item.before;
  program.set("near_before", was_there ? camera_before->near : infinity);
  if (!was_there) return;
  program.set("pixel_before", pixel_matrix(*camera_before));
  program.set("rotation_before", item.before->rotation);
  program.set("translation_before", Vector3(item.before->origin - camera_before->pose.position));
}

void Renderer::Impl::draw_sphere_truth(const Camera& camera, const DrawItem& item) {
  if (!box) {
    box.emplace();
    const Mesh cube = box_mesh(Vector3::Ones());
    box->upload_topology(cube.uv, cube.triangles, cube.lines);
    box->upload_surface(cube.positions, cube.normals, cube.tangents);
  }
  // The far sides of a box around the sphere, which are visible even where the camera is inside.
  const ShaderProgram& program = use_program("surface.vert", "sphere_truth.frag");
  program.set("rotation", Eigen::Matrix3d(*item.sphere_radius * Eigen::Matrix3d::Identity()));
  program.set("translation", item.translation);
  program.set("radius", *item.sphere_radius);
  program.set("shrinkage", 0.0);
  program.set("dip", item.dip);
  set_truth(camera, item, program);
  if (item.before)
    program.set("turn", Eigen::Matrix3d(item.before->rotation * item.rotation.transpose()));
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glEnable(GL_DEPTH_CLAMP);
  box->draw_triangles();
  glDisable(GL_DEPTH_CLAMP);
  glCullFace(GL_BACK);
  glDisable(GL_CULL_FACE);
}

void Renderer::Impl::draw_truth(const Camera& camera, const TruthImages& wanted) {
  if (!truth_target || truth_target->width() != camera.width ||
      truth_target->height() != camera.height || truth_target->wanted() != wanted)
    truth_target.emplace(camera.width, camera.height, wanted);
  truth_target->clear();
  glViewport(0, 0, camera.width, camera.height);
  glDisable(GL_FRAMEBUFFER_SRGB);

  for (const DrawItem& item : items) {
    if (item.sphere_radius && !std::holds_alternative<Displacement>(*item.shading)) {
      draw_sphere_truth(camera, item);
    } else {
      const ShaderProgram& program = use_item(item, "truth.frag");
      program.set("shrinkage", 0.0);
      set_truth(camera, item, program);
      item.mesh->draw_triangles(item.own_triangles);
    }
  }
  check_gl("drawing the images of the surfaces");
}

}  // namespace clothsim
