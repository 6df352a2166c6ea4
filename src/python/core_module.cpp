#include "batch.h"
#include "bindings.h"
#include "errors.h"

// The module clothsim._core: all but the renderer, which needs OpenGL.

namespace clothsim_python {
namespace {

void bind_simulator(py::module_& module) {
  SimulationClass simulator(
      module, "Simulator",
      "A scene that moves, frame by frame. SI units, z up. Point (column, row) of the cloth has "
      "the index row * columns + column. Any thread may call; calls of one simulator take turns, "
      "and those that compute let other threads run. It pickles, and goes on to the same bits.");
  bind_stepping(simulator);
  bind_state(simulator);
  bind_frames(simulator);
  bind_reading(simulator);
  bind_forces(simulator);
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  module.attr("__version__") = CLOTHSIM_VERSION;
  Calls::end_with_python();
  bind_errors(module);
  bind_scene(module);
  bind_reports(module);
  bind_saved_state(module);
  bind_robots(module);
  bind_bodies(module);
  bind_cloths(module);
  bind_simulator(module);
  bind_batch(module);
  for (const auto& item : module.attr("__dict__").cast<py::dict>()) {
    if (PyType_Check(item.second.ptr())) item.second.attr("__module__") = "clothsim";
  }
}

}  // namespace clothsim_python
