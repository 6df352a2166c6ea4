#pragma once

#include <vector>

#include "stage.h"

namespace clothsim {

/// The values of pixel (u, v) of an image with two or three channels.
template <int channels>
Eigen::Matrix<double, channels, 1> pixel(const Images& images, const std::vector<float>& image,
                                         int u, int v) {
  Eigen::Matrix<double, channels, 1> values;
  for (int c = 0; c < channels; ++c)
    values[c] = double(image[static_cast<std::size_t>(channels * (v * images.width + u) + c)]);
  return values;
}

/// The value of the mask.
int id(const Images& images, int u, int v);

/// Calls visit(u, v) for each pixel.
template <class Visit>
void for_each_pixel(const Camera& camera, const Visit& visit) {
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) visit(u, v);
}

/// Pixel of a point [pixel].
Eigen::Vector2d project(const Camera& c, const Vector3& point);

/// A cloth that bends, a ball that rolls, and a box and a camera that move and turn.
struct Moving {
  Stage stage;
  Snapshot now;
  Camera camera_now;

  Moving();
};

}  // namespace clothsim
