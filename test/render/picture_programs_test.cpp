// The programs picture and film.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "clothsim/render/image.h"
#include "says.h"
#include "temporary_folder.h"

namespace clothsim::picture_programs_test {
namespace {

namespace fs = std::filesystem;

/// Runs `picture` and returns its exit status.
int picture(const std::string& arguments) {
  const int status = std::system((std::string(CLOTHSIM_PICTURE) + " " + arguments).c_str());
  return WEXITSTATUS(status);
}

/// The first line of `picture` when it refuses its arguments.
std::string refusal(const std::string& arguments) {
  const fs::path errors = fs::path(::testing::TempDir()) / "clothsim_picture_errors";
  EXPECT_EQ(picture(arguments + " 2>" + errors.string()), 1);
  std::string message;
  std::getline(std::ifstream(errors), message);
  fs::remove(errors);
  return message;
}

TEST(Picture, TakesOneOfAScene) {
  const fs::path path = fs::path(::testing::TempDir()) / "clothsim_pictures" / "sphere.png";
  fs::remove_all(path.parent_path());
  const std::string scene = std::string(CLOTHSIM_SCENES_DIR) + "/sphere.yaml";
  EXPECT_EQ(picture(scene +
                    " --seconds 0 0.1 --set cloth.columns=10 --look width=40 "
                    "--look height=30 --output " +
                    path.string()),
            0);
  const auto image = load_image(path.string(), "picture");
  EXPECT_EQ(image->width, 84);
  EXPECT_EQ(image->height, 30);
  fs::remove_all(path.parent_path());
}

TEST(Picture, RefusesMistakes) {
  const std::string scene = std::string(CLOTHSIM_SCENES_DIR) + "/sphere.yaml";
  EXPECT_EQ(picture("no_such.yaml --output x.png 2>/dev/null"), 1);
  EXPECT_EQ(picture(scene + " 2>/dev/null"), 1);
  EXPECT_EQ(picture(scene + " --output x.png --look cloth.shader=shiny 2>/dev/null"), 1);
  EXPECT_EQ(picture(scene + " --output x.png --seconds 1 0.5 2>/dev/null"), 1);
  EXPECT_EQ(picture(scene + " --output x.png --label one 2>/dev/null"), 1);
  EXPECT_EQ(picture(scene + " --output /dev/null/x.png 2>/dev/null"), 1);
  EXPECT_FALSE(fs::exists("x.png"));

  using clothsim::says;
  EXPECT_TRUE(says(refusal(scene + " --output x.xyz"),
                   "picture: --output: got \"x.xyz\" ... .png, .jpg, .jpeg, .bmp, .tif, .tiff"));
  EXPECT_TRUE(
      says(refusal(scene + " --output x.png --vary-look width=320 --vary-look width=640"),
           "picture: --vary-look: got width=640 ... 640 x 480 ... width=320 ... 320 x 480"));
  EXPECT_FALSE(fs::exists("x.png"));
}

/// Runs `film` and returns its exit status.
int film(const std::string& arguments) {
  return WEXITSTATUS(std::system((std::string(CLOTHSIM_FILM) + " " + arguments).c_str()));
}

TEST(Film, WritesPicturesAndAVideo) {
  const test::TemporaryFolder folder("film");
  const std::string video = (folder.path() / "out.mp4").string();
  const std::string scene = (folder.path() / "scene.yaml").string();
  std::ofstream(scene) << "cloth: {columns: 6, rows: 6}\n"
                          "colliders: [{shape: sphere, center: [0.5, 0.2, 0.5], frame: ball}]\n"
                          "motions: [{time: 0.3, frame: ball, position: [0.5, 0.2, 0.9]}]\n";
  ASSERT_EQ(film(scene + " --every 0.1 --look width=41 --look height=30 --output " +
                 folder.path().string() + " --video " + video + " > /dev/null"),
            0);
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder.path() / "frames"))
    count += entry.path().extension() == ".png";
  EXPECT_EQ(count, 4 * 3);
  const auto first = load_image((folder.path() / "frames/000000_mask.png").string(), "mask");
  const auto last = load_image((folder.path() / "frames/000027_mask.png").string(), "mask");
  EXPECT_EQ(last->rgb, load_image((folder.path() / "final_mask.png").string(), "mask")->rgb);
  EXPECT_TRUE(fs::exists(folder.path() / "final.npz") && fs::exists(folder.path() / "report.yaml"));
  EXPECT_EQ(last->width, 41);
  EXPECT_NE(first->rgb, last->rgb) << "the sphere moves";
  const std::string told = (folder.path() / "told").string();
  ASSERT_EQ(std::system(("ffprobe -v error -count_frames -of csv=p=0 -show_entries "
                         "stream=width,height,r_frame_rate,nb_read_frames " +
                         video + " > " + told)
                            .c_str()),
            0);
  std::string line;
  std::getline(std::ifstream(told), line);
  EXPECT_EQ(line, "42,30,10/1,4");
}

TEST(Film, IsWholeWhenInterrupted) {
  const test::TemporaryFolder folder("film");
  const std::string output = folder.path().string();
  const std::string video = output + "/out.mp4";
  // The signal goes to the whole group, as that of a terminal does.
  std::ofstream(folder.path() / "run")
      << "set -m\n"
      << CLOTHSIM_FILM << " " << CLOTHSIM_SCENES_DIR
      << "/pinned2.yaml --seconds 10000 --every 1 --look width=40 --look height=30 --output "
      << output << " --video " << video << " > " << output << "/told 2>&1 &\nuntil [[ -e " << output
      << "/frames/000090_mask.png ]]; do sleep 0.05; done\n"
      << "kill -INT -- -$!\nwait $!\n";
  EXPECT_EQ(WEXITSTATUS(std::system(("bash " + output + "/run").c_str())), 130);
  EXPECT_TRUE(fs::exists(folder.path() / "final_color.png"));
  EXPECT_EQ(std::system(("ffprobe -v error " + video).c_str()), 0);
}

TEST(Film, RefusesMistakes) {
  const std::string scene = std::string(CLOTHSIM_SCENES_DIR) + "/sphere.yaml";
  const std::string small = scene + " --look width=20 --look height=20 ";
  EXPECT_EQ(film(small + "--seconds 0.1 2>/dev/null"), 1);                          // no output
  EXPECT_EQ(film(small + "--output x 2>/dev/null"), 1);                             // no time
  EXPECT_EQ(film(small + "--seconds 0.1 --every 0 --output x 2>/dev/null"), 1);     // no rate
  EXPECT_EQ(film(small + "--seconds 0.1 --video /dev/null/x.mp4 2>/dev/null"), 1);  // no place
  EXPECT_EQ(film(small + "--seconds 0.1 --video x.moon 2>/dev/null"), 1);           // no format
  EXPECT_EQ(film(small + "--seconds 0.1 --output /dev/null/x 2>/dev/null"), 1);
  EXPECT_FALSE(fs::exists("x") || fs::exists("x.moon"));
  EXPECT_EQ(WEXITSTATUS(std::system(("PATH=/nowhere " + std::string(CLOTHSIM_FILM) + " " + small +
                                     "--seconds 0.1 --video x.mp4 2>/dev/null")
                                        .c_str())),
            1);  // no ffmpeg
}

}  // namespace
}  // namespace clothsim::picture_programs_test
