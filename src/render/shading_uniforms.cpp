#include "clothsim/render/shading_uniforms.h"

#include <cmath>

namespace clothsim {
namespace {

// Texture units. A unit holds one kind of texture, as OpenGL requires.
constexpr int image_unit = 0, height_unit = 1, environment_unit = 2;

void set_color(const Color& color, const ShaderProgram& program) {
  program.set("base_color", linear_from_srgb(color));
}

void set_phong(const Phong& p, const ShaderProgram& program) {
  program.set("ka", p.ambient ? p.ka : 0.0);
  program.set("kd", p.diffuse ? p.kd : 0.0);
  program.set("ks", p.specular ? p.ks : 0.0);
  program.set("power", p.power);
}

void set_image(const std::shared_ptr<const Image>& image, const ShaderProgram& program,
               TextureCache& textures) {
  textures.bind(image, image_unit);
  program.set("image", image_unit);
}

void set_height_map(const std::shared_ptr<const HeightMap>& map, const ShaderProgram& program,
                    TextureCache& textures) {
  textures.bind(map, height_unit);
  program.set("height_map", height_unit);
}

struct SetShading {
  const ShaderProgram& program;
  TextureCache& textures;

  void operator()(const Wireframe&) const {}
  void operator()(const NormalColor&) const {}
  void operator()(const Diffuse& s) const {
    set_color(s.color, program);
    program.set("kd", s.kd);
  }
  void operator()(const BlinnPhong& s) const {
    set_color(s.color, program);
    set_phong(s.phong, program);
  }
  void operator()(const Textured& s) const { set_image(s.image, program, textures); }
  void operator()(const Bump& s) const {
    set_color(s.color, program);
    set_phong(s.phong, program);
    set_height_map(s.height_map, program, textures);
    program.set("height_scaling", s.height_scaling);
    program.set("normal_scaling", s.normal_scaling);
  }
  void operator()(const Mirror& s) const { set_environment(s.environment, program, textures); }
  void operator()(const PhongTexture& s) const {
    set_image(s.image, program, textures);
    set_phong(s.phong, program);
  }
  void operator()(const Translucent& s) const {
    set_image(s.image, program, textures);
    set_phong(s.phong, program);
    program.set("alpha", s.by_light ? 1.0 : s.alpha);
    program.set("alpha_lit", s.alpha);
  }
  void operator()(const Cartoon& s) const {
    set_color(s.color, program);
    program.set("kd", s.kd);
    program.set("levels", static_cast<double>(s.levels));
    program.set("ambient", s.ambient);
  }
};

}  // namespace

Color linear_from_srgb(const Color& color) {
  return color.unaryExpr(
      [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); });
}

std::string fragment_shader(const Shading& shading) {
  // Displacement shades as bump does; the vertex shader moves the vertices.
  if (std::holds_alternative<Displacement>(shading)) return "bump.frag";
  return std::string(shading_name(shading)) + ".frag";
}

void set_shading(const Shading& shading, const ShaderProgram& program, TextureCache& textures) {
  std::visit(SetShading{program, textures}, shading);
}

void set_displacement(const Shading& shading, const ShaderProgram& program,
                      TextureCache& textures) {
  const auto* displacement = std::get_if<Displacement>(&shading);
  program.set("displacement", displacement ? displacement->height_scaling : 0.0);
  program.set("height_map", height_unit);
  if (displacement) set_height_map(displacement->height_map, program, textures);
}

void set_environment(const std::shared_ptr<const CubeMap>& environment,
                     const ShaderProgram& program, TextureCache& textures) {
  textures.bind(environment, environment_unit);
  program.set("environment", environment_unit);
}

}  // namespace clothsim
