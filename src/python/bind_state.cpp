#include "bindings.h"
#include "errors.h"
#include "pickling.h"
#include "saved_state.h"

namespace clothsim_python {
namespace {

/// Raises a UserWarning, which may be an error.
void warn_of_crossings(const clothsim::Simulator& simulator) {
  const int pairs = simulator.given_crossings();
  if (pairs == 0) return;
  const std::string text = "the state crosses itself in " + std::to_string(pairs) +
                           " pairs of triangles, which stay crossed: untangle() takes them apart";
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

/// Sets the given parts of the state, and keeps the others.
void set_state(Simulation& simulation, const py::object& positions, const py::object& velocities,
               std::optional<double> time, const py::object& memory) {
  simulation.with([&](Run& run) {
    clothsim::State state = run.simulator.state();
    const Eigen::Index rows = state.positions.rows();
    if (!positions.is_none()) state.positions = to_points(positions, "positions", rows);
    if (!velocities.is_none()) state.velocities = to_points(velocities, "velocities", rows);
    if (time) state.time = *time;
    run.simulator.set_state(
        state, memory.is_none() ? std::vector<double>() : to_numbers(memory, "memory"));
    warn_of_crossings(run.simulator);
  });
}

/// The numbers of pairs of triangles that cross before and after.
py::tuple untangle(Simulation& simulation) {
  const clothsim::Untangled result =
      simulation.compute_with([](Run& run) { return run.simulator.untangle(); });
  return py::make_tuple(result.before, result.left);
}

void go_back(Simulation& simulation, const SavedState& state) {
  simulation.with([&](Run& run) { restore(run, state); });
}

py::array positions(const Simulation& simulation) {
  const std::shared_ptr<Run>& run = simulation.run();
  return view(run->simulator.state().positions, run);
}

py::array velocities(const Simulation& simulation) {
  const std::shared_ptr<Run>& run = simulation.run();
  return view(run->simulator.state().velocities, run);
}

py::array memory(Simulation& simulation) {
  const std::vector<double> numbers =
      simulation.with([](Run& run) { return run.simulator.memory(); });
  return to_array(numbers, {static_cast<py::ssize_t>(numbers.size())});
}

}  // namespace

void bind_saved_state(py::module_& module) {
  py::class_<SavedState>(module, "SavedState",
                         "A copy of all that moves, made by Simulator.save(). It pickles.")
      .def_property_readonly(
          "nbytes",
          [](const SavedState& self) { return clothsim::Simulator::bytes_of(*self.saved); },
          "Memory that it takes [bytes], without a few hundred.")
      .def(py::pickle(
          [](const SavedState& self) { return to_pickle(*self.scene, py::bytes(bytes_of(self))); },
          [](const py::tuple& kept) {
            return from_pickle<SceneObject, std::string>(kept, state_from);
          }));
}

void bind_state(SimulationClass& simulator) {
  simulator
      .def_property(
          "positions", &positions,
          [](Simulation& self, const py::object& given) {
            set_state(self, given, py::none(), {}, py::none());
          },
          "[N, 3] [m]: a read-only view without a copy, which shows each later frame. Copy it to "
          "keep it. It outlives the simulator. To set it is set_state(positions=...).")
      .def_property(
          "velocities", &velocities,
          [](Simulation& self, const py::object& given) {
            set_state(self, py::none(), given, {}, py::none());
          },
          "[N, 3] [m/s], a view like `positions`.")
      .def_property_readonly(
          "time",
          [](Simulation& self) {
            return self.with([](Run& run) { return run.simulator.state().time; });
          },
          "Simulated time since the scene's start [s].")
      .def_property_readonly(
          "memory", &memory,
          "All else that the next frames depend on, beside positions, velocities and time: "
          "an array of numbers to hand back to set_state().")
      .def("set_state", &set_state, py::arg("positions") = py::none(),
           py::arg("velocities") = py::none(), py::arg("time") = py::none(),
           py::arg("memory") = py::none(),
           "Goes on from another state; what is left out stays. `positions` [N, 3] [m], "
           "`velocities` [N, 3] [m/s], `time` [s]. With the `memory` that came with the state, to "
           "the same bits as then; without, as after a reset. Colliders and pins stay where they "
           "are. Warns of triangles that cross, with self_collision surface. Raises InvalidValue "
           "and changes nothing: for shapes, numbers that are not finite "
           "or far too large, a held point elsewhere, the memory of another cloth or method.")
      .def(
          "untangle", &untangle,
          "Takes the cloth apart where it crosses itself by a small depth, by its positions alone. "
          "Returns how many pairs of triangles crossed before, and how many are left. A scene with "
          "cloth.untangle does so whenever a state is set.")
      .def(
          "save", [](Simulation& self) { return self.with([](Run& run) { return save(run); }); },
          "A copy of all that moves, colliders, frames, motions and attached points too. Live "
          "values are not in it.")
      .def(
          "restore", &go_back, py::arg("state"),
          "Puts back a state of save(), of this simulator or one of an equal scene; goes on to the "
          "same bits. Raises InvalidValue for another scene.");
}

}  // namespace clothsim_python
