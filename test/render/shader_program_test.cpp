#include "clothsim/render/shader_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "render_fixture.h"

namespace clothsim::shader_program_test {
namespace {

namespace fs = std::filesystem;

/// A copy of the shaders that is removed at the end.
struct ShaderCopy {
  fs::path folder = fs::path(testing::TempDir()) / "clothsim_shaders";
  ShaderCopy() {
    fs::remove_all(folder);
    fs::copy(CLOTHSIM_SHADERS_DIR, folder);
  }
  ~ShaderCopy() { fs::remove_all(folder); }

  void append(const std::string& file, const std::string& text) const {
    std::ofstream(folder / file, std::ios::app) << text;
  }
  int count_lines(const std::string& file) const {
    std::ifstream in(folder / file);
    return static_cast<int>(
        std::count(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>(), '\n'));
  }

  /// The message of the error that drawing a lit cloth ends with.
  std::string failure() const {
    Renderer renderer({folder.string()});
    Images images;
    try {
      renderer.render(flat_cloth(4, 4), camera_with_fov(8, 6, 1), {}, images);
    } catch (const ShaderError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST(ShaderProgram, AnErrorInASharedFileNamesFileAndLine) {
  const ShaderCopy copy;
  const int line = copy.count_lines("lighting.glsl") + 2;
  copy.append("lighting.glsl", "\nfloat broken = no_such_thing;\n");
  const std::string message = copy.failure();
  EXPECT_NE(message.find("blinn_phong.frag does not compile"), std::string::npos) << message;
  EXPECT_NE(message.find("lighting.glsl:" + std::to_string(line)), std::string::npos) << message;
}

TEST(ShaderProgram, AnErrorAfterAnIncludeNamesFileAndLine) {
  const ShaderCopy copy;
  const int line = copy.count_lines("blinn_phong.frag") + 2;
  copy.append("blinn_phong.frag", "\nfloat broken = no_such_thing;\n");
  const std::string message = copy.failure();
  EXPECT_NE(message.find("blinn_phong.frag:" + std::to_string(line)), std::string::npos) << message;
}

TEST(ShaderProgram, AMissingIncludeNamesWhoAsksForIt) {
  const ShaderCopy copy;
  const int line = copy.count_lines("blinn_phong.frag") + 1;
  copy.append("blinn_phong.frag", "#include \"absent.glsl\"\n");
  const std::string message = copy.failure();
  EXPECT_NE(message.find("absent.glsl cannot be read"), std::string::npos) << message;
  EXPECT_NE(message.find("blinn_phong.frag:" + std::to_string(line)), std::string::npos) << message;
}

TEST(ShaderProgram, AMissingFolderIsNamed) {
  Renderer renderer({"no/such/folder"});
  Images images;
  try {
    renderer.render(flat_cloth(4, 4), camera_with_fov(8, 6, 1), {}, images);
    FAIL() << "drew without shaders";
  } catch (const ShaderError& error) {
    EXPECT_NE(std::string(error.what()).find("no/such/folder/surface.vert"), std::string::npos);
  }
}

TEST(ShaderProgram, FilesAreIncludedOnce) {
  const ShaderSource source = read_shader(CLOTHSIM_SHADERS_DIR, "mirror.frag");
  const std::string mark = "layout(std140) uniform Frame";
  const std::size_t first = source.text.find(mark);
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(source.text.find(mark, first + 1), std::string::npos);
}

}  // namespace
}  // namespace clothsim::shader_program_test
