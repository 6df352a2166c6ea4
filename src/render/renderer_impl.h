#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/render/egl_context.h"
#include "clothsim/render/gl_handles.h"
#include "clothsim/render/pixel_reader.h"
#include "clothsim/render/renderer.h"
#include "clothsim/render/scene_objects.h"
#include "clothsim/render/shader_program.h"
#include "clothsim/render/shadow_map.h"
#include "clothsim/render/targets.h"
#include "clothsim/render/texture_cache.h"

namespace clothsim {

/// Colour is drawn in renderer.cpp, the images of the surfaces in renderer_truth.cpp, shadows in
/// renderer_light.cpp.
struct Renderer::Impl {
  explicit Impl(const RendererOptions& o);

  void upload(const Snapshot&, const Camera&, bool keep_last);
  void set_frame(const Snapshot&, const Camera&, const std::optional<Camera>& light);
  std::optional<Camera> draw_shadow_map(const Snapshot&, const Camera&);
  void draw_color(const Snapshot&, const Camera&);
  void draw_truth(const Camera&, const TruthImages&);
  /// Draws all wanted images.
  void draw(const Snapshot&, const Camera&, const WantedImages&, const TruthImages&);
  void start_reading(const Camera&, bool color, const TruthImages&);
  void draw_background(const Snapshot&, const Camera&);
  void draw_lines(const DrawItem&, const Wireframe&);
  void draw_translucent(const std::vector<const DrawItem*>&, const Camera&);
  void draw_sphere_truth(const Camera&, const DrawItem&);
  void set_truth(const Camera&, const DrawItem&, const ShaderProgram&) const;
  const ShaderProgram& use_program(const std::string& vertex, const std::string& fragment);
  const ShaderProgram& use_item(const DrawItem&, const std::string& fragment);
  void end_stage();

  RendererOptions options;
  EglContext context;  // before all members that need it
  VertexArray no_vertices;
  Buffer frame_buffer, sorted_triangles;
  std::map<std::string, ShaderProgram> programs;
  TextureCache textures;
  std::optional<ClothObject> cloth;
  std::vector<ColliderObject> colliders;
  std::optional<GpuMesh> box;
  std::optional<ColorTarget> color_target;
  std::optional<TruthTarget> truth_target;
  std::optional<ShadowMap> shadow_map;
  bool shadowed = false;  // the present draw has shadows
  PixelReader color_reader;
  std::array<PixelReader, std::tuple_size_v<TruthImages>> truth_readers;
  std::vector<DrawItem> items;
  Eigen::Matrix3d optical_axes;
  std::optional<Camera> camera_last, camera_before;  // of this picture and the last one, with flow
  RenderTimes times;
};

}  // namespace clothsim
