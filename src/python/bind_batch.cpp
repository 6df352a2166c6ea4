#include "batch.h"
#include "bindings.h"
#include "pickling.h"

namespace clothsim_python {

void bind_batch(py::module_& module) {
  py::class_<Batch>(
      module, "Batch",
      "Many simulators of as many points each, stepped side by side by threads of its own. The "
      "result of each does not depend on the others or on the number of threads.")
      .def(
          py::init<const py::sequence&, std::optional<int>>(), py::arg("simulators"),
          py::arg("threads") = py::none(),
          "`threads` is 1 to 64; None: as many as there are cores. Raises InvalidValue, also for a "
          "simulator given twice.")
      .def("step", &Batch::step, py::arg("actions") = py::none(), py::arg("frames") = 1,
           "Advances each by `frames` frames and returns `positions`. `actions` is a list with the "
           "targets of each simulator, as Simulator.step() takes them, or a dict {frame: array [E, "
           "7], [E, 3], [E, 2, 7] or [E, 2, 3]}. Raises InvalidValue and steps none. Raises "
           "Diverged after all have stepped: its `environments` stay at their last good frame.")
      .def("read", &Batch::read,
           "Reads the states anew, after a simulator was changed by itself, as by restore().")
      .def_property_readonly("positions", &Batch::positions,
                             "[E, N, 3] [m], C-contiguous and read-only: one array for ever, which "
                             "each step() overwrites.")
      .def_property_readonly("velocities", &Batch::velocities, "[E, N, 3] [m/s], likewise.")
      .def_property_readonly("simulators", &Batch::simulators, "As a tuple.")
      .def_property_readonly("threads", &Batch::threads, "That compute, the caller's among them.")
      .def(
          py::pickle([](const Batch& self) { return to_pickle(self.simulators(), self.threads()); },
                     [](const py::tuple& kept) {
                       return from_pickle<py::sequence, int>(
                           kept, [](const py::sequence& simulators, int threads) {
                             return std::make_unique<Batch>(simulators, threads);
                           });
                     }))
      .def("__len__", [](const Batch& self) { return self.simulators().size(); });
}

}  // namespace clothsim_python
