#include "clothsim/view/view_yaml.h"

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

constexpr double default_field_of_view = 0.8;  // [rad], 46 degrees

ReadValue into_optional(std::optional<double>& target) {
  return [&target](const YAML::Node& node) { target = read_number(node); };
}

std::vector<Field> look_fields(Look& look) {
  Phong& phong = look.phong;
  const auto read_shader = [&look](const YAML::Node& node) {
    const std::vector<std::string> names = shading_names();
    look.shader = names[static_cast<std::size_t>(read_choice(node, names))];
  };
  return {{"shader", read_shader},
          {"color", into(look.color)},
          {"ka", into(phong.ka)},
          {"kd", into(phong.kd)},
          {"ks", into(phong.ks)},
          {"power", into(phong.power)},
          {"ambient", into(phong.ambient)},
          {"diffuse", into(phong.diffuse)},
          {"specular", into(phong.specular)},
          {"texture", into(look.texture)},
          {"height_map", into(look.height_map)},
          {"environment", into(look.environment)},
          {"height_scaling", into(look.height_scaling)},
          {"normal_scaling", into(look.normal_scaling)},
          {"alpha", into(look.alpha)},
          {"by_light", into(look.by_light)},
          {"levels", into(look.levels)},
          {"springs", [&look](const YAML::Node& node) { read_springs(node, look.springs); }}};
}

void read_collider_look(const YAML::Node& node, ColliderLook& collider) {
  std::vector<Field> fields = look_fields(collider.look);
  fields.push_back({"segments", into(collider.segments)});
  fields.push_back({"extent", into(collider.extent)});
  read_map(node, fields);
}

void read_cloth_look(const YAML::Node& node, Look& cloth) { read_map(node, look_fields(cloth)); }

/// Looks by name: each takes values that it does not set from `all`.
template <typename ObjectLook, typename Read>
void read_named(const YAML::Node& node, const ObjectLook& all, const Read& read,
                std::map<std::string, ObjectLook>& looks) {
  if (!node.IsDefined() || node.IsNull()) return;
  std::vector<Field> fields;
  if (node.IsMap()) {
    for (const auto& entry : node) {
      const std::string name = entry.first.Scalar();
      fields.push_back(
          {name, [&, name](const YAML::Node& look) { read(look, looks[name] = all); }});
    }
  }
  read_map(node, fields);
}

/// The focal lengths and the principal point, or a field of view with the principal point in the
/// middle.
struct Intrinsics {
  std::optional<double> field_of_view, fx, fy, cx, cy;

  void apply(Camera& camera) const {
    if (field_of_view && (fx || fy))
      throw InvalidValue({"field_of_view"}, to_text(*field_of_view), "either this or fx and fy");
    if (fx.has_value() != fy.has_value())
      throw InvalidValue({fx ? "fy" : "fx"}, "nothing", "a number of pixels, as both are needed");
    camera = with_intrinsics(camera);
  }

 private:
  Camera with_intrinsics(Camera camera) const {
    const Camera centred =
        camera_with_fov(camera.width, camera.height, field_of_view.value_or(default_field_of_view));
    camera.fx = fx.value_or(centred.fx);
    camera.fy = fy.value_or(centred.fy);
    camera.cx = cx.value_or(centred.cx);
    camera.cy = cy.value_or(centred.cy);
    return camera;
  }
};

void read_light(const YAML::Node& node, Light& light) {
  read_map(node, {{"position", into(light.position)},
                  {"intensity", into(light.intensity)},
                  {"ambient", into(light.ambient)}});
}

void read_noise(const YAML::Node& node, DepthNoise& noise) {
  read_map(node, {{"sigma", into(noise.sigma)}, {"seed", into(noise.seed)}});
}

/// The keys of the camera and its pose.
std::vector<Field> viewpoint_fields(View& view, Intrinsics& intrinsics) {
  Camera& camera = view.camera;
  return {{"width", into(camera.width)},
          {"height", into(camera.height)},
          {"field_of_view", into_optional(intrinsics.field_of_view)},
          {"fx", into_optional(intrinsics.fx)},
          {"fy", into_optional(intrinsics.fy)},
          {"cx", into_optional(intrinsics.cx)},
          {"cy", into_optional(intrinsics.cy)},
          {"near", into(camera.near)},
          {"far", into(camera.far)},
          {"depth_noise", [&](const YAML::Node& node) { read_noise(node, camera.depth_noise); }},
          {"eye", into(view.eye)},
          {"target", into(view.target)},
          {"frame", into(view.frame)},
          {"rate", into(view.rate)},
          {"each_step", into(view.each_step)},
          {"samples", into(view.samples)},
          {"egl_device", [&](const YAML::Node& node) { view.egl_device = read_int(node); }}};
}

}  // namespace

View read_view(const YAML::Node& root) {
  View view;
  Intrinsics intrinsics;
  YAML::Node cloths, colliders;  // read last, as they start from the look of all
  std::vector<Field> fields = viewpoint_fields(view, intrinsics);
  const std::vector<Field> looks = {
      {"light", [&](const YAML::Node& node) { read_light(node, view.light); }},
      {"shadows", into(view.light.shadows)},
      {"background", into(view.background)},
      {"sky", into(view.sky)},
      {"cloth", [&](const YAML::Node& node) { read_cloth_look(node, view.cloth); }},
      {"cloths", [&](const YAML::Node& node) { cloths = node; }},
      {"collider", [&](const YAML::Node& node) { read_collider_look(node, view.collider); }},
      {"colliders", [&](const YAML::Node& node) { colliders = node; }}};
  fields.insert(fields.end(), looks.begin(), looks.end());
  read_map(root, fields);
  inside("cloths", [&] { read_named(cloths, view.cloth, read_cloth_look, view.cloths); });
  inside("colliders",
         [&] { read_named(colliders, view.collider, read_collider_look, view.colliders); });
  intrinsics.apply(view.camera);
  validate(view);
  return view;
}

NamedView read_camera(const YAML::Node& root, const View& looks) {
  NamedView camera;
  View& view = camera.view;
  view.light = looks.light;
  view.background = looks.background;
  view.sky = looks.sky;
  view.cloth = looks.cloth;
  view.cloths = looks.cloths;
  view.collider = looks.collider;
  view.colliders = looks.colliders;
  view.egl_device = looks.egl_device;

  Intrinsics intrinsics;
  std::vector<Field> fields = viewpoint_fields(view, intrinsics);
  fields.insert(fields.begin(), {"name", into(camera.name)});
  read_map(root, fields);
  intrinsics.apply(view.camera);
  validate(view);
  return camera;
}

void validate(const View& view) {
  constexpr Range rate{0.01, 1000, "Hz"};
  constexpr Range samples{1, 64, ""};
  check_range("rate", view.rate, rate);
  check_range("samples", view.samples, samples);
  check_frame(view.frame);
  validate(view.camera);
}

}  // namespace clothsim
