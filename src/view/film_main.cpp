#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include "clothsim/model/checks.h"
#include "clothsim/simulation/motion_player.h"
#include "clothsim/simulation/progress_bar.h"
#include "clothsim/simulation/scene_yaml.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/view/picture_maker.h"
#include "clothsim/view/video.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

enum ExitCode { done = 0, bad_input = 1, diverged = 2 };

struct Options {
  std::string scene;
  std::string view_file;
  std::optional<double> seconds;
  double every = 1.0 / 30;  // [s] a picture
  std::vector<std::string> scene_values, view_values;
  fs::path images, video;
};

/// Writes the pictures of a run where they are asked for.
class Film {
 public:
  Film(const Options& options, const View& view, double rate)
      : folder_(options.images), view_(view), maker_(view) {
    if (!folder_.empty()) fs::create_directories(folder_);
    if (!options.video.empty())
      video_.emplace(options.video, view.camera.width, view.camera.height, rate);
  }

  void take(const Simulator& simulator, long long frame) {
    const bool all = !folder_.empty();
    const Images& images = maker_.draw(simulator, view_, {true, all, all});
    if (all) {
      save_image(path("color", frame), {images.width, images.height, images.color});
      save_depth(path("depth", frame), images.width, images.height, images.depth);
      save_mask(path("mask", frame), images.width, images.height, images.mask);
    }
    if (video_) video_->append(images.color);
  }

  void finish() {
    if (video_) video_->finish();
  }

 private:
  std::string path(const char* kind, long long frame) const {
    std::array<char, 40> name;
    std::snprintf(name.data(), name.size(), "%06lld_%s.png", frame, kind);
    return (folder_ / name.data()).string();
  }

  fs::path folder_;
  View view_;
  PictureMaker maker_;
  std::optional<Video> video_;
};

/// Frames of simulation nearest to a time, at least one.
long long to_frames(const char* option, double seconds, double frame_duration) {
  constexpr Range range{1e-6, 1e6, "s"};
  check_range(option, seconds, range);
  return std::max(1LL, std::llround(seconds / frame_duration));
}

ExitCode film(const Options& options) {
  if (options.images.empty() && options.video.empty())
    throw InvalidValue({"--images"}, "nothing, and no --video", "one of the two");
  YAML::Node scene = load_scene_file(options.scene);
  override_values(scene, options.scene_values);
  YAML::Node look(YAML::NodeType::Map);
  if (!options.view_file.empty()) look = load_scene_file(options.view_file);
  override_values(look, options.view_values);
  const fs::path folder = fs::path(options.scene).parent_path();
  Simulator simulator(read_scene(scene, {folder}));
  const View view = read_view(look);
  check_colliders(view, simulator.scene());
  MotionPlayer player(simulator, folder);
  if (!options.seconds && simulator.scene().motions.empty())
    throw InvalidValue({"--seconds"}, "nothing", "a time [s], as the scene has no motions");

  const double duration = simulator.frame_duration();
  const long long frames =
      to_frames("--seconds", options.seconds.value_or(player.duration()), duration);
  const long long every = to_frames("--every", options.every, duration);
  Film pictures(options, view, 1 / (static_cast<double>(every) * duration));
  ProgressBar bar(frames);
  for (long long frame = 0;; ++frame) {
    if (frame % every == 0) pictures.take(simulator, frame);
    if (frame == frames) break;
    bar.update(frame);
    player.play(simulator);
    simulator.step();
  }
  pictures.finish();
  return done;
}

void add_options(CLI::App& app, Options& options) {
  const auto one_each = [&](const char* name, std::vector<std::string>& target, const char* text) {
    app.add_option(name, target, text)->allow_extra_args(false)->type_name("KEY=VALUE");
  };
  app.add_option("scene", options.scene, "Scene file (YAML)")->required();
  app.add_option("--images", options.images,
                 "Folder for NNNNNN_color.png, NNNNNN_depth.png (16 bits, millimetres, 0: nothing "
                 "there or beyond 65 m) and NNNNNN_mask.png");
  app.add_option("--video", options.video, "Video file, such as out.mp4; needs ffmpeg");
  app.add_option("--every", options.every,
                 "Time from picture to picture [s], rounded to whole frames of simulation");
  app.add_option("--seconds", options.seconds,
                 "Time to film [s]; without it that of the motions of the scene");
  app.add_option("--view", options.view_file, "View file (YAML): camera, light, shaders");
  one_each("--set", options.scene_values, "Change a value of the scene: --set cloth.ks=500");
  one_each("--look", options.view_values, "Change a value of the view: --look cloth.shader=mirror");
  app.footer("Exit status: 0 done, 1 bad input, no OpenGL or no ffmpeg, 2 diverged.");
}

}  // namespace
}  // namespace clothsim

int main(int argc, char** argv) {
  clothsim::Options options;
  CLI::App app("Films a cloth scene without ROS or display: colour, depth and mask, or a video.");
  clothsim::add_options(app, options);
  try {
    app.parse(argc, argv);
    return clothsim::film(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? clothsim::done : clothsim::bad_input;
  } catch (const clothsim::Diverged& error) {
    std::cerr << "film: diverged: " << error.what() << '\n';
    return clothsim::diverged;
  } catch (const std::exception& error) {
    std::cerr << "film: " << error.what() << '\n';
    return clothsim::bad_input;
  }
}
