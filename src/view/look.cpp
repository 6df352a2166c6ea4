#include "clothsim/view/look.h"

#include <type_traits>

namespace clothsim {
namespace {

/// Fills in the parameters that a shading has.
struct Fill {
  const Look& look;
  ImageStore& images;

  void operator()(Wireframe& s) const { s.families = look.springs; }
  void operator()(NormalColor&) const {}
  void operator()(Diffuse& s) const {
    s.color = look.color;
    s.kd = look.phong.kd;
  }
  void operator()(BlinnPhong& s) const {
    s.color = look.color;
    s.phong = look.phong;
  }
  void operator()(Textured& s) const { s.image = images.image(look.texture, "texture"); }
  void operator()(Bump& s) const {
    s.color = look.color;
    s.phong = look.phong;
    s.height_map = images.height_map(look.height_map, "height_map");
    s.height_scaling = look.height_scaling;
    s.normal_scaling = look.normal_scaling;
  }
  void operator()(Mirror& s) const {
    s.environment = images.cube_map(look.environment, "environment");
  }
  void operator()(PhongTexture& s) const {
    s.image = images.image(look.texture, "texture");
    s.phong = look.phong;
  }
  void operator()(Translucent& s) const {
    s.image = images.image(look.texture, "texture");
    s.phong = look.phong;
    s.alpha = look.alpha;
    s.by_light = look.by_light;
  }
  void operator()(Cartoon& s) const {
    s.color = look.color;
    s.kd = look.phong.kd;
    s.levels = look.levels;
    s.ambient = look.phong.ka;
  }
};

}  // namespace

Shading make_shading(const Look& look, ImageStore& images) {
  Shading shading = make_shading(look.shader);
  std::visit(Fill{look, images}, shading);
  validate(shading);
  return shading;
}

}  // namespace clothsim
