#include "clothsim/view/look.h"

namespace clothsim {
namespace {

/// Sets the numbers of a shading.
struct FillNumbers {
  const Look& look;

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
  void operator()(Textured&) const {}
  void operator()(Bump& s) const {
    s.color = look.color;
    s.phong = look.phong;
    s.height_scaling = look.height_scaling;
    s.normal_scaling = look.normal_scaling;
  }
  void operator()(Mirror&) const {}
  void operator()(PhongTexture& s) const { s.phong = look.phong; }
  void operator()(Translucent& s) const {
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

/// Sets the images of a shading.
struct FillImages {
  const Look& look;
  ImageStore& images;

  template <class Kind>
  void operator()(Kind&) const {}
  void operator()(Textured& s) const { s.image = texture(); }
  void operator()(PhongTexture& s) const { s.image = texture(); }
  void operator()(Translucent& s) const { s.image = texture(); }
  void operator()(Bump& s) const { s.height_map = height_map(); }
  void operator()(Displacement& s) const { s.height_map = height_map(); }
  void operator()(Mirror& s) const { s.environment = environment(); }

  std::shared_ptr<const Image> texture() const { return images.image(look.texture, "texture"); }
  std::shared_ptr<const HeightMap> height_map() const {
    return images.height_map(look.height_map, "height_map");
  }
  std::shared_ptr<const CubeMap> environment() const {
    return images.cube_map(look.environment, "environment");
  }
};

void check_all_shaders(const Look& look, ImageStore& images) {
  for (const std::string& name : shading_names()) {
    Shading shading = make_shading(name);
    std::visit(FillNumbers{look}, shading);
    validate_numbers(shading);
  }
  const Look own;
  const FillImages named{look, images};
  if (look.texture != own.texture) named.texture();
  if (look.height_map != own.height_map) named.height_map();
  if (look.environment != own.environment) named.environment();
}

}  // namespace

Shading make_shading(const Look& look, ImageStore& images) {
  Shading shading = make_shading(look.shader);
  check_all_shaders(look, images);
  std::visit(FillNumbers{look}, shading);
  std::visit(FillImages{look, images}, shading);
  validate(shading);
  return shading;
}

}  // namespace clothsim
