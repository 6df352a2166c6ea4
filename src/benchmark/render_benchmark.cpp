// Frames a second of each shader at three sizes, and the time of each stage. One frame is a moving
// cloth of 50 x 50 points over a sphere and a plane, as colour, depth and mask.

#include <benchmark/benchmark.h>

#include <cmath>
#include <iostream>

#include "clothsim/model/grid.h"
#include "clothsim/render/renderer.h"

namespace {

using namespace clothsim;

Renderer& renderer() {
  static Renderer instance({CLOTHSIM_SHADERS_DIR, {}, 4, true});
  return instance;
}

/// The cloth at two times, so that every frame uploads one.
struct Scene {
  Snapshot snapshot;
  std::array<std::shared_ptr<const Points>, 2> moments;
  Camera camera;

  Scene(const Shading& shading, int width, int height) {
    const auto cloth = std::make_shared<const Cloth>(make_grid(ClothSpec{}));
    for (std::size_t k = 0; k < 2; ++k) {
      Points x = cloth->rest_positions;
      for (Eigen::Index i = 0; i < x.rows(); ++i)
        x(i, 2) = 0.6 + 0.1 * std::sin(8 * x(i, 0) + 0.1 * double(k)) * std::cos(6 * x(i, 1));
      moments[k] = std::make_shared<const Points>(x);
    }
    snapshot.cloth = cloth;
    snapshot.cloth_shading = shading;
    snapshot.colliders.resize(2);
    snapshot.colliders[0].pose.position = {0.5, 0.5, 0.2};
    snapshot.colliders[0].shading = shading;
    snapshot.colliders[1].shape = Plane{};
    snapshot.colliders[1].shading = Diffuse{};
    camera = camera_with_fov(width, height, 0.8);
    camera.pose = look_at({-0.5, -1.2, 1.4}, {0.5, 0.5, 0.4});
  }
};

/// The shading of that name with the package's images.
Shading complete(const std::string& name) {
  const std::string folder = CLOTHSIM_TEXTURES_DIR;
  static const auto image = load_image(folder + "/fabric.png", "texture");
  static const auto heights = load_height_map(folder + "/quilt_height.png", "height_map");
  static const auto sky = load_cube_map(folder + "/sky", "environment");
  Shading shading = make_shading(name);
  if (auto* s = std::get_if<Textured>(&shading)) s->image = image;
  if (auto* s = std::get_if<PhongTexture>(&shading)) s->image = image;
  if (auto* s = std::get_if<Translucent>(&shading)) s->image = image;
  if (auto* s = std::get_if<Bump>(&shading)) s->height_map = heights;
  if (auto* s = std::get_if<Displacement>(&shading)) s->height_map = heights;
  if (auto* s = std::get_if<Mirror>(&shading)) s->environment = sky;
  validate(shading);
  return shading;
}

void render(benchmark::State& state, const std::string& shader, int width, int height,
            const WantedImages& wanted) {
  Scene scene(complete(shader), width, height);
  Images images;
  RenderTimes sum;
  std::size_t frame = 0;
  for (auto _ : state) {
    scene.snapshot.positions = scene.moments[++frame % 2];
    renderer().render(scene.snapshot, scene.camera, wanted, images);
    sum.upload += renderer().times().upload;
    sum.draw += renderer().times().draw;
    sum.read += renderer().times().read;
  }
  const double n = static_cast<double>(state.iterations());
  state.counters["frames/s"] = benchmark::Counter(n, benchmark::Counter::kIsRate);
  state.counters["upload_ms"] = 1e3 * sum.upload / n;
  state.counters["draw_ms"] = 1e3 * sum.draw / n;
  state.counters["read_ms"] = 1e3 * sum.read / n;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  std::cerr << "Drawn by " << renderer().device() << "\n";
  const auto add = [](const std::string& shader, const std::string& what,
                      const WantedImages& wanted) {
    for (const auto& [width, height] : {std::pair(320, 240), {640, 480}, {1280, 720}})
      benchmark::RegisterBenchmark(
          (shader + "/" + what + "/" + std::to_string(width) + "x" + std::to_string(height))
              .c_str(),
          render, shader, width, height, wanted)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()  // of all threads, as a software driver draws in its own
          ->UseRealTime();
  };
  for (const std::string& shader : shading_names()) add(shader, "all", {});
  add("blinn_phong", "color", {true, false, false});
  add("blinn_phong", "depth", {false, true, false});
  add("blinn_phong", "uv,normals,flow", {false, false, false, true, true, true});
  add("blinn_phong", "visible_points", {false, false, false, false, false, false, true});
  benchmark::RunSpecifiedBenchmarks();
}
