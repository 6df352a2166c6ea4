#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace clothsim_python {

namespace py = pybind11;

/// Adds the exceptions InvalidValue and Diverged to the module, and translates C++ exceptions to
/// them.
void bind_errors(py::module_& module);

/// The type of a Python object in a few words for a message, such as "a dict".
std::string describe(py::handle);

}  // namespace clothsim_python
