#pragma once

#include <pybind11/pybind11.h>
#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace clothsim_python {

namespace py = pybind11;

/// The same value as YAML, so that Python and files have one reader. A text counts as quoted;
/// arrays of numpy become lists. Throws InvalidValue for types without an equivalent in YAML.
YAML::Node to_yaml(py::handle);

/// The value as YAML text.
std::string to_text(const YAML::Node&);

/// The value as lists and maps of numbers, bools, texts and None.
py::object to_python(const YAML::Node&);

/// A scene or a view: from the file of that path, or from a dict; None: an empty map. `overrides`
/// is a dict from dotted paths to values, such as {"cloth.ks": 500}. Throws InvalidValue.
YAML::Node load_source(const py::object& source, const py::dict& overrides);

/// Sets the values in `root`. Throws InvalidValue without a change.
void override_from_dict(YAML::Node root, const py::dict& overrides);

/// Each as "key=value".
std::vector<std::string> assignments(const py::dict& overrides);

}  // namespace clothsim_python
