#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "simulation.h"

namespace clothsim_python {

namespace py = pybind11;

using SimulationClass = py::class_<Simulation, std::shared_ptr<Simulation>>;

void bind_scene(py::module_&);
void bind_reports(py::module_&);
void bind_batch(py::module_&);
void bind_bodies(py::module_&);
void bind_cloths(py::module_&);
void bind_robots(py::module_&);

// Methods of clothsim.Simulator.
void bind_stepping(SimulationClass&);
void bind_state(SimulationClass&);
void bind_frames(SimulationClass&);
void bind_reading(SimulationClass&);
void bind_forces(SimulationClass&);

/// clothsim.SavedState.
void bind_saved_state(py::module_&);

}  // namespace clothsim_python
