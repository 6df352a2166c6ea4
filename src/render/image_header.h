#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace clothsim {

/// The data in an image file's header.
struct ImageHeader {
  std::uint32_t width;
  std::uint32_t height;
  std::uint32_t pixel_bytes;  // decoded
};

/// Reads the header of a PNG, JPEG, TIFF or BMP file with the contents `bytes`; empty: another
/// format.
std::optional<ImageHeader> read_image_header(const std::string& bytes);

}  // namespace clothsim
