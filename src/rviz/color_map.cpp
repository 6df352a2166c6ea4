#include "color_map.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/types.h"

namespace clothsim_rviz {
namespace {

using clothsim::Vector3;

/// Moreland's space: CIELAB in polar coordinates, magnitude, saturation [rad] and hue [rad].
struct Msh {
  double magnitude, saturation, hue;
};

// The ends of the paper's cool to warm map, and the white between them, with the hue towards which
// each end turns on its way.
constexpr Msh cool{80, 1.08, -1.1};
constexpr Msh cool_white{88, 0, -1.661};
constexpr Msh warm_white{88, 0, 1.061};
constexpr Msh warm{80, 1.08, 0.5};

Vector3 to_lab(const Msh& msh) {
  const double chroma = msh.magnitude * std::sin(msh.saturation);
  return {msh.magnitude * std::cos(msh.saturation), chroma * std::cos(msh.hue),
          chroma * std::sin(msh.hue)};
}

/// The inverse of CIELAB's cube root with its linear beginning (CIE 15:2004).
double from_lab_curve(double f) {
  constexpr double bend = 6.0 / 29;
  return f > bend ? f * f * f : 3 * bend * bend * (f - 4.0 / 29);
}

Vector3 to_xyz(const Vector3& lab) {
  const Vector3 white_d65(0.9505, 1, 1.089);
  const double fy = (lab[0] + 16) / 116;
  const Vector3 f(fy + lab[1] / 500, fy, fy - lab[2] / 200);
  return white_d65.cwiseProduct(f.unaryExpr(&from_lab_curve));
}

/// IEC 61966-2-1.
double srgb_curve(double linear) {
  return linear > 0.0031308 ? 1.055 * std::pow(linear, 1 / 2.4) - 0.055 : 12.92 * linear;
}

Vector3 to_srgb(const Vector3& xyz) {
  Eigen::Matrix3d linear_of;
  linear_of << 3.2406, -1.5372, -0.4986,  //
      -0.9689, 1.8758, 0.0415,            //
      0.0557, -0.2040, 1.0570;
  return (linear_of * xyz).unaryExpr(&srgb_curve);
}

Msh mix(const Msh& a, const Msh& b, double t) {
  return {(1 - t) * a.magnitude + t * b.magnitude, (1 - t) * a.saturation + t * b.saturation,
          (1 - t) * a.hue + t * b.hue};
}

}  // namespace

std::array<std::uint8_t, 3> color_at(double t) {
  const Msh msh = t < 0.5 ? mix(cool, cool_white, 2 * t) : mix(warm_white, warm, 2 * t - 1);
  const Vector3 srgb = to_srgb(to_xyz(to_lab(msh)));
  std::array<std::uint8_t, 3> bytes{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double value = std::clamp(srgb[static_cast<int>(i)], 0.0, 1.0);
    bytes[i] = static_cast<std::uint8_t>(std::lround(255 * value));
  }
  return bytes;
}

ColorMap color_map() {
  ColorMap map{};
  for (std::size_t i = 0; i < color_map_size; ++i) {
    const auto color = color_at(double(i) / (color_map_size - 1));
    std::copy(color.begin(), color.end(), &map[3 * i]);
  }
  return map;
}

}  // namespace clothsim_rviz
