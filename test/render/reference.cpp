#include "reference.h"

#include <cmath>

#include "render_fixture.h"

namespace clothsim {
namespace {

/// Blends value(column, row) of the four pixels around (u, v); rows count from the top.
template <class Value>
double bilinear(int width, int height, const Eigen::Vector2d& uv, Value value) {
  const double x = uv.x() * width - 0.5, y = uv.y() * height - 0.5;
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  const auto wrap = [](double i, int n) { return (static_cast<int>(i) % n + n) % n; };
  const int x0 = wrap(std::floor(x), width), x1 = wrap(std::floor(x) + 1, width);
  const int y0 = height - 1 - wrap(std::floor(y), height);
  const int y1 = height - 1 - wrap(std::floor(y) + 1, height);
  return (1 - fy) * ((1 - fx) * value(x0, y0) + fx * value(x1, y0)) +
         fy * ((1 - fx) * value(x0, y1) + fx * value(x1, y1));
}

}  // namespace

std::optional<Hit> trace(const Mesh& mesh, const Vector3& eye, const Vector3& ray) {
  std::optional<Hit> nearest;
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.positions.row(t[0]), b = mesh.positions.row(t[1]),
                  c = mesh.positions.row(t[2]);
    const Vector3 e1 = b - a, e2 = c - a, p = ray.cross(e2), q = (eye - a).cross(e1);
    const double det = e1.dot(p);
    if (det == 0) continue;
    const double wb = (eye - a).dot(p) / det, wc = ray.dot(q) / det, distance = e2.dot(q) / det;
    if (wb < 0 || wc < 0 || wb + wc > 1 || distance <= 0) continue;
    if (nearest && nearest->distance <= distance) continue;
    const Vector3 w(1 - wb - wc, wb, wc);
    const auto blend = [&](const auto& rows) {
      return (w[0] * rows.row(t[0]) + w[1] * rows.row(t[1]) + w[2] * rows.row(t[2]))
          .transpose()
          .eval();
    };
    const bool front = det > 0;
    nearest = Hit{distance,
                  eye + distance * ray,
                  (front ? 1 : -1) * blend(mesh.normals).normalized(),
                  blend(mesh.tangents),
                  blend(mesh.uv),
                  front};
  }
  return nearest;
}

double sample(const Image& image, int channel, const Eigen::Vector2d& uv) {
  return bilinear(image.width, image.height, uv, [&](int x, int y) {
    return linear_of_srgb(image.rgb[static_cast<std::size_t>(3 * (y * image.width + x) + channel)] /
                          255.0);
  });
}

double sample(const HeightMap& map, const Eigen::Vector2d& uv) {
  return bilinear(map.width, map.height, uv, [&](int x, int y) {
    return double(map.heights[static_cast<std::size_t>(y * map.width + x)]);
  });
}

}  // namespace clothsim
