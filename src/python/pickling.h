#pragma once

#include <pybind11/stl.h>

#include <cstddef>
#include <string>
#include <utility>

#include "clothsim/model/errors.h"

namespace clothsim_python {

namespace py = pybind11;

/// An object for pickle: the version of this package, and `parts`.
template <class... Parts>
py::tuple to_pickle(Parts&&... parts) {
  return py::make_tuple(CLOTHSIM_VERSION, std::forward<Parts>(parts)...);
}

template <class... Parts, class Make, std::size_t... i>
auto call_with_parts(const py::tuple& kept, const Make& make, std::index_sequence<i...>) {
  return make(py::cast<Parts>(kept[i + 1])...);
}

/// Calls make(parts...) with the parts from to_pickle(). Throws InvalidValue for other data, or
/// another version.
template <class... Parts, class Make>
auto from_pickle(const py::tuple& kept, const Make& make) {
  const std::string version =
      kept.size() == 1 + sizeof...(Parts) ? py::cast<std::string>(py::str(kept[0])) : "none";
  if (version != CLOTHSIM_VERSION) {
    throw clothsim::InvalidValue({"pickle"}, "version " + version, CLOTHSIM_VERSION);
  }
  return call_with_parts<Parts...>(kept, make, std::index_sequence_for<Parts...>());
}

}  // namespace clothsim_python
