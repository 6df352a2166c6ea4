#include "image_header.h"

#include <png.h>
#include <tiffio.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <tiffio.hxx>

namespace clothsim {
namespace {

/// Fewest channels after decoding by OpenCV, also for a palette.
constexpr std::uint32_t min_channels = 3;

bool begins_with(const std::string& bytes, const std::string& magic) {
  return bytes.compare(0, magic.size(), magic) == 0;
}

std::optional<ImageHeader> read_png(const std::string& bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) return {};
  const ImageHeader header{
      image.width, image.height,
      std::max<std::uint32_t>(PNG_IMAGE_PIXEL_SIZE(image.format), min_channels)};
  png_image_free(&image);
  return header;
}

std::optional<ImageHeader> read_jpeg(const std::string& bytes) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  int width = 0, height = 0, subsampling = 0, colors = 0;
  // Sets the size even for unknown chroma subsampling, for which it returns an error.
  tjDecompressHeader3(decoder.get(), reinterpret_cast<const unsigned char*>(bytes.data()),
                      bytes.size(), &width, &height, &subsampling, &colors);
  if (width <= 0 || height <= 0) return {};
  return ImageHeader{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
                     min_channels};
}

std::optional<ImageHeader> read_tiff(const std::string& bytes) {
  std::istringstream stream(bytes);
  const std::unique_ptr<TIFF, void (*)(TIFF*)> file(TIFFStreamOpen("image", &stream), TIFFClose);
  ImageHeader header{};
  if (!file || TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &header.width) == 0 ||
      TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &header.height) == 0) {
    return {};
  }
  std::uint16_t channels = 1, bits = 1;
  TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(file.get(), TIFFTAG_BITSPERSAMPLE, &bits);
  constexpr std::uint32_t byte = 8;
  header.pixel_bytes = std::max<std::uint32_t>(channels, min_channels) * ((bits + byte - 1) / byte);
  return header;
}

/// The header has 12 bytes with short sizes, or more with sizes that may be negative.
std::optional<ImageHeader> read_bmp(const std::string& bytes) {
  constexpr std::size_t start = 14, size_at = 18;
  constexpr std::uint32_t short_header = 12;
  std::uint32_t length = 0;
  std::int32_t long_size[2];
  std::uint16_t short_size[2];
  if (bytes.size() < size_at + sizeof long_size) return {};
  std::memcpy(&length, bytes.data() + start, sizeof length);
  std::memcpy(long_size, bytes.data() + size_at, sizeof long_size);
  std::memcpy(short_size, bytes.data() + size_at, sizeof short_size);
  if (length == short_header) return ImageHeader{short_size[0], short_size[1], min_channels + 1};
  const auto size = [&](int i) { return static_cast<std::uint32_t>(std::llabs(long_size[i])); };
  return ImageHeader{size(0), size(1), min_channels + 1};
}

}  // namespace

std::optional<ImageHeader> read_image_header(const std::string& bytes) {
  if (begins_with(bytes, "\x89PNG")) return read_png(bytes);
  if (begins_with(bytes, "\xff\xd8\xff")) return read_jpeg(bytes);
  if (begins_with(bytes, "II") || begins_with(bytes, "MM")) return read_tiff(bytes);
  if (begins_with(bytes, "BM")) return read_bmp(bytes);
  return {};
}

}  // namespace clothsim
