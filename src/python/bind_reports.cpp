#include "bindings.h"
#include "pickling.h"
#include "saved_state.h"

namespace clothsim_python {

void bind_reports(py::module_& module) {
  using clothsim::StepReport;
  py::class_<StepReport>(module, "StepReport", "What the last frame of a step did.")
      .def_readonly("method", &StepReport::method, "Name of the method of integration.")
      .def_property_readonly(
          "reason", [](const StepReport& self) { return self.reasons.text(); },
          "Why that method and its substeps, in words.")
      .def_readonly("substeps", &StepReport::substeps, "Substeps of the frame.")
      .def_readonly("predicted_error", &StepReport::predicted_error,
                    "Error of positions that method auto foretold, of the cloth's size, or None.")
      .def_readonly("recoveries", &StepReport::recoveries,
                    "Times the frame was taken back and tried again.")
      .def_readonly("sweeps", &StepReport::sweeps,
                    "Passes over strain limit and contacts, summed over the substeps.")
      .def_readonly("corrections", &StepReport::corrections,
                    "Passes that shortened springs still over the limit, summed likewise.")
      .def_readonly("worst_stretch", &StepReport::worst_stretch,
                    "Largest l / L0 - 1 of a spring at the frame's end.")
      .def_readonly("violation", &StepReport::violation,
                    "Largest part of it beyond the strain limit of the spring's cloth.")
      .def_readonly("contacts", &StepReport::contacts,
                    "Points on colliders plus contacts of the cloth with itself.")
      .def_readonly("ran_out", &StepReport::ran_out,
                    "Substeps whose method stopped iterating before its tolerance.")
      .def_readonly("held_back", &StepReport::held_back,
                    "Moves of points cut short lest the cloth cross itself.")
      .def_readonly("pinched", &StepReport::pinched, "Points that two colliders leave no room.")
      .def_readonly("slipping", &StepReport::slipping,
                    "Those of them that are pulled with more than friction holds.")
      .def_readonly("lagging", &StepReport::lagging,
                    "Points behind the places of the pins and grips that hold them.")
      .def_readonly("crossings", &StepReport::crossings,
                    "Pairs of triangles that cross since a state was set, see set_state().")
      .def(py::pickle(
          [](const StepReport& self) { return to_pickle(py::bytes(bytes_of(self))); },
          [](const py::tuple& kept) { return from_pickle<std::string>(kept, report_from); }))
      .def("__repr__", [](const StepReport& self) {
        return "<clothsim.StepReport: " + self.method + ", " + std::to_string(self.substeps) +
               " substeps, " + std::to_string(self.contacts) + " contacts>";
      });
}

}  // namespace clothsim_python
