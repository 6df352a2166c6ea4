#include "bindings.h"
#include "clothsim/scene/doubts.h"
#include "clothsim/scene/scene_yaml.h"
#include "pickling.h"
#include "saved_state.h"
#include "yaml_objects.h"

namespace clothsim_python {
namespace {

SceneObject to_scene(const py::object& object) {
  const py::object scene = py::isinstance<SceneObject>(object)
                               ? object
                               : py::module_::import("clothsim").attr("Scene")(object);
  return py::cast<SceneObject>(scene);
}

/// Warns of probable mistakes in a scene; Python shows each text once per place.
const SceneObject& with_warnings(const SceneObject& scene) {
  for (const std::string& line : clothsim::doubts(scene.yaml, scene.scene)) {
    if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1) != 0) throw py::error_already_set();
  }
  return scene;
}

std::shared_ptr<Simulation> start(const py::object& scene) {
  return std::make_shared<Simulation>(with_warnings(to_scene(scene)));
}

void load(Simulation& simulation, const py::object& scene) {
  simulation.load(with_warnings(to_scene(scene)));
}

void set(Simulation& simulation, const py::kwargs& values) {
  const YAML::Node yaml = to_yaml(values);
  simulation.with([&](Run& run) {
    clothsim::LiveSpec live = clothsim::live_values(run.simulator.scene());
    clothsim::read_live_values(yaml, live);
    run.simulator.set(live);
  });
}

void reset(Simulation& simulation) {
  simulation.with([](Run& run) { run.reset(); });
}

void reset_values(Simulation& simulation) {
  simulation.with([](Run& run) { run.simulator.reset_values(); });
}

py::object report(Simulation& simulation) {
  const std::string text = simulation.compute_with(
      [](Run& run) { return clothsim::to_yaml(run.report, run.simulator); });
  py::object values = to_python(YAML::Load(text));
  const std::shared_ptr<Run> run = simulation.run();
  values["scene"] = run->report.scene;  // texts as they are, even if YAML would read other types
  values["overrides"] = run->report.overrides;
  return values;
}

}  // namespace

void bind_stepping(SimulationClass& simulator) {
  simulator
      .def(py::init(&start), py::arg("scene"),
           "A simulator at the start of `scene`: a Scene, or its source.")
      .def(py::pickle(
          [](Simulation& self) {
            return self.with(
                [](Run& run) { return to_pickle(*run.scene, py::bytes(bytes_of(run))); });
          },
          [](const py::tuple& kept) {
            return from_pickle<SceneObject, std::string>(
                kept, [](const SceneObject& scene, const std::string& bytes) {
                  return std::make_shared<Simulation>(run_from(scene, bytes));
                });
          }))
      .def("step", &Simulation::step, py::arg("frames") = 1, py::arg("targets") = py::none(),
           "Advances by `frames` frames and returns the StepReport of the last. `targets` maps "
           "frames to where they are to be at its end: a pose [x, y, z, qx, qy, qz, qw] [m, unit "
           "quaternion], or [x, y, z] of a frame that is not turned; or two poses, (start, end): "
           "then the frame is put at the start first. They move evenly, and with them colliders, "
           "pins and points that follow them. The scene's motions are played. Raises InvalidValue "
           "before the first frame, or in a later one where a motion names a missing frame; "
           "Diverged, at the last good frame.")
      .def("load", &load, py::arg("scene"),
           "Starts anew with another scene. Arrays that were taken before keep the old state. "
           "Raises InvalidValue and goes on as before.")
      .def(
          "reset", &reset,
          "Back to the scene's start at time 0, with the present live values: reset_values() takes "
          "these back. Attached points are let go, motions begin anew.")
      .def("reset_values", &reset_values,
           "Puts live values back to those of the scene, after changes by set() and motions; "
           "nothing moves.")
      .def(
          "set", &set,
          "Changes live values between two frames, by keyword: ks, density, damping, strain_limit, "
          "springs (a dict), thickness, self_collision, friction, collider_friction (a dict by "
          "name), gravity, frames_per_second, substeps, strain_tolerance, tolerance, method, "
          "method_parameters, threads, as in a scene; cloths (a dict by name of several cloths, of "
          "dicts of values of that cloth alone). Raises InvalidValue and changes nothing.")
      .def_property_readonly(
          "report", &report,
          "A report of the run so far, a dict with the keys of report.yaml. "
          "cpu_seconds is of the calling threads. Takes about as long as a frame.");
}

}  // namespace clothsim_python
