#pragma once

#include <pybind11/numpy.h>
#include <pybind11/stl.h>  // included everywhere or nowhere, as casts must not differ between files

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/scene/motion.h"
#include "clothsim/shapes/collider.h"

namespace clothsim_python {

namespace py = pybind11;

/// N x 3 numbers without a copy, read-only. `owner` lives as long as the array or a part of it.
py::array view(const clothsim::Points& points, std::shared_ptr<void> owner);

/// A list of numbers as a new array of shape `shape`.
template <class Number>
py::array to_array(const std::vector<Number>& numbers, std::vector<py::ssize_t> shape) {
  return py::array_t<Number>(std::move(shape), numbers.data());
}

py::array to_array(const clothsim::Vector3&);
py::array to_array(const clothsim::Pose&);  // [x, y, z, qx, qy, qz, qw]

/// Throw InvalidValue with `key` for anything but an array of such numbers.
clothsim::Points to_points(py::handle, const std::string& key, Eigen::Index rows);
std::vector<double> to_numbers(py::handle, const std::string& key);
clothsim::Vector3 to_vector(py::handle, const std::string& key);
std::vector<int> to_indices(py::handle, const std::string& key);

/// From [x, y, z, qx, qy, qz, qw], or [x, y, z] of a frame without rotation. Throws InvalidValue.
clothsim::Pose to_pose(py::handle, const std::string& key);

using Targets = std::map<std::string, clothsim::FrameTarget>;

/// From a dict {frame: pose or (start, end)}, or None. Throws InvalidValue with `key`.
Targets to_targets(py::handle, const std::string& key);

}  // namespace clothsim_python
