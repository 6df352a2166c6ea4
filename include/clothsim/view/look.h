#pragma once

#include <array>
#include <string>

#include "clothsim/render/shading.h"
#include "clothsim/view/image_store.h"

namespace clothsim {

/// The look of an object as a user sets it: a shader by name, and the parameters of all shaders, so
/// that the shader can be changed without losing the others' parameters.
struct Look {
  std::string shader = "blinn_phong";
  Color color{0.8, 0.25, 0.2};
  Phong phong;
  std::string texture = "fabric.png";  // an image file, or one of the package's
  std::string height_map = "quilt_height.png";
  std::string environment = "sky";  // a folder of six images, or a panorama
  double height_scaling = 0.01;     // [m]
  double normal_scaling = 100;
  double alpha = 0.5;
  bool by_light = false;
  int levels = 4;
  std::array<bool, 3> springs{true, true, true};  // lines of a wireframe, by SpringFamily
};

/// The shader with its own parameters and images. Throws InvalidValue with a key such as
/// {"texture"}, also for parameters of other shaders, so that any shader can be chosen next; the
/// package's own images for other shaders are not read.
Shading make_shading(const Look&, ImageStore&);

}  // namespace clothsim
