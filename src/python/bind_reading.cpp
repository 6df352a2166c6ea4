#include <pybind11/eigen.h>

#include <array>

#include "bindings.h"
#include "cloths.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/touches.h"

namespace clothsim_python {
namespace {

py::array triangles_of(const clothsim::Cloth& cloth) {
  std::vector<int> corners;
  for (const std::array<int, 3>& triangle : cloth.triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  return to_array(corners, {static_cast<py::ssize_t>(cloth.triangles.size()), 3});
}

/// Adds the springs of the families that are on, one by one.
void add_springs(const clothsim::Cloth& cloth, py::dict& topology) {
  std::vector<int> ends;
  std::vector<int> families;
  std::vector<double> lengths;
  std::vector<double> stiffness;
  for (const clothsim::SpringRun& run : cloth.springs) {
    for (int i = run.first; i < run.first + run.count; ++i) {
      ends.insert(ends.end(), {i, i + run.offset});
      families.push_back(static_cast<int>(run.family));
      lengths.push_back(run.rest_length);
      stiffness.push_back(run.stiffness);
    }
  }
  const auto count = static_cast<py::ssize_t>(families.size());
  topology["springs"] = to_array(ends, {count, 2});
  topology["families"] = to_array(families, {count});
  topology["rest_lengths"] = to_array(lengths, {count});
  topology["stiffness"] = to_array(stiffness, {count});
}

py::dict topology(Simulation& simulation) {
  return simulation.with([](Run& run) {
    const clothsim::Cloth& cloth = run.simulator.cloth();
    py::dict all;
    all["columns"] = cloth.columns;
    all["rows"] = cloth.rows;
    all["triangles"] = triangles_of(cloth);
    all["uv"] = py::cast(cloth.uv);
    all["rest_positions"] = py::cast(cloth.rest_positions);
    all["mass"] = py::cast(cloth.mass);
    all["pinned"] = cloth.pinned;
    add_springs(cloth, all);
    return all;
  });
}

py::array intersections(Simulation& simulation) {
  const auto pairs = simulation.compute_with([](Run& run) {
    return clothsim::find_intersections(run.simulator.cloth(), run.simulator.state().positions);
  });
  std::vector<int> numbers;
  for (const clothsim::TrianglePair& pair : pairs) {
    numbers.insert(numbers.end(), {pair.a, pair.b});
  }
  return to_array(numbers, {static_cast<py::ssize_t>(pairs.size()), 2});
}

py::dict contacts(Simulation& simulation) {
  return simulation.with([](Run& run) {
    const clothsim::Simulator& simulator = run.simulator;
    const auto array_if = [](bool known, const clothsim::Vector3& vector) {
      return known ? py::object(to_array(vector)) : py::none();
    };
    py::dict all;
    const std::vector<clothsim::Touch> touches = clothsim::find_touches(simulator);
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const clothsim::Wrench& wrench = simulator.collider_wrenches()[i];
      const bool is_measured = simulator.measures_wrenches();
      all[py::str(simulator.scene().colliders[i].name)] =
          py::dict(py::arg("count") = touches[i].count,
                   py::arg("middle") = array_if(touches[i].count > 0, touches[i].middle),
                   py::arg("force") = array_if(is_measured, wrench.force),
                   py::arg("torque") = array_if(is_measured, wrench.torque));
    }
    return all;
  });
}

py::object render(const py::object& self, const py::object& view, const py::object& images) {
  return py::module_::import("clothsim._render").attr("render")(self, view, images);
}

void bind_render(SimulationClass& simulator) {
  simulator.def(
      "render", &render, py::arg("view") = py::none(), py::arg("images") = py::none(),
      "A picture of the present state, without a display. `view`: a View, or its source. Returns "
      "colour [H, W, 3] uint8 sRGB; depth [H, W] float32 [m] along the optical axis, inf where "
      "nothing is; mask [H, W] uint8: 0 nothing, 1 the cloth, or the first of several, 2 the first "
      "collider and so on, then the second of several cloths and so on. With "
      "`images`, a list of names or 'all', a dict of these: 'color', 'depth', 'mask'; 'uv' [H, W, "
      "2] of the cloth, NaN elsewhere; 'normals' [H, W, 3] in the optical frame; 'flow' [H, W, 2], "
      "pixels to the right and down that a surface has moved since the last picture with flow of "
      "this simulator, NaN where there is none; 'visible_points', the numbers of points in sight. "
      "Raises InvalidValue; RuntimeError where there is no OpenGL.");
}

}  // namespace

void bind_reading(SimulationClass& simulator) {
  simulator
      .def_property_readonly(
          "frame_duration",
          [](Simulation& self) {
            return self.with([](Run& run) { return run.simulator.frame_duration(); });
          },
          "Simulated time of a frame [s].")
      .def_property_readonly(
          "topology", &topology,
          "The structure of the cloth, a dict: 'columns', 'rows'; 'triangles' [T, 3], "
          "counter-clockwise seen from the front; 'uv' [N, 2] in [0, 1]; 'rest_positions' [N, 3] "
          "[m]; 'mass' [N] [kg]; 'pinned', indices; 'springs' [S, 2], points that each joins, with "
          "'families' [S] (0 structural, 1 shear, 2 bending), 'rest_lengths' [S] [m], 'stiffness' "
          "[S] [N/m], 0 of a fabric's diagonals, as its cells resist shear. Copies.")
      .def_property_readonly("cloths", &cloths_of,
                             "The Cloths of a scene with several, by name; empty where it has one.")
      .def_property_readonly(
          "contacts", &contacts,
          "Where the cloth lies on each collider, by name: {'count': points, and triangles that "
          "touch with none of their corners; 'middle': mean of these places [3] [m], or None; "
          "'force' [3] [N] of the cloth on the collider and 'torque' [3] [N m] about the origin of "
          "its frame, in the world, the mean of the last frame: the force of a cloth at rest is "
          "its weight. None unless weighs_colliders is set, zero before the first frame then}.")
      .def_property(
          "weighs_colliders",
          [](Simulation& self) {
            return self.with([](Run& run) { return run.simulator.measures_wrenches(); });
          },
          [](Simulation& self, bool asks) {
            self.with([&](Run& run) { run.simulator.measure_wrenches(asks); });
          },
          "Whether frames sum up the forces of the cloth on colliders, for `contacts`. Off at "
          "first. It costs up to 7 % where all points lie on one; no motion depends on it.")
      .def("intersections", &intersections,
           "Pairs of triangles of the cloth that cross, [K, 2] indices into 'triangles', which "
           "should be none.");
  bind_render(simulator);
}

}  // namespace clothsim_python
