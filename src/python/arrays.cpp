#include "arrays.h"

#include <utility>

#include "clothsim/model/checks.h"
#include "errors.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;

constexpr py::ssize_t number_size = sizeof(double);

std::string shape_text(const py::array& array) {
  std::vector<std::string> sides;
  for (py::ssize_t i = 0; i < array.ndim(); ++i) sides.push_back(std::to_string(array.shape(i)));
  return "an array of shape [" + clothsim::join(sides) + "]";
}

/// Converts as numpy does; throws InvalidValue for objects other than arrays of numbers.
py::array_t<double> to_array_of_numbers(py::handle object, const std::string& key,
                                        const std::string& expected) {
  const bool is_text = py::isinstance<py::str>(object) || py::isinstance<py::bytes>(object);
  if (!is_text && !object.is_none()) {
    auto array = py::array_t<double, py::array::forcecast>::ensure(object);
    if (array) return array;
  }
  throw InvalidValue({key}, describe(object), expected);
}

clothsim::Pose pose_of(const double* numbers, py::ssize_t count) {
  clothsim::Pose pose;
  pose.position = {numbers[0], numbers[1], numbers[2]};
  if (count == 7) {
    pose.orientation = Eigen::Quaterniond(numbers[6], numbers[3], numbers[4], numbers[5]);
  }
  return pose;
}

constexpr const char* pose_form = "[x, y, z] or [x, y, z, qx, qy, qz, qw]";

bool is_pose_size(py::ssize_t count) { return count == 3 || count == 7; }

/// The numbers of an array, row by row.
std::vector<double> in_rows(const py::array_t<double>& array) {
  const auto dense = py::array_t<double, py::array::c_style | py::array::forcecast>(array);
  return {dense.data(), dense.data() + dense.size()};
}

/// A pose, or two.
clothsim::FrameTarget to_target(py::handle object, const std::string& frame) {
  const bool is_text = py::isinstance<py::str>(object);
  if (is_text || !py::isinstance<py::sequence>(object) || py::len(object) != 2) {
    return {to_pose(object, frame), {}, {}};
  }
  const auto pair = py::reinterpret_borrow<py::sequence>(object);
  return {to_pose(pair[1], frame), {}, to_pose(pair[0], frame)};
}

}  // namespace

py::array view(const clothsim::Points& points, std::shared_ptr<void> owner) {
  using Owner = std::shared_ptr<void>;
  const py::capsule base(new Owner(std::move(owner)),
                         [](void* p) { delete static_cast<Owner*>(p); });
  py::array_t<double> array({points.rows(), points.cols()},
                            {number_size, number_size * points.rows()}, points.data(), base);
  array.attr("flags").attr("writeable") = false;
  return std::move(array);
}

py::array to_array(const clothsim::Vector3& vector) {
  return py::array_t<double>(3, vector.data());
}

py::array to_array(const clothsim::Pose& pose) {
  std::vector<double> numbers(pose.position.data(), pose.position.data() + 3);
  const auto& turn = pose.orientation.coeffs();  // x, y, z, w
  numbers.insert(numbers.end(), turn.data(), turn.data() + 4);
  return to_array(numbers, {7});
}

clothsim::Points to_points(py::handle object, const std::string& key, Eigen::Index rows) {
  const std::string expected = "an array of shape [" + std::to_string(rows) + ", 3]";
  const py::array_t<double> array = to_array_of_numbers(object, key, expected);
  if (array.ndim() != 2 || array.shape(0) != rows || array.shape(1) != 3) {
    throw InvalidValue({key}, shape_text(array), expected);
  }
  const auto numbers = array.unchecked<2>();
  clothsim::Points points(rows, 3);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    for (Eigen::Index i = 0; i < rows; ++i) points(i, axis) = numbers(i, axis);
  }
  return points;
}

std::vector<double> to_numbers(py::handle object, const std::string& key) {
  const py::array_t<double> array = to_array_of_numbers(object, key, "a list of numbers");
  if (array.ndim() != 1) throw InvalidValue({key}, shape_text(array), "a list of numbers");
  return in_rows(array);
}

clothsim::Vector3 to_vector(py::handle object, const std::string& key) {
  constexpr const char* expected = "[x, y, z]";
  const py::array_t<double> array = to_array_of_numbers(object, key, expected);
  if (array.ndim() != 1 || array.size() != 3) {
    throw InvalidValue({key}, shape_text(array), expected);
  }
  return Eigen::Map<const clothsim::Vector3>(in_rows(array).data());
}

std::vector<int> to_indices(py::handle object, const std::string& key) {
  constexpr const char* expected = "a list of whole numbers";
  constexpr double limit = 1e9;  // far more points than a cloth has
  std::vector<int> indices;
  const py::array_t<double> array = to_array_of_numbers(object, key, expected);
  if (array.ndim() != 1) throw InvalidValue({key}, shape_text(array), expected);
  for (const double number : in_rows(array)) {
    if (!(std::abs(number) < limit) || number != std::trunc(number)) {
      throw InvalidValue({key, std::to_string(indices.size())}, clothsim::to_text(number),
                         "a whole number");
    }
    indices.push_back(static_cast<int>(number));
  }
  return indices;
}

clothsim::Pose to_pose(py::handle object, const std::string& key) {
  const py::array_t<double> array = to_array_of_numbers(object, key, pose_form);
  if (array.ndim() != 1 || !is_pose_size(array.size())) {
    throw InvalidValue({key}, shape_text(array), pose_form);
  }
  return pose_of(in_rows(array).data(), array.size());
}

Targets to_targets(py::handle object, const std::string& key) {
  Targets targets;
  if (object.is_none()) return targets;
  if (!py::isinstance<py::dict>(object)) {
    throw InvalidValue({key}, describe(object), "a dict from frames to poses");
  }
  clothsim::inside(key, [&] {
    for (const auto& [frame, target] : py::reinterpret_borrow<py::dict>(object)) {
      if (!py::isinstance<py::str>(frame)) {
        throw InvalidValue({}, describe(frame) + " as a key", "the name of a frame");
      }
      const auto name = py::cast<std::string>(frame);
      targets.emplace(name, to_target(target, name));
    }
  });
  return targets;
}

}  // namespace clothsim_python
