#include <pybind11/pybind11.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/render/render_thread.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/view/resources.h"
#include "clothsim/view/snapshot_maker.h"
#include "clothsim/view/view_yaml.h"
#include "errors.h"
#include "pickling.h"
#include "simulation.h"
#include "yaml_objects.h"

// The module clothsim._render, loaded with the first picture.

namespace clothsim_python {
namespace {

/// A view from Python.
struct ViewObject {
  clothsim::View view;
  YAML::Node yaml;
};

ViewObject make_view(const py::object& source, const py::dict& overrides) {
  const YAML::Node yaml = load_source(source, overrides);
  return {clothsim::read_view(yaml), yaml};
}

/// Data of the studio about a run.
struct Pictures {
  clothsim::SnapshotMaker maker;
  std::optional<clothsim::RenderJob> before;  // the last one with flow
};

/// Draws for all simulators, one picture at a time. Renderers are kept between pictures.
class Studio {
 public:
  clothsim::Images take(Run& run, const clothsim::View& view,
                        const clothsim::WantedImages& wanted) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (getpid() != process_) {
      throw std::runtime_error(
          "OpenGL does not survive fork(): start processes that draw by multiprocessing's spawn");
    }
    clothsim::check_names(view, run.simulator.scene());
    const clothsim::PreparedView ready = clothsim::prepare(view, images_);
    if (!run.pictures) run.pictures = std::make_shared<Pictures>();
    const auto pictures = std::static_pointer_cast<Pictures>(run.pictures);
    Easel& easel = easel_of(view);
    clothsim::RenderJob job{pictures->maker.make(run.simulator, ready), ready.camera, wanted, {}};
    if (wanted.flow) {
      set_before(easel, pictures, job);
      pictures->before = job;
    } else {
      easel.before.reset();
    }
    return draw(easel, job);
  }

  /// Ends the drawing threads, before Mesa is unloaded.
  void close() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (getpid() == process_) easels_.clear();
  }

 private:
  struct Easel {
    std::unique_ptr<clothsim::RenderThread> thread;
    std::weak_ptr<Pictures> before;  // the run of the last picture, where it had flow
  };

  Easel& easel_of(const clothsim::View& view) {
    Easel& easel = easels_[{view.egl_device, view.samples}];
    if (!easel.thread) {
      easel.thread = std::make_unique<clothsim::RenderThread>(clothsim::RendererOptions{
          clothsim::shaders_folder(), view.egl_device, view.samples, false});
    }
    return easel;
  }

  /// A renderer's flow is relative to its last picture: makes that the run's own last picture.
  static void set_before(Easel& easel, const std::shared_ptr<Pictures>& pictures,
                         const clothsim::RenderJob& job) {
    if (easel.before.lock() == pictures) return;
    clothsim::RenderJob before = pictures->before.value_or(job);
    if (!pictures->before) before.wanted = {false, false, true};  // without flow: no last picture
    draw(easel, before);
    easel.before = pictures;
  }

  static clothsim::Images draw(Easel& easel, clothsim::RenderJob job) {
    std::optional<clothsim::Images> drawn;
    job.done = [&](const clothsim::Images& images) { drawn = images; };
    easel.thread->submit(std::move(job));
    easel.thread->wait();
    if (!drawn) throw std::runtime_error("no picture: " + easel.thread->status().failure);
    return std::move(*drawn);
  }

  const pid_t process_ = getpid();
  std::mutex mutex_;
  clothsim::ImageStore images_{clothsim::textures_folder()};
  std::map<std::pair<std::optional<int>, int>, Easel> easels_;
};

/// Never destroyed: at the end of the process, a forked child has no threads to end.
Studio& studio() {
  static Studio* one = new Studio();
  return *one;
}

ViewObject to_view(const py::object& object) {
  if (py::isinstance<ViewObject>(object)) return py::cast<ViewObject>(object);
  return make_view(object, py::dict());
}

/// Each image by the name of its topic, and whether it is wanted.
constexpr std::array<std::pair<const char*, bool clothsim::WantedImages::*>, 7> image_names = {{
    {"color", &clothsim::WantedImages::color},
    {"depth", &clothsim::WantedImages::depth},
    {"mask", &clothsim::WantedImages::mask},
    {"uv", &clothsim::WantedImages::uv},
    {"normals", &clothsim::WantedImages::normals},
    {"flow", &clothsim::WantedImages::flow},
    {"visible_points", &clothsim::WantedImages::visible_points},
}};

