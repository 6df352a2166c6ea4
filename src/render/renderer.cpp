#include "clothsim/render/renderer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <utility>

#include "clothsim/render/gl_error.h"
#include "clothsim/render/shading_uniforms.h"
#include "clothsim/render/translucency.h"
#include "clothsim/render/visible_points.h"
#include "renderer_impl.h"

namespace clothsim {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Resets states that draws change and restore; a draw that throws does not restore them.
void set_state() {
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_CLAMP);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glCullFace(GL_BACK);
}

}  // namespace

Renderer::Impl::Impl(const RendererOptions& o) : options(o), context(o.egl_device) {
  GLint max_samples = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &max_samples);
  options.samples = std::clamp(options.samples, 1, static_cast<int>(max_samples));
  glDepthFunc(GL_LEQUAL);
  glFrontFace(GL_CW);  // image row 0 is OpenGL's lowest row, which reverses the winding
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_buffer.id());
}

void Renderer::Impl::end_stage() {
  if (options.measure) glFinish();
}

const ShaderProgram& Renderer::Impl::use_program(const std::string& vertex,
                                                 const std::string& fragment) {
  const char* const define = shadowed ? "SHADOWS" : "";
  const std::string name = vertex + " " + fragment + " " + define;
  auto place = programs.find(name);
  if (place == programs.end())
    place = programs.emplace(name, ShaderProgram(options.shaders, vertex, fragment, define)).first;
  place->second.use();
  return place->second;
}

const ShaderProgram& Renderer::Impl::use_item(const DrawItem& item, const std::string& fragment) {
  const ShaderProgram& program = use_program("surface.vert", fragment);
  program.set("rotation", item.rotation);
  program.set("translation", item.translation);
  program.set("shrinkage", item.dip);
  set_displacement(*item.shading, program, textures);
  if (shadowed) program.set("shadow_map", shadow_unit);
  return program;
}

void Renderer::Impl::upload(const Snapshot& snapshot, const Camera& camera, bool keep_last) {
  const Vector3& eye = camera.pose.position;
  optical_axes = camera.pose.orientation.normalized().toRotationMatrix();

  items.clear();
  if (snapshot.cloth) {
    if (!cloth) cloth.emplace();
    cloth->update(snapshot, keep_last);
    items = cloth->items(snapshot, eye);
  } else {
    cloth.reset();
  }

  colliders.resize(snapshot.colliders.size());
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const ColliderView& view = snapshot.colliders[i];
    if (!view.visible) {
      colliders[i].hide();
      continue;
    }
    colliders[i].update(view);
    items.push_back(colliders[i].item(view, static_cast<int>(i) + cloth_id + 1, eye));
    DrawItem& item = items.back();
    if (cloth && item.sphere_radius) {
      item.dip = cloth->dip_below_sphere(item.translation - items.front().translation,
                                         *item.sphere_radius);
    }
  }
}

void Renderer::Impl::draw_background(const Snapshot& snapshot, const Camera& camera) {
  const Color color = linear_from_srgb(snapshot.background.color);
  const Eigen::Vector4f clear(static_cast<float>(color[0]), static_cast<float>(color[1]),
                              static_cast<float>(color[2]), 1);
  glClearBufferfv(GL_COLOR, 0, clear.data());
  if (!snapshot.background.sky) return;

  // A ray of the optical frame is linear in the position in the picture.
  const Eigen::Matrix4d p = projection_matrix(camera);
  Eigen::Matrix3d ray_from_ndc;
  ray_from_ndc << 1 / p(0, 0), 0, -p(0, 2) / p(0, 0),  //
      0, 1 / p(1, 1), -p(1, 2) / p(1, 1),              //
      0, 0, 1;
  glDisable(GL_DEPTH_TEST);
  const ShaderProgram& program = use_program("background.vert", "background.frag");
  program.set("ray_from_ndc", Eigen::Matrix3d(optical_axes * ray_from_ndc));
  set_environment(snapshot.background.sky, program, textures);
  glBindVertexArray(no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

void Renderer::Impl::draw_lines(const DrawItem& item, const Wireframe& wireframe) {
  const ShaderProgram& program = use_item(item, fragment_shader(*item.shading));
  for (const LineRange& range : item.lines) {
    const auto family = static_cast<std::size_t>(range.family);
    if (!wireframe.families[family]) continue;
    program.set("base_color", linear_from_srgb(wireframe.colors[family]));
    item.mesh->draw_lines(range.first, range.count);
  }
}

void Renderer::Impl::draw_translucent(const std::vector<const DrawItem*>& translucent,
                                      const Camera& camera) {
  if (translucent.empty()) return;
  const BackToFront order = sort_back_to_front(translucent, camera);
  glBindVertexArray(no_vertices.id());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, sorted_triangles.id());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(order.triangles.size() * sizeof(order.triangles[0])),
               order.triangles.data(), GL_STREAM_DRAW);

  // Objects behind are drawn already; a layer does not hide the layers behind it.
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  for (const BackToFront::Run& run : order.runs) {
    const DrawItem& item = *run.item;
    const ShaderProgram& program = use_item(item, fragment_shader(*item.shading));
    set_shading(*item.shading, program, textures);
    item.mesh->draw_triangles(sorted_triangles, {run.first, run.count});
  }
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void Renderer::Impl::draw_color(const Snapshot& snapshot, const Camera& camera) {
  if (!color_target || color_target->width() != camera.width ||
      color_target->height() != camera.height)
    color_target.emplace(camera.width, camera.height, options.samples);
  color_target->bind();
  glViewport(0, 0, camera.width, camera.height);
  glEnable(GL_FRAMEBUFFER_SRGB);
  const float farthest = 1;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  draw_background(snapshot, camera);

  std::vector<const DrawItem*> translucent;
  for (const DrawItem& item : items) {
    if (std::holds_alternative<Translucent>(*item.shading)) {
      translucent.push_back(&item);
    } else if (const auto* wireframe = std::get_if<Wireframe>(item.shading)) {
      draw_lines(item, *wireframe);
    } else {
      const ShaderProgram& program = use_item(item, fragment_shader(*item.shading));
      set_shading(*item.shading, program, textures);
      // From outside, the far half of a sphere is invisible.
      const bool closed = item.sphere_radius && item.translation.norm() > *item.sphere_radius &&
                          !std::holds_alternative<Displacement>(*item.shading);
      if (closed) glEnable(GL_CULL_FACE);
      item.mesh->draw_triangles(item.own_triangles);
      glDisable(GL_CULL_FACE);
    }
  }
  draw_translucent(translucent, camera);
  check_gl("drawing the colour image");
}

/// Starts the transfers of all images before the first wait.
void Renderer::Impl::start_reading(const Camera& camera, bool color, const TruthImages& truth) {
  if (color) {
    color_target->resolve_for_reading();
    color_reader.start(camera.width, camera.height, GL_RGB, GL_UNSIGNED_BYTE, 3);
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i]) continue;
    const TruthFormat& format = truth_formats[i];
    truth_target->bind_for_reading(i);
    truth_readers[i].start(camera.width, camera.height, format.format, format.type, format.bytes);
  }
}

