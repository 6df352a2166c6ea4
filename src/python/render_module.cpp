#include <pybind11/pybind11.h>
#include <unistd.h>

#include <map>
#include <mutex>
#include <utility>

#include "clothsim/render/render_thread.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/view/resources.h"
#include "clothsim/view/snapshot_maker.h"
#include "clothsim/view/view_yaml.h"
#include "pickling.h"
#include "simulation.h"
#include "yaml_objects.h"

// The module clothsim._render, loaded with the first picture.

namespace clothsim_python {
namespace {

/// A view as Python gave it.
struct ViewObject {
  clothsim::View view;
  YAML::Node yaml;
};

ViewObject make_view(const py::object& source, const py::dict& overrides) {
  const YAML::Node yaml = load_source(source, overrides);
  return {clothsim::read_view(yaml), yaml};
}

/// Draws for all simulators, one picture at a time. Renderers stay from one picture to the next.
class Studio {
 public:
  clothsim::Images take(Run& run, const clothsim::View& view) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (getpid() != process_) {
      throw std::runtime_error(
          "OpenGL does not survive fork(): start processes that draw by multiprocessing's spawn");
    }
    clothsim::check_colliders(view, run.simulator.scene());
    const clothsim::PreparedView ready = clothsim::prepare(view, images_);
    if (!run.pictures) run.pictures = std::make_shared<clothsim::SnapshotMaker>();
    auto& maker = *std::static_pointer_cast<clothsim::SnapshotMaker>(run.pictures);
    return draw(maker.make(run.simulator, ready), ready.camera, view);
  }

  /// Ends the threads that draw, while Mesa is still there.
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (getpid() == process_) threads_.clear();
  }

 private:
  clothsim::Images draw(clothsim::Snapshot snapshot, const clothsim::Camera& camera,
                        const clothsim::View& view) {
    std::unique_ptr<clothsim::RenderThread>& thread = threads_[{view.egl_device, view.samples}];
    if (!thread) {
      thread = std::make_unique<clothsim::RenderThread>(clothsim::RendererOptions{
          clothsim::shaders_folder(), view.egl_device, view.samples, false});
    }
    std::optional<clothsim::Images> drawn;
    const auto keep = [&](const clothsim::Images& images) { drawn = images; };
    thread->submit({std::move(snapshot), camera, {}, keep});
    thread->wait();
    if (!drawn) throw std::runtime_error("no picture: " + thread->status().failure);
    return std::move(*drawn);
  }

  const pid_t process_ = getpid();
  std::mutex mutex_;
  clothsim::ImageStore images_{clothsim::textures_folder()};
  std::map<std::pair<std::optional<int>, int>, std::unique_ptr<clothsim::RenderThread>> threads_;
};

/// Never destroyed: at the process's end a forked child has nothing to end threads with.
Studio& studio() {
  static Studio* one = new Studio();
  return *one;
}

ViewObject to_view(const py::object& object) {
  if (py::isinstance<ViewObject>(object)) return py::cast<ViewObject>(object);
  return make_view(object, py::dict());
}

py::tuple render(Simulation& simulation, const py::object& object) {
  const clothsim::View view = to_view(object).view;
  const clothsim::Images images =
      simulation.compute_with([&](Run& run) { return studio().take(run, view); });
  const py::ssize_t width = images.width;
  const py::ssize_t height = images.height;
  return py::make_tuple(to_array(images.color, {height, width, 3}),
                        to_array(images.depth, {height, width}),
                        to_array(images.mask, {height, width}));
}

}  // namespace

PYBIND11_MODULE(_render, module) {
  py::module_::import("clothsim._core");  // whose classes are used here
  py::class_<ViewObject> view(
      module, "View", "Camera, light and looks of pictures: docs/rendering.md lists the keys.");
  view.def(py::init(&make_view), py::arg("source") = py::none(), py::arg("overrides") = py::dict(),
           "From a YAML file (a path), a dict, or the defaults. `overrides` as in Scene(). Raises "
           "InvalidValue.")
      .def(
          "to_dict", [](const ViewObject& self) { return to_python(self.yaml); },
          "What was given, with the overrides, as a dict.")
      .def(py::pickle([](const ViewObject& self) { return to_pickle(to_text(self.yaml)); },
                      [](const py::tuple& kept) {
                        return from_pickle<std::string>(kept, [](const std::string& text) {
                          const YAML::Node yaml = clothsim::load_scene_text(text, "view");
                          return ViewObject{clothsim::read_view(yaml), yaml};
                        });
                      }));
  view.attr("__module__") = "clothsim";
  module.def("render", &render, py::arg("simulator"), py::arg("view"));
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    const py::gil_scoped_release release;
    studio().close();
  }));
  Calls::end_with_python();  // before that: what is registered last comes first
}

}  // namespace clothsim_python
