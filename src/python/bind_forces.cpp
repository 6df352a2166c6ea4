#include "bindings.h"
#include "clothsim/dynamics/membrane_stress.h"

namespace clothsim_python {
namespace {

py::object forces(Simulation& simulation) {
  return simulation.with([](Run& run) -> py::object {
    const clothsim::Points& forces = run.simulator.forces();
    if (forces.rows() == 0) return py::none();
    return view(forces, std::make_shared<clothsim::Points>(forces)).attr("copy")();
  });
}

void set_forces(Simulation& simulation, const py::object& given) {
  simulation.with([&](Run& run) {
    const Eigen::Index rows = run.simulator.cloth().num_points();
    run.simulator.set_forces(given.is_none() ? clothsim::Points(0, 3)
                                             : to_points(given, "forces", rows));
  });
}

py::array tensions(Simulation& simulation) {
  const std::vector<double> tensions =
      simulation.with([](Run& run) { return run.simulator.tensions(); });
  return to_array(tensions, {static_cast<py::ssize_t>(tensions.size())});
}

py::array stress(Simulation& simulation) {
  const auto stress = std::make_shared<clothsim::Points>(simulation.with([](Run& run) {
    return clothsim::membrane_stress(run.simulator.cloth(), run.simulator.state(),
                                     run.simulator.tensions());
  }));
  return view(*stress, stress);
}

}  // namespace

void bind_forces(SimulationClass& simulator) {
  simulator
      .def_property(
          "forces", &forces, &set_forces,
          "[N, 3] [N], or None: forces from outside on the points, such as a push or a fan, "
          "besides gravity, from the next frame on until they are set anew. reset() ends them. The "
          "holder of a point feels them. Read, it is a copy.")
      .def_property_readonly(
          "tensions", &tensions,
          "[S] [N], of each of topology['springs'], negative where it pushes: by Hooke's law with "
          "internal damping, plus the tension of the strain limit. Diagonals of a fabric have the "
          "latter alone, as its cells resist shear.")
      .def_property_readonly(
          "stress", &stress,
          "[T, 3] [N/m], of each of topology['triangles'] in its own plane, a force per width at "
          "rest: along rows, along columns, in shear. From the tensions, and of a fabric from the "
          "strains of its cells. Of a mesh along warp, along weft and in shear, from its strains.");
}

}  // namespace clothsim_python