Renderer::Renderer(const RendererOptions& options) : impl_(std::make_unique<Impl>(options)) {}

Renderer::~Renderer() {
  // Objects of the context can only be deleted while it is current.
  try {
    impl_->context.make_current();
  } catch (const GlError&) {
    // The driver is gone, and its objects with it.
  }
}

void Renderer::Impl::draw(const Snapshot& snapshot, const Camera& camera,
                          const WantedImages& wanted, const TruthImages& truth) {
  shadowed = false;
  if (wanted.color) {
    const std::optional<Camera> light = draw_shadow_map(snapshot, camera);
    set_frame(snapshot, camera, light);
    shadowed = light.has_value();
    draw_color(snapshot, camera);
    shadowed = false;
  } else {
    set_frame(snapshot, camera, std::nullopt);
  }
  if (truth != TruthImages{}) draw_truth(camera, truth);
}

void Renderer::render(const Snapshot& snapshot, const Camera& camera, const WantedImages& wanted,
                      Images& images) {
  assert(snapshot.colliders.size() <= 254);
  const auto start = Clock::now();
  impl_->context.make_current();
  set_state();
  // After a failed picture, the next one has no flow.
  impl_->camera_before = std::exchange(impl_->camera_last, std::nullopt);
  impl_->upload(snapshot, camera, wanted.flow);
  impl_->end_stage();
  const auto uploaded = Clock::now();

  const TruthImages truth{wanted.depth, wanted.mask, wanted.uv, wanted.normals, wanted.flow};
  impl_->draw(snapshot, camera, wanted, truth);
  impl_->textures.sweep();
  impl_->end_stage();
  const auto drawn = Clock::now();
  impl_->start_reading(camera, wanted.color, truth);

  images.width = camera.width;
  images.height = camera.height;
  const auto place = [&](auto& image, bool is_wanted, std::size_t channels) {
    const auto pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    image.resize(is_wanted ? channels * pixels : 0);
    return static_cast<void*>(image.data());
  };
  void* const color = place(images.color, wanted.color, 3);
  const std::array<void*, truth.size()> places{
      place(images.depth, wanted.depth, 1), place(images.mask, wanted.mask, 1),
      place(images.uv, wanted.uv, 2), place(images.normals, wanted.normals, 3),
      place(images.flow, wanted.flow, 2)};
  images.visible_points.reset();  // computed while the GPU draws
  if (wanted.visible_points && snapshot.cloth) {
    images.visible_points = visible_points(camera, *snapshot.positions,
                                           snapshot.cloth->triangles.empty(), impl_->items);
  }
  if (wanted.color) impl_->color_reader.finish(color);
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (truth[i]) impl_->truth_readers[i].finish(places[i]);
  add_noise(camera.depth_noise, snapshot.time, camera.near, images.depth);
  check_gl("reading the images back");
  if (wanted.flow) impl_->camera_last = camera;

  impl_->times = {std::chrono::duration<double>(uploaded - start).count(),
                  std::chrono::duration<double>(drawn - uploaded).count(), seconds_since(drawn)};
}

const std::string& Renderer::device() const { return impl_->context.description(); }

const RenderTimes& Renderer::times() const { return impl_->times; }

}  // namespace clothsim
