#include <optional>

#include "../run/run_options.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/view/picture_maker.h"
#include "clothsim/view/video.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim {
namespace {

namespace fs = std::filesystem;

constexpr double video_period = 1.0 / 30;  // [s] without --every

struct FilmOptions {
  RunOptions run;
  std::string view_file;
  std::vector<std::string> view_values;
  fs::path video;
};

/// Draws the kept frames, the last one, and the frames of a video.
class Film : public Recorder {
 public:
  Film(const FilmOptions& options, const View& view, double frame_duration)
      : output_(options.run.output), view_(view), maker_(view) {
    if (options.run.every) kept_every_ = to_frames("--every", *options.run.every, frame_duration);
    if (options.video.empty()) return;
    video_every_ = to_frames("--every", options.run.every.value_or(video_period), frame_duration);
    video_.emplace(options.video, view.camera.width, view.camera.height,
                   1 / (static_cast<double>(video_every_) * frame_duration));
  }

  void take(const Simulator& simulator, long long frame) override {
    const bool kept = !output_.empty() && kept_every_ > 0 && frame % kept_every_ == 0;
    const bool shown = video_ && frame % video_every_ == 0;
    if (!kept && !shown) return;
    const Images& images = maker_.draw(simulator, view_, {true, kept, kept});
    if (kept) save(images, frame_path(output_, frame, "_"));
    if (shown) video_->append(images.color);
  }

  void finish(const Simulator& simulator) override {
    if (!output_.empty()) save(maker_.draw(simulator, view_, {}), output_ / "final_");
    if (video_) video_->finish();
  }

 private:
  static void save(const Images& images, const fs::path& start) {
    const std::string path = start.string();
    save_image(path + "color.png", {images.width, images.height, images.color});
    save_depth(path + "depth.png", images.width, images.height, images.depth);
    save_mask(path + "mask.png", images.width, images.height, images.mask);
  }

  fs::path output_;
  View view_;
  PictureMaker maker_;
  long long kept_every_ = 0, video_every_ = 0;  // frames; 0: none
  std::optional<Video> video_;
};

ExitCode film(const FilmOptions& options) {
  if (options.run.output.empty() && options.video.empty())
    throw InvalidValue({"--output"}, "nothing, and no --video", "one of the two");
  YAML::Node look(YAML::NodeType::Map);
  if (!options.view_file.empty()) look = load_scene_file(options.view_file);
  override_values(look, options.view_values);
  const View view = read_view(look);
  return run("film", options.run, [&](const Simulator& simulator) {
    check_names(view, simulator.scene());
    return std::make_unique<Film>(options, view, simulator.frame_duration());
  });
}

}  // namespace
}  // namespace clothsim

int main(int argc, char** argv) {
  clothsim::FilmOptions options;
  CLI::App app(
      "Runs a cloth scene as simulate does, and draws colour, depth and mask, or a video.");
  clothsim::add_run_options(
      app, options.run,
      "all that simulate writes, final_color.png, final_depth.png (16 bits, millimetres, 0: "
      "nothing there or beyond 65 m) and final_mask.png",
      "Also write frames.npz, and in frames/ NNNNNN.ply, NNNNNN_color.png, NNNNNN_depth.png and "
      "NNNNNN_mask.png");
  app.add_option("--video", options.video,
                 "Video file, such as out.mp4, of these frames, else of 30 a second; needs ffmpeg");
  app.add_option("--view", options.view_file, "View file (YAML): camera, light, shaders");
  clothsim::add_assignments(app, "--look", options.view_values,
                            "Change a value of the view: --look cloth.shader=mirror");
  app.footer(
      "Exit status: 0 done, 1 bad input, no OpenGL or no ffmpeg, 2 diverged, 130 interrupted "
      "(files hold the last good frame).");
  return clothsim::run_program(app, "film", argc, argv, [&] { return clothsim::film(options); });
}
