#include "clothsim/render/image.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/files.h"
#include "image_header.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

constexpr int panorama_ratio = 2;
constexpr double eight_bits = 255, sixteen_bits = 65535;

/// Formats that every build of OpenCV can write in colour.
constexpr const char* known_endings[] = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};

[[noreturn]] void refuse(const std::string& key, const std::string& path,
                         const std::string& expected) {
  throw InvalidValue({key}, "\"" + path + "\"", expected);
}

/// Reads the whole file. Checks its size first: a file without a size, as a pipe or a device, may
/// never end.
std::string read_bytes(const std::string& path, const std::string& key) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) refuse(key, path, "an image file that exists");
  if (size > largest_image_bytes) {
    throw InvalidValue({key}, "\"" + path + "\" of " + std::to_string(size) + " bytes",
                       "at most " + std::to_string(largest_image_bytes));
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size)))
    refuse(key, path, "an image file that can be read");
  return bytes;
}

/// Throws InvalidValue where the image is too large to be decoded.
void check_size(const ImageHeader& header, const std::string& path, const std::string& key,
                std::uint64_t max_bytes) {
  const std::string got = "\"" + path + "\" of " + std::to_string(header.width) + " x " +
                          std::to_string(header.height) + " pixels";
  if (std::max(header.width, header.height) > std::uint32_t{largest_image_side}) {
    throw InvalidValue({key}, got,
                       "at most " + std::to_string(largest_image_side) + " pixels a side");
  }
  if (std::uint64_t{header.width} * header.height * header.pixel_bytes > max_bytes) {
    throw InvalidValue({key}, got + " of " + std::to_string(header.pixel_bytes) + " bytes",
                       "at most " + std::to_string(max_bytes) + " bytes in all");
  }
}

/// Decodes an image after a check of the size in its header.
cv::Mat read(const std::string& path, int flags, const std::string& key,
             const ImageFolders& folders, std::uint64_t max_bytes = largest_image_bytes) {
  std::string bytes = read_bytes(folders.resolve(path, key), key);
  const std::optional<ImageHeader> header = read_image_header(bytes);
  cv::Mat image;
  if (header) {
    check_size(*header, path, key, max_bytes);
    try {
      image =
          cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8UC1, bytes.data()), flags);
    } catch (const cv::Exception&) {
      image.release();
    }
  }
  if (image.empty()) refuse(key, path, "a PNG, JPEG, TIFF or BMP file that OpenCV can read");
  return image;
}

Image from_bgr(const cv::Mat& bgr) {
  Image image{bgr.cols, bgr.rows, std::vector<std::uint8_t>(bgr.total() * 3)};
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.rgb.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

/// One of posx.png, posx.jpg, ...
std::string face_path(const std::string& folder, const char* face, const std::string& key) {
  for (const char* ending : {".png", ".jpg"}) {
    const fs::path path = fs::path(folder) / (std::string(face) + ending);
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) return path.string();
  }
  refuse(key, folder, "a folder with posx, negx, posy, negy, posz, negz as .png or .jpg");
}

/// The direction in the cube map through texel (s, t) of `face`, s and t from -1 to 1; OpenGL 3.3,
/// table 3.19.
cv::Vec3d cube_direction(std::size_t face, double s, double t) {
  switch (face) {
    case 0:
      return {1, -t, -s};
    case 1:
      return {-1, -t, s};
    case 2:
      return {s, 1, t};
    case 3:
      return {s, -1, -t};
    case 4:
      return {s, -t, 1};
    default:
      return {-s, -t, -1};
  }
}

