#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "clothsim/model/checks.h"
#include "clothsim/run/motion_player.h"
#include "clothsim/run/progress_bar.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/view/contact_sheet.h"
#include "clothsim/view/picture_maker.h"
#include "clothsim/view/view_yaml.h"

namespace clothsim {
namespace {

enum ExitCode { done = 0, bad_input = 1, diverged = 2 };

struct Options {
  std::string scene;
  std::string view_file;
  std::vector<double> seconds{0};
  std::vector<std::string> scene_values, view_values;    // for all pictures
  std::vector<std::string> scene_choices, view_choices;  // one picture each
  std::vector<std::string> labels;                       // replace the choices themselves
  int columns = 4;
  std::string output;
};

/// The assignments in which pictures differ; a single empty one if there are none.
std::vector<std::string> or_none(std::vector<std::string> choices) {
  if (choices.empty()) choices.emplace_back();
  return choices;
}

YAML::Node with(const YAML::Node& root, const std::string& assignment) {
  YAML::Node copy = YAML::Clone(root);
  if (!assignment.empty()) override_values(copy, {assignment});
  return copy;
}

/// The label that distinguishes this picture from the others.
std::string label(const Options& options, std::size_t scene_choice, double time,
                  std::size_t view_choice) {
  std::string text;
  const auto add = [&](const std::vector<std::string>& choices, std::size_t i) {
    if (choices.empty()) return;
    text += (text.empty() ? "" : ", ") + (options.labels.empty() ? choices : options.labels)[i];
  };
  add(options.scene_choices, scene_choice);
  add(options.view_choices, view_choice);
  if (options.seconds.size() > 1) text += (text.empty() ? "t = " : ", t = ") + to_text(time) + " s";
  return text;
}

Image draw(PictureMaker& maker, const Simulator& simulator, const View& view) {
  const Images& images = maker.draw(simulator, view, {true, false, false});
  return {images.width, images.height, images.color};
}

/// Pictures of different sizes cannot form a sheet.
void check_sizes(const std::vector<View>& views, const std::vector<std::string>& choices) {
  const auto size = [](const View& view) {
    return std::to_string(view.camera.width) + " x " + std::to_string(view.camera.height);
  };
  for (std::size_t i = 1; i < views.size(); ++i) {
    if (size(views[i]) == size(views[0])) continue;
    throw InvalidValue({"--vary-look"}, choices[i] + ", a picture of " + size(views[i]),
                       "pictures of one size, as that of " + choices[0] + ", " + size(views[0]));
  }
}

ExitCode take_pictures(const Options& options) {
  // Read everything first, so that errors are found before the work.
  YAML::Node scene = load_scene_file(options.scene);
  override_values(scene, options.scene_values);
  YAML::Node view(YAML::NodeType::Map);
  if (!options.view_file.empty()) view = load_scene_file(options.view_file);
  override_values(view, options.view_values);
  const auto scene_folder = std::filesystem::path(options.scene).parent_path();
  std::vector<Scene> scenes;
  for (const std::string& choice : or_none(options.scene_choices))
    scenes.push_back(read_scene(with(scene, choice), {scene_folder}));
  std::vector<View> views;
  for (const std::string& choice : or_none(options.view_choices))
    views.push_back(read_view(with(view, choice)));
  check_sizes(views, options.view_choices);
  for (const View& each : views) check_names(each, scenes[0]);

  PictureMaker maker(views[0]);
  std::vector<Tile> tiles;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    Simulator simulator(scenes[s]);
    MotionPlayer player(simulator, scene_folder);
    const double last = *std::max_element(options.seconds.begin(), options.seconds.end());
    ProgressBar bar(std::llround(last / simulator.frame_duration()));
    long long frame = 0;
    for (const double time : options.seconds) {
      while (frame < std::llround(time / simulator.frame_duration())) {
        bar.update(frame++);
        player.play(simulator);
        simulator.step();
      }
      for (std::size_t v = 0; v < views.size(); ++v)
        tiles.push_back({draw(maker, simulator, views[v]), label(options, s, time, v)});
    }
  }
  const std::filesystem::path folder = std::filesystem::path(options.output).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder);
  save_image(options.output, contact_sheet(tiles, options.columns));
  return done;
}

void check_options(const Options& options) {
  constexpr Range time{0, 1e6, "s"};
  for (const double seconds : options.seconds) check_range("--seconds", seconds, time);
  if (!std::is_sorted(options.seconds.begin(), options.seconds.end()))
    throw InvalidValue({"--seconds"}, "times out of order", "times that grow");
  const std::size_t choices = options.scene_choices.size() + options.view_choices.size();
  const bool both = !options.scene_choices.empty() && !options.view_choices.empty();
  if (!options.labels.empty() && (both || options.labels.size() != choices)) {
    throw InvalidValue({"--label"}, std::to_string(options.labels.size()) + " labels",
                       "one for each --vary or --vary-look, and not both of these");
  }
  constexpr Range columns{1, 100, ""};
  check_range("--columns", options.columns, columns);
  check_image_ending(options.output, "--output");
}

void add_options(CLI::App& app, Options& options) {
  const auto one_each = [&](const char* name, std::vector<std::string>& target, const char* text) {
    app.add_option(name, target, text)->allow_extra_args(false)->type_name("KEY=VALUE");
  };
  app.add_option("scene", options.scene, "Scene file (YAML)")->required();
  app.add_option("--output", options.output, "Image file: .png, .jpg, .bmp or .tiff")->required();
  app.add_option("--seconds", options.seconds, "When to take the picture [s]; several: one each");
  app.add_option("--view", options.view_file, "View file (YAML): camera, light, shaders");
  one_each("--set", options.scene_values, "Change a value of the scene: --set cloth.ks=500");
  one_each("--look", options.view_values, "Change a value of the view: --look cloth.shader=mirror");
  one_each("--vary", options.scene_choices, "As --set; a picture for each");
  one_each("--vary-look", options.view_choices, "As --look; a picture for each");
  app.add_option("--label", options.labels, "Words for each --vary or --vary-look, in their order")
      ->allow_extra_args(false);
  app.add_option("--columns", options.columns, "Pictures to a row");
  app.footer("Exit status: 0 done, 1 bad input or no OpenGL, 2 diverged.");
}

}  // namespace
}  // namespace clothsim

int main(int argc, char** argv) {
  clothsim::Options options;
  CLI::App app("Runs a cloth scene without ROS or display and takes a picture of it.");
  clothsim::add_options(app, options);
  try {
    app.parse(argc, argv);
    clothsim::check_options(options);
    return clothsim::take_pictures(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? clothsim::done : clothsim::bad_input;
  } catch (const clothsim::Diverged& error) {
    std::cerr << "picture: diverged: " << error.what() << '\n';
    return clothsim::diverged;
  } catch (const std::exception& error) {
    std::cerr << "picture: " << error.what() << '\n';
    return clothsim::bad_input;
  }
}
