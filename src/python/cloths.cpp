#include "cloths.h"

#include <algorithm>

#include "bindings.h"
#include "clothsim/model/checks.h"

namespace clothsim_python {
namespace {

py::object range(int first, int count) {
  return py::module_::import("builtins").attr("range")(first, first + count);
}

}  // namespace

clothsim::ClothPart Cloth::part() const {
  return simulation_->with([&](Run& run) {
    const std::vector<clothsim::ClothPart>& parts = run.simulator.scene().cloth.parts;
    const auto found = std::find_if(parts.begin(), parts.end(),
                                    [&](const clothsim::ClothPart& p) { return p.name == name_; });
    if (found != parts.end()) return *found;
    throw clothsim::InvalidValue({"cloths"}, '"' + name_ + '"',
                                 "a cloth of the scene that was loaded");
  });
}

py::object Cloth::rows_of(clothsim::Points clothsim::State::*all) const {
  const clothsim::ClothPart own = part();
  const std::shared_ptr<Run>& run = simulation_->run();
  return view(run->simulator.state().*all,
              run)[py::slice(own.first_point, own.first_point + own.num_points(), 1)];
}

py::dict cloths_of(const std::shared_ptr<Simulation>& simulation) {
  return simulation->with([&](Run& run) {
    py::dict cloths;
    for (const clothsim::ClothPart& part : run.simulator.scene().cloth.parts) {
      cloths[py::str(part.name)] = Cloth(simulation, part.name);
    }
    return cloths;
  });
}

void bind_cloths(py::module_& module) {
  py::class_<Cloth>(module, "Cloth", "One of a scene's several cloths: see Simulator.cloths.")
      .def_property_readonly("name", &Cloth::name, "As the scene has it.")
      .def_property_readonly(
          "points",
          [](const Cloth& self) {
            const clothsim::ClothPart part = self.part();
            return range(part.first_point, part.num_points());
          },
          "The numbers of its points among those of all cloths, a range.")
      .def_property_readonly(
          "triangles",
          [](const Cloth& self) {
            const clothsim::ClothPart part = self.part();
            return range(part.first_triangle, part.triangles);
          },
          "The numbers of its triangles among those of all cloths, a range.")
      .def_property_readonly(
          "positions", [](const Cloth& self) { return self.rows_of(&clothsim::State::positions); },
          "Its rows of Simulator.positions [m], a read-only view.")
      .def_property_readonly(
          "velocities",
          [](const Cloth& self) { return self.rows_of(&clothsim::State::velocities); },
          "Its rows of Simulator.velocities [m/s], a read-only view.");
}

}  // namespace clothsim_python