/// Cuts a panorama into faces. Its middle is the cube's +z, its left is towards -x.
CubeMap from_panorama(const cv::Mat& panorama) {
  // One more column on either side, so that the seam at the back is smooth.
  cv::Mat padded;
  cv::copyMakeBorder(panorama, padded, 0, 0, 1, 1, cv::BORDER_WRAP);

  const int size = std::max(1, panorama.cols / 4);
  cv::Mat map_x(size, size, CV_32F), map_y(size, size, CV_32F);
  CubeMap cube;
  for (std::size_t face = 0; face < 6; ++face) {
    for (int row = 0; row < size; ++row) {
      for (int column = 0; column < size; ++column) {
        const cv::Vec3d d =
            cube_direction(face, 2 * (column + 0.5) / size - 1, 2 * (row + 0.5) / size - 1);
        const double around = std::atan2(d[0], d[2]), up = std::asin(d[1] / cv::norm(d));
        map_x.at<float>(row, column) =
            static_cast<float>((0.5 + around / (2 * M_PI)) * panorama.cols + 0.5);
        map_y.at<float>(row, column) = static_cast<float>((0.5 - up / M_PI) * panorama.rows - 0.5);
      }
    }
    cv::Mat view;
    cv::remap(padded, view, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    cube.faces[face] = from_bgr(view);
  }
  return cube;
}

std::string ending_of(const std::string& path) {
  std::string ending = fs::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace

std::shared_ptr<const Image> load_image(const std::string& path, const std::string& key,
                                        const ImageFolders& folders) {
  return std::make_shared<Image>(from_bgr(read(path, cv::IMREAD_COLOR, key, folders)));
}

std::shared_ptr<const HeightMap> load_height_map(const std::string& path, const std::string& key,
                                                 const ImageFolders& folders) {
  const cv::Mat image = read(path, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR, key, folders);
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    refuse(key, path, "an image of 8 or 16 bits a channel");
  cv::Mat red;
  cv::extractChannel(image, red, image.channels() >= 3 ? 2 : 0);

  auto map = std::make_shared<HeightMap>();
  map->width = red.cols;
  map->height = red.rows;
  map->heights.resize(red.total());
  cv::Mat heights(red.rows, red.cols, CV_32F, map->heights.data());
  red.convertTo(heights, CV_32F, 1 / (red.depth() == CV_8U ? eight_bits : sixteen_bits));
  return map;
}

std::shared_ptr<const CubeMap> load_cube_map(const std::string& path, const std::string& key,
                                             const ImageFolders& folders) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    const cv::Mat image = read(path, cv::IMREAD_COLOR, key, folders);
    if (image.cols != panorama_ratio * image.rows)
      refuse(key, path, "a panorama twice as wide as high, or a folder of six images");
    return std::make_shared<CubeMap>(from_panorama(image));
  }

  auto cube = std::make_shared<CubeMap>();
  const char* const names[] = {"posx", "negx", "posy", "negy", "posz", "negz"};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string file = face_path(path, names[i], key);
    const Image& face = cube->faces[i] =
        from_bgr(read(file, cv::IMREAD_COLOR, key, folders, largest_image_bytes / 6));
    if (face.width != face.height || face.width != cube->faces[0].width)
      refuse(key, file, "a square image of the size of the other five");
  }
  return cube;
}

void check_image_ending(const std::string& path, const std::string& key) {
  const std::vector<std::string> known(std::begin(known_endings), std::end(known_endings));
  if (std::find(known.begin(), known.end(), ending_of(path)) != known.end()) return;
  refuse(key, path, "a file name that ends in one of " + join(known));
}

namespace {

void save_png(const std::string& path, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(ending_of(path), image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 9}))
    throw std::runtime_error("cannot write " + path);
  write_file(path, std::string(bytes.begin(), bytes.end()));
}

}  // namespace

void save_image(const std::string& path, const Image& image) {
  cv::Mat bgr;
  cv::cvtColor(
      cv::Mat(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.rgb.data())), bgr,
      cv::COLOR_RGB2BGR);
  save_png(path, bgr);
}

void save_depth(const std::string& path, int width, int height, const std::vector<float>& depth) {
  cv::Mat millimetres(height, width, CV_16UC1);
  std::transform(depth.begin(), depth.end(), millimetres.begin<std::uint16_t>(), [](float metres) {
    const double value = std::round(1000.0 * metres);  // infinite without a surface
    return static_cast<std::uint16_t>(value <= 65535 ? value : 0);
  });
  save_png(path, millimetres);
}

void save_mask(const std::string& path, int width, int height,
               const std::vector<std::uint8_t>& mask) {
  save_png(path, cv::Mat(height, width, CV_8UC1, const_cast<std::uint8_t*>(mask.data())));
}

}  // namespace clothsim
