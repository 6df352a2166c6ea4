#include <filesystem>

#include "bindings.h"
#include "clothsim/scene/scene_yaml.h"
#include "pickling.h"
#include "yaml_objects.h"

namespace clothsim_python {
namespace {

SceneObject make_scene(const YAML::Node& yaml, const std::string& file, const py::dict& overrides) {
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  return {clothsim::read_scene(yaml, {folder}), yaml, file, folder, assignments(overrides)};
}

SceneObject from_source(const py::object& source, const py::dict& overrides) {
  const bool is_file = py::isinstance<py::str>(source) || py::hasattr(source, "__fspath__");
  return make_scene(load_source(source, overrides),
                    is_file ? py::cast<std::string>(py::str(source)) : "", overrides);
}

SceneObject parse(const std::string& text, const py::dict& overrides) {
  YAML::Node yaml = clothsim::load_scene_text(text, "scene");
  override_from_dict(yaml, overrides);
  return make_scene(yaml, "", overrides);
}

/// With absolute paths of files, as the other process may run in any folder.
py::tuple pickled(const SceneObject& scene) {
  const std::filesystem::path folder = std::filesystem::absolute(scene.folder / ".");
  return to_pickle(to_text(scene.yaml), scene.file, folder.string(), scene.overrides);
}

SceneObject unpickled(const std::string& text, const std::string& file, const std::string& folder,
                      const std::vector<std::string>& overrides) {
  const YAML::Node yaml = clothsim::load_scene_text(text, "scene");
  return {clothsim::read_scene(yaml, {folder}), yaml, file, folder, overrides};
}

}  // namespace

void bind_scene(py::module_& module) {
  py::class_<SceneObject>(
      module, "Scene",
      "All that defines a simulation: docs/scenes.md lists the keys. Equal scenes give equal bits. "
      "It pickles, with the folder that its files are in.")
      .def(py::init(&from_source), py::arg("source"), py::arg("overrides") = py::dict(),
           "From a YAML file (a path) or a dict. `overrides` maps dotted paths to values, such as "
           "{'cloth.ks': 500, 'colliders.0.radius': 0.3}. Raises InvalidValue.")
      .def_static("parse", &parse, py::arg("text"), py::arg("overrides") = py::dict(),
                  "From YAML text. Raises InvalidValue.")
      .def(
          "to_dict", [](const SceneObject& self) { return to_python(self.yaml); },
          "The scene as it was given, with the overrides, as a dict; keys left out are not in it.")
      .def_property_readonly(
          "columns", [](const SceneObject& self) { return self.scene.cloth.columns; },
          "Points of the cloth along x; of a mesh or several cloths all.")
      .def_property_readonly(
          "rows", [](const SceneObject& self) { return self.scene.cloth.rows; },
          "Points of the cloth along y, or z where it stands; of a mesh or several cloths 1.")
      .def_property_readonly(
          "frames_per_second",
          [](const SceneObject& self) { return self.scene.simulation.frames_per_second; },
          "Frames a simulated second [Hz].")
      .def(py::pickle(
          &pickled,
          [](const py::tuple& kept) {
            return from_pickle<std::string, std::string, std::string, std::vector<std::string>>(
                kept, unpickled);
          }))
      .def("__repr__", [](const SceneObject& self) {
        const auto& cloth = self.scene.cloth;
        return "<clothsim.Scene of " + std::to_string(cloth.columns) + " x " +
               std::to_string(cloth.rows) + " points, " +
               std::to_string(self.scene.colliders.size()) + " colliders>";
      });
}

}  // namespace clothsim_python
