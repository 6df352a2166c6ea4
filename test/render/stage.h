#pragma once

#include <functional>
#include <optional>

#include "reference.h"
#include "render_fixture.h"

namespace clothsim {

/// Linear colour by a formula, or nothing if the pixel is not to be compared. `view` points to
/// the camera.
using Formula = std::function<std::optional<Vector3>(const Hit&, const Vector3& view)>;

constexpr double byte_tolerance = 2;      // of 255
constexpr double filtered_tolerance = 3;  // texture units interpolate texels with weights of 8 bits

/// Draws, and compares a grid of pixels well inside object `id` with the formula at the point
/// from the reference tracer. Returns the number of pixels compared.
int compare(const Snapshot&, const Camera&, int id, const Mesh&, const Formula&,
            Renderer& renderer = shared_renderer(), double tolerance = byte_tolerance);

/// Linear light of an sRGB colour.
Vector3 linear(const Color&);

/// (I / r^2) max(0, n.l)
double lambert(const Light&, const Vector3& at, const Vector3& n);

/// ka Ia + kd (I / r^2) max(0, n.l) + ks (I / r^2) max(0, n.h)^p, ka and kd times the colour
Vector3 blinn_phong(const Phong&, const Light&, const Vector3& albedo, const Vector3& at,
                    const Vector3& n, const Vector3& view);

/// A smooth image of a few pixels, so that a pixel of the picture is smaller than one of its own.
std::shared_ptr<const Image> small_image();
std::shared_ptr<const HeightMap> small_heights();

/// Six faces, each of one colour.
std::shared_ptr<const CubeMap> colored_cube();

/// A waved cloth and a sphere above it, before a camera and a light.
struct Stage {
  Snapshot snapshot = flat_cloth(16, 16);
  Camera camera = camera_with_fov(120, 90, 0.9);
  Mesh cloth, sphere;

  Stage();

  /// Compares cloth and sphere with this shading.
  void expect(const Shading&, const Formula&, double tolerance = byte_tolerance);
};

}  // namespace clothsim
