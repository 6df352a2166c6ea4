#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace clothsim {

/// What an image file says of itself before its pixels.
struct ImageHeader {
  std::uint32_t width;
  std::uint32_t height;
  std::uint32_t pixel_bytes;  // decoded
};

/// Of a PNG, JPEG, TIFF or BMP file with the contents `bytes`; empty: it is none of these.
std::optional<ImageHeader> read_image_header(const std::string& bytes);

}  // namespace clothsim
