#pragma once

#include <array>
#include <cstdint>

namespace clothsim_rviz {

/// Blue to red through white, by t from 0 to 1, as sRGB bytes. It is perceptually uniform and its
/// lightness hardly changes, so that shading cannot be mistaken for a value. Moreland, Diverging
/// color maps for scientific visualization, ISVC 2009.
std::array<std::uint8_t, 3> color_at(double t);

/// The colours at this many equidistant values from 0 to 1, including both.
constexpr int color_map_size = 256;
using ColorMap = std::array<std::uint8_t, 3 * color_map_size>;  // r, g, b of each
ColorMap color_map();

}  // namespace clothsim_rviz
