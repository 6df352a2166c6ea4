#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "clothsim/model/errors.h"
#include "clothsim/render/gl_error.h"
#include "render_fixture.h"

namespace clothsim::image_test {
namespace {

namespace fs = std::filesystem;

/// A folder of the test's own that is removed at the end.
struct Folder {
  fs::path path = fs::path(testing::TempDir()) / "clothsim_images";
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
  std::string file(const std::string& name) const { return (path / name).string(); }
};

template <class Load>
void expect_refused(Load load, const std::string& path) {
  try {
    load(path, "key");
    FAIL() << "read " << path;
  } catch (const InvalidValue& error) {
    EXPECT_EQ(error.key(), std::vector<std::string>{"key"});
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
  }
}

TEST(Image, ColoursComeBackInOrder) {
  const Folder folder;
  const Image image{2, 1, {10, 20, 30, 200, 100, 50}};
  for (const char* name : {"a.png", "a.bmp", "a.tiff"}) {
    save_image(folder.file("a.png"), image);
    cv::imwrite(folder.file(name), cv::imread(folder.file("a.png")));
    const auto read = load_image(folder.file(name), "texture");
    EXPECT_EQ(read->width, 2);
    EXPECT_EQ(read->height, 1);
    EXPECT_EQ(read->rgb, image.rgb);
  }
}

TEST(Image, DepthIsInMillimetresAndMaskIsAsItIs) {
  const Folder folder;
  const float none = std::numeric_limits<float>::infinity();
  save_depth(folder.file("depth.png"), 3, 2, {0.0014f, 1.0006f, none, 65.535f, 65.6f, 2.5f});
  const cv::Mat depth = cv::imread(folder.file("depth.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(depth.type(), CV_16UC1);
  const std::vector<int> expected = {1, 1001, 0, 65535, 0, 2500};
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(depth.at<std::uint16_t>(i / 3, i % 3), expected[static_cast<std::size_t>(i)]) << i;
  save_mask(folder.file("mask.png"), 2, 2, {0, 1, 2, 255});
  const cv::Mat mask = cv::imread(folder.file("mask.png"), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(mask.type(), CV_8UC1);
  EXPECT_EQ(mask.at<std::uint8_t>(1, 1), 255);
  EXPECT_EQ(mask.at<std::uint8_t>(0, 1), 1);
}

TEST(Image, TheEndingNamesTheFormat) {
  const Folder folder;
  const Image image{1, 1, {50, 50, 50}};
  for (const char* name : {"a.png", "a.jpg", "a.jpeg", "a.bmp", "a.tif", "a.tiff", "a.b.PNG"}) {
    EXPECT_NO_THROW(check_image_ending(folder.file(name), "key")) << name;
    save_image(folder.file(name), image);
    EXPECT_EQ(load_image(folder.file(name), "texture")->rgb, image.rgb) << name;
  }
  for (const char* name : {"a.xyz", "a", ".png", "a.png.txt"})
    expect_refused(check_image_ending, folder.file(name));
}

TEST(Image, HeightsAreTheRedChannelOf8Or16Bits) {
  const Folder folder;
  cv::imwrite(folder.file("color.png"), cv::Mat(1, 1, CV_8UC3, cv::Scalar(10, 20, 51)));
  EXPECT_FLOAT_EQ(load_height_map(folder.file("color.png"), "h")->heights[0], 0.2f);
  cv::imwrite(folder.file("gray.png"), cv::Mat(1, 1, CV_8UC1, cv::Scalar(102)));
  EXPECT_FLOAT_EQ(load_height_map(folder.file("gray.png"), "h")->heights[0], 0.4f);
  cv::imwrite(folder.file("deep.png"), cv::Mat(1, 1, CV_16UC1, cv::Scalar(1)));
  EXPECT_FLOAT_EQ(load_height_map(folder.file("deep.png"), "h")->heights[0], 1 / 65535.0f);
}

TEST(Image, MissingAndBrokenFilesAreNamed) {
  const Folder folder;
  std::ofstream(folder.file("text.png")) << "this is no image";
  std::ofstream(folder.file("empty.jpg"));
  for (const std::string& path : {folder.file("absent.png"), folder.file("text.png"),
                                  folder.file("empty.jpg"), folder.path.string(), std::string()}) {
    expect_refused([](auto... a) { load_image(a...); }, path);
    expect_refused([](auto... a) { load_height_map(a...); }, path);
    expect_refused([](auto... a) { load_cube_map(a...); }, path);
  }
  // A folder with one face of another size.
  for (const char* face : {"posx", "negx", "posy", "negy", "posz", "negz"})
    cv::imwrite(folder.file(std::string(face) + ".png"), cv::Mat::zeros(4, 4, CV_8UC3));
  EXPECT_EQ(load_cube_map(folder.path.string(), "sky")->faces[5].width, 4);
  cv::imwrite(folder.file("negy.png"), cv::Mat::zeros(8, 8, CV_8UC3));
  expect_refused([](auto... a) { load_cube_map(a...); }, folder.file("negy.png"));
  // Neither a panorama nor a folder.
  cv::imwrite(folder.file("square.png"), cv::Mat::zeros(8, 8, CV_8UC3));
  expect_refused([](auto... a) { load_cube_map(a...); }, folder.file("square.png"));
}

TEST(Image, LargerOnesThanTexturesCanBeAreRefused) {
  const Folder folder;
  for (const auto& [name, width, height] :
       {std::tuple{"wide.png", largest_image_side + 2, 1},
        std::tuple{"high.png", 1, largest_image_side + 1},
        std::tuple{"panorama.png", 2 * (largest_image_side / 2 + 1), largest_image_side / 2 + 1}}) {
    cv::imwrite(folder.file(name), cv::Mat::zeros(height, width, CV_8UC1));
    expect_refused([](auto... a) { load_image(a...); }, folder.file(name));
    expect_refused([](auto... a) { load_height_map(a...); }, folder.file(name));
    expect_refused([](auto... a) { load_cube_map(a...); }, folder.file(name));
  }
  cv::imwrite(folder.file("largest.png"), cv::Mat::zeros(1, largest_image_side, CV_8UC1));
  Snapshot snapshot = flat_cloth(3, 3);
  snapshot.cloth_shading = Textured{load_image(folder.file("largest.png"), "key")};
  EXPECT_NO_THROW(draw(snapshot, camera_with_fov(8, 6, 0.8)));
}

/// A file of a `width` x `height` picture of one colour.
std::string encoded(const std::string& ending, int width = 16, int height = 16) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(ending, cv::Mat::zeros(height, width, CV_8UC3), bytes);
  return {bytes.begin(), bytes.end()};
}

/// The same with other bytes from `where` on.
std::string patched(std::string bytes, std::size_t where, const std::string& others) {
  return bytes.replace(where, others.size(), others);
}

std::string image_refusal(const std::string& path) {
  try {
    load_image(path, "key");
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

// The files lack the pixels of their headers: the decoder calls them broken first.
TEST(Image, TheSizeIsCheckedBeforeAnythingIsDecoded) {
  const Folder folder;
  const std::string big_endian("\0\0\x75\x30", 4), little_endian("\x30\x75\0\0", 4);  // 30000
  std::string png = encoded(".png");
  png = patched(patched(png, 16, big_endian), 20, big_endian);
  png = patched(png, 29, std::string("\xe9\x45\x6f\xed", 4));  // checksum
  std::string jpeg = encoded(".jpg");
  jpeg = patched(jpeg, jpeg.find("\xff\xc0") + 5, std::string("\x75\x30\x75\x30", 4));
  std::string bmp = encoded(".bmp");
  bmp = patched(patched(bmp, 18, little_endian), 22, little_endian);
  std::string tiff = encoded(".tiff");
  const std::size_t width = tiff.find(std::string("\0\1\3\0\1\0\0\0", 8)),
                    height = tiff.find(std::string("\1\1\3\0\1\0\0\0", 8));
  ASSERT_NE(width, tiff.npos);
  ASSERT_NE(height, tiff.npos);
  tiff = patched(patched(tiff, width + 8, little_endian), height + 8, little_endian);
  for (const auto& [name, bytes] : {std::pair{"big.png", png}, std::pair{"big.jpg", jpeg},
                                    std::pair{"big.bmp", bmp}, std::pair{"big.tiff", tiff}}) {
    std::ofstream(folder.file(name), std::ios::binary) << bytes;
    const std::string message = image_refusal(folder.file(name));
    EXPECT_NE(message.find("of 30000 x 30000 pixels, expected at most 8192"), std::string::npos)
        << message;
  }
}

TEST(Image, DecodedBytesAreLimitedTogetherForACube) {
  const Folder folder;
  constexpr int side = 5000;  // as an image of its own, it is not too large
  std::ofstream(folder.file("posx.png"), std::ios::binary) << encoded(".png", side, side);
  EXPECT_EQ(load_image(folder.file("posx.png"), "key")->width, side);
  for (const char* face : {"negx", "posy", "negy", "posz", "negz"})
    fs::copy_file(folder.file("posx.png"), folder.file(std::string(face) + ".png"));
  expect_refused([](auto... a) { load_cube_map(a...); }, folder.file("posx.png"));
}

TEST(Image, PipesAndOtherFormatsAreRefused) {
  const Folder folder;
  ASSERT_EQ(mkfifo(folder.file("pipe.png").c_str(), 0600), 0);
  expect_refused([](auto... a) { load_image(a...); }, folder.file("pipe.png"));
  std::ofstream(folder.file("a.ppm"), std::ios::binary) << encoded(".ppm");
  const std::string message = image_refusal(folder.file("a.ppm"));
  EXPECT_NE(message.find("expected a PNG, JPEG, TIFF or BMP file"), std::string::npos) << message;
}

TEST(Image, OneOutsideTheFoldersIsRefusedHoweverItIsNamed) {
  const Folder folder;
  fs::create_directories(folder.path / "in" / "deeper");
  const Image image{1, 1, {50, 50, 50}};
  for (const char* name : {"in/a.png", "in/deeper/b.png", "out.png", "inside.png"})
    save_image(folder.file(name), image);
  fs::create_symlink(folder.file("out.png"), folder.file("in/link.png"));
  fs::create_symlink(folder.file("in/a.png"), folder.file("in/own.png"));
  fs::create_directory_symlink(folder.path, folder.path / "in" / "up");
  const ImageFolders folders({folder.file("in/")});
  const auto load = [&](const std::string& path, const std::string& key) {
    load_image(path, key, folders);
  };
  for (const char* name : {"in/a.png", "in/deeper/b.png", "in/own.png", "in/../in/a.png"})
    EXPECT_NO_THROW(load(folder.file(name), "key")) << name;
  for (const char* name : {"out.png", "inside.png", "in/link.png", "in/../out.png", "in/up/out.png",
                           "no/such/file.png"})
    expect_refused(load, folder.file(name));
  expect_refused(load, "/proc/self/cwd");
  expect_refused(load, "");

  // Each face of a cube map on its own.
  fs::create_directories(folder.path / "in" / "cube");
  for (const char* face : {"posx", "negx", "posy", "negy", "posz"})
    save_image(folder.file("in/cube/" + std::string(face) + ".png"), image);
  fs::create_symlink(folder.file("out.png"), folder.file("in/cube/negz.png"));
  const auto load_cube = [&](const std::string& path, const std::string& key) {
    load_cube_map(path, key, folders);
  };
  expect_refused(load_cube, folder.file("in/cube"));
  fs::remove(folder.path / "in" / "cube" / "negz.png");
  save_image(folder.file("in/cube/negz.png"), image);
  EXPECT_NO_THROW(load_cube(folder.file("in/cube"), "key"));
}

// A driver may accept less than others, or run out of memory: no picture, rather than a wrong one.
TEST(Image, OneThatTheDriverDoesNotTakeFailsEachPicture) {
  Snapshot snapshot = flat_cloth(3, 3);
  Camera camera = camera_with_fov(40, 30, 0.8);
  camera.pose = look_at({0.5, 0.5, 2}, {0.5, 0.5, 0});
  const Images before = draw(snapshot, camera);
  const auto image = std::make_shared<Image>();
  image->width = 1 << 20;  // more than any driver accepts
  image->height = 1;
  image->rgb.resize(3 * static_cast<std::size_t>(image->width));
  for (const Shading& shading : {Shading(Textured{image}), Shading(Translucent{image, {}, 0.5})}) {
    Snapshot too_large = snapshot;
    too_large.cloth_shading = shading;
    for (int picture = 0; picture < 2; ++picture)
      EXPECT_THROW(draw(too_large, camera), GlError) << shading_name(shading);
    const Images after = draw(snapshot, camera);
    EXPECT_EQ(after.color, before.color) << shading_name(shading);
    EXPECT_EQ(after.depth, before.depth) << shading_name(shading);
  }
}

TEST(Image, IsLetGoWhenNoPictureShowsItAnyMore) {
  const auto map = [] { return std::make_shared<HeightMap>(HeightMap{1, 1, {0.5f}}); };
  Snapshot snapshot = flat_cloth(3, 3);
  const Camera camera = camera_with_fov(8, 6, 0.8);
  for (const WantedImages& wanted : {WantedImages{}, WantedImages{false, true, false}}) {
    Displacement shading;
    shading.height_map = map();
    const std::weak_ptr<const HeightMap> first = shading.height_map;
    for (int picture = 0; picture < 2; ++picture) {
      snapshot.cloth_shading = shading;
      Images images;
      shared_renderer().render(snapshot, camera, wanted, images);
      EXPECT_EQ(first.expired(), picture == 1) << (wanted.color ? "all" : "depth alone");
      shading.height_map = map();
    }
  }
}

TEST(Image, APanoramaStandsAroundTheScene) {
  // Each direction has a colour of its own; the middle of the panorama looks along the world's +y.
  const Folder folder;
  cv::Mat panorama(64, 128, CV_8UC3);
  for (int row = 0; row < 64; ++row)
    for (int column = 0; column < 128; ++column) {
      const double around = ((column + 0.5) / 128 - 0.5) * 2 * M_PI;
      const double up = (0.5 - (row + 0.5) / 64) * M_PI;
      const Vector3 world(std::cos(up) * std::sin(around), std::cos(up) * std::cos(around),
                          std::sin(up));
      for (int c = 0; c < 3; ++c)
        panorama.at<cv::Vec3b>(row, column)[2 - c] =
            static_cast<std::uint8_t>(std::lround(127.5 * (1 + world[c])));
    }
  cv::imwrite(folder.file("panorama.png"), panorama);
  Snapshot snapshot;
  snapshot.background.sky = load_cube_map(folder.file("panorama.png"), "sky");
  for (const Vector3& target : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0),
                                Vector3(0, -1, 0), Vector3(0, 0, 1), Vector3(0, 0, -1)}) {
    Camera camera = camera_with_fov(20, 20, 1.5);
    camera.pose = look_at({0, 0, 0}, target);
    const Images images = draw(snapshot, camera);
    for (int v = 0; v < 20; v += 4)
      for (int u = 0; u < 20; u += 4) {
        const Vector3 d = pixel_ray(camera, u, v).normalized();
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(channel(images, u, v, c), 127.5 * (1 + d[c]), 6) << d.transpose();
      }
  }
}

TEST(Image, TheImagesOfThePackageCanBeRead) {
  const std::string folder = CLOTHSIM_TEXTURES_DIR;
  EXPECT_EQ(load_image(folder + "/fabric.png", "texture")->width, 256);
  EXPECT_EQ(load_height_map(folder + "/quilt_height.png", "height_map")->width, 256);
  EXPECT_EQ(load_cube_map(folder + "/sky", "environment")->faces[0].width, 256);
}

}  // namespace
}  // namespace clothsim::image_test