/// From "all" or a list of names. Throws InvalidValue.
clothsim::WantedImages to_wanted(const py::object& names) {
  const bool is_text = py::isinstance<py::str>(names);
  const bool wants_all = is_text && py::cast<std::string>(names) == "all";
  if (!wants_all && (is_text || !py::isinstance<py::sequence>(names))) {
    throw clothsim::InvalidValue({"images"}, describe(names), "\"all\" or a list of names");
  }
  clothsim::WantedImages wanted{wants_all, wants_all, wants_all, wants_all,
                                wants_all, wants_all, wants_all};
  if (wants_all) return wanted;
  for (const py::handle item : py::reinterpret_borrow<py::sequence>(names)) {
    const std::string name = py::cast<std::string>(py::str(item));
    std::vector<std::string> known;
    for (const auto& [each, is_wanted] : image_names) {
      known.push_back(each);
      if (name == each) wanted.*is_wanted = true;
    }
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw clothsim::InvalidValue({"images"}, '"' + clothsim::shortened(name, 100) + '"',
                                 "some of " + clothsim::join(known));
  }
  return wanted;
}

py::dict to_dict(const clothsim::Images& images, const clothsim::WantedImages& wanted) {
  const py::ssize_t width = images.width;
  const py::ssize_t height = images.height;
  py::dict all;
  const auto add = [&](const char* name, bool is_wanted, const auto& numbers,
                       const std::vector<py::ssize_t>& shape) {
    if (is_wanted) all[name] = to_array(numbers, shape);
  };
  add("color", wanted.color, images.color, {height, width, 3});
  add("depth", wanted.depth, images.depth, {height, width});
  add("mask", wanted.mask, images.mask, {height, width});
  add("uv", wanted.uv, images.uv, {height, width, 2});
  add("normals", wanted.normals, images.normals, {height, width, 3});
  add("flow", wanted.flow, images.flow, {height, width, 2});
  if (images.visible_points) {
    add("visible_points", wanted.visible_points, *images.visible_points,
        {static_cast<py::ssize_t>(images.visible_points->size())});
  }
  return all;
}

py::object render(Simulation& simulation, const py::object& object, const py::object& names) {
  const clothsim::View view = to_view(object).view;
  const bool is_usual = names.is_none();
  const clothsim::WantedImages wanted = is_usual ? clothsim::WantedImages() : to_wanted(names);
  const clothsim::Images images =
      simulation.compute_with([&](Run& run) { return studio().take(run, view, wanted); });
  py::dict all = to_dict(images, wanted);
  if (!is_usual) return std::move(all);
  return py::make_tuple(all["color"], all["depth"], all["mask"]);
}

}  // namespace

PYBIND11_MODULE(_render, module) {
  py::module_::import("clothsim._core");  // defines classes used here
  py::class_<ViewObject> view(
      module, "View", "Camera, light and looks of pictures: docs/rendering.md lists the keys.");
  view.def(py::init(&make_view), py::arg("source") = py::none(), py::arg("overrides") = py::dict(),
           "From a YAML file (a path), a dict, or the defaults. `overrides` as in Scene(). Raises "
           "InvalidValue.")
      .def(
          "to_dict", [](const ViewObject& self) { return to_python(self.yaml); },
          "The view as it was given, with the overrides, as a dict.")
      .def(py::pickle([](const ViewObject& self) { return to_pickle(to_text(self.yaml)); },
                      [](const py::tuple& kept) {
                        return from_pickle<std::string>(kept, [](const std::string& text) {
                          const YAML::Node yaml = clothsim::load_scene_text(text, "view");
                          return ViewObject{clothsim::read_view(yaml), yaml};
                        });
                      }));
  view.attr("__module__") = "clothsim";
  module.def("render", &render, py::arg("simulator"), py::arg("view"), py::arg("images"));
  py::module_::import("atexit").attr("register")(py::cpp_function([] {
    const py::gil_scoped_release release;
    studio().close();
  }));
  Calls::end_with_python();  // registered last, so that it is called first
}

}  // namespace clothsim_python
