#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/render/image_folders.h"

namespace clothsim {

/// A colour image, three bytes a pixel in the order r, g, b, sRGB, top row first.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Heights from 0 to 1, top row first.
struct HeightMap {
  int width = 0;
  int height = 0;
  std::vector<float> heights;
};

/// Six square images of one size in the order +x, -x, +y, -y, +z, -z, seen from inside with +y up.
/// In the world, +y is up (+z of the world) and +z is the world's +y.
struct CubeMap {
  std::array<Image, 6> faces;
};

/// Largest side of an image file [pixel]: all but very old OpenGL drivers take it.
constexpr int largest_image_side = 8192;

/// Largest decoded size of an image file: six faces of 4096 x 4096 pixels, with alpha [bytes].
constexpr std::uint64_t largest_image_bytes = 6ULL * 4096 * 4096 * 4;

/// Read a PNG, JPEG, TIFF or BMP file. Throw InvalidValue with `key` for a file that is missing,
/// broken or not in `folders`, or an image whose header shows that it is too large to be decoded. A
/// height map is the red channel, of 8 or 16 bits.
std::shared_ptr<const Image> load_image(const std::string& path, const std::string& key,
                                        const ImageFolders& folders = {});
std::shared_ptr<const HeightMap> load_height_map(const std::string& path, const std::string& key,
                                                 const ImageFolders& folders = {});

/// Reads a folder with posx, negx, posy, negy, posz, negz as .png or .jpg, or one image that is
/// twice as wide as high, a panorama with the horizon along its middle.
std::shared_ptr<const CubeMap> load_cube_map(const std::string& path, const std::string& key,
                                             const ImageFolders& folders = {});

/// Throws InvalidValue with `key` unless save_image can write the format given by the extension of
/// `path`.
void check_image_ending(const std::string& path, const std::string& key);

/// Writes an image file, as PNG for the extension .png and so on. Throws std::runtime_error where
/// the file cannot be written.
void save_image(const std::string& path, const Image& image);

/// Write a PNG of 16 bits, depth [m] in whole millimetres with 0 for infinity and beyond 65.535 m,
/// and one of 8 bits. Top row first. Throw as save_image().
void save_depth(const std::string& path, int width, int height, const std::vector<float>& depth);
void save_mask(const std::string& path, int width, int height,
               const std::vector<std::uint8_t>& mask);

}  // namespace clothsim
