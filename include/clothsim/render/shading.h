#pragma once

#include <array>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/render/image.h"

namespace clothsim {

/// Red, green, blue in [0, 1] as a colour picker shows them (sRGB).
using Color = Vector3;

/// ka Ia + kd (I / r^2) max(0, n.l) + ks (I / r^2) max(0, n.h)^power (Blinn 1977). The colour or
/// the texture of the surface multiplies ka and kd; highlights have the colour of the light.
struct Phong {
  double ka = 0.1;
  double kd = 1;
  double ks = 0.5;
  double power = 100;
  bool ambient = true;
  bool diffuse = true;
  bool specular = true;
};

/// Lines: a cloth's springs, or the mesh of a collider, which takes the first colour.
struct Wireframe {
  static constexpr const char* name = "wireframe";
  std::array<bool, 3> families{true, true, true};  // by SpringFamily
  std::array<Color, 3> colors{Color{0.9, 0.9, 0.9}, Color{1, 0.6, 0.1}, Color{0.2, 0.6, 1}};
};

/// (1 + n) / 2 along the world's axes, n facing the camera's side. Not sRGB: byte / 255 is the
/// value.
struct NormalColor {
  static constexpr const char* name = "normal";
};

struct Diffuse {
  static constexpr const char* name = "diffuse";
  Color color{0.8, 0.25, 0.2};
  double kd = 1;
};

struct BlinnPhong {
  static constexpr const char* name = "blinn_phong";
  Color color{0.8, 0.25, 0.2};
  Phong phong;
};

/// The image alone, without light.
struct Textured {
  static constexpr const char* name = "texture";
  std::shared_ptr<const Image> image;
};

/// Blinn-Phong with the normal of a height map: (-dU, -dV, 1) in the frame of tangent, bitangent
/// and normal, dU = (h(u + 1/w, v) - h(u, v)) * height_scaling * normal_scaling, dV the same along
/// v.
struct Bump {
  static constexpr const char* name = "bump";
  Color color{0.6, 0.6, 0.65};
  Phong phong;
  std::shared_ptr<const HeightMap> height_map;
  double height_scaling = 0.1;  // [m]
  double normal_scaling = 100;
};

/// As Bump, and the vertices move along their normal by h * height_scaling.
struct Displacement : Bump {
  static constexpr const char* name = "displacement";
};

struct Mirror {
  static constexpr const char* name = "mirror";
  std::shared_ptr<const CubeMap> environment;
};

struct PhongTexture {
  static constexpr const char* name = "phong_texture";
  std::shared_ptr<const Image> image;
  Phong phong;
};

/// Transparent PhongTexture. With `by_light` the opacity falls from 1 without light to `alpha` in
/// full light, so that highlights are more transparent.
struct Translucent {
  static constexpr const char* name = "translucent";
  std::shared_ptr<const Image> image;
  Phong phong;
  double alpha = 0.5;
  bool by_light = false;
};

/// color * (floor(diffuse * levels) / levels + ambient), diffuse clamped to 1.
struct Cartoon {
  static constexpr const char* name = "cartoon";
  Color color{0.3, 0.6, 0.9};
  double kd = 1;
  int levels = 4;
  double ambient = 0.1;
};

/// The look of an object: one of the shaders with its parameters.
using Shading = std::variant<Wireframe, NormalColor, Diffuse, BlinnPhong, Textured, Bump,
                             Displacement, Mirror, PhongTexture, Translucent, Cartoon>;

const char* shading_name(const Shading&);

/// The names of all shaders, in the order of Shading.
std::vector<std::string> shading_names();

/// The shading of that name with its defaults. Throws InvalidValue with the key {"shader"}.
Shading make_shading(const std::string& name);

/// Throws InvalidValue with a key relative to the shading, such as {"power"}, also for an image
/// that is missing.
void validate(const Shading&);

/// The same without the images.
void validate_numbers(const Shading&);

}  // namespace clothsim
