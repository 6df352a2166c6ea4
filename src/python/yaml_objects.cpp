#include "yaml_objects.h"

#include <charconv>
#include <optional>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"
#include "errors.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;

/// Deepest nesting of lists and maps: far more than a scene has, and an end for lists that contain
/// themselves.
constexpr int deepest = 50;

YAML::Node to_yaml(py::handle object, int depth);

/// A value from numpy or the file system as plain Python: an array as lists, a number of numpy as
/// Python's, a path as text. Other values are returned unchanged.
py::object plain(py::handle object) {
  if (py::hasattr(object, "tolist")) return object.attr("tolist")();
  if (py::hasattr(object, "__fspath__")) return object.attr("__fspath__")();
  return py::reinterpret_borrow<py::object>(object);
}

YAML::Node map_node(py::handle object, int depth) {
  YAML::Node map(YAML::NodeType::Map);
  for (const py::handle key : object) {
    if (!py::isinstance<py::str>(key)) {
      throw InvalidValue({}, describe(key) + " as a key", "a name");
    }
    const auto name = py::cast<std::string>(key);
    clothsim::inside(name, [&] { map.force_insert(name, to_yaml(object[key], depth + 1)); });
  }
  return map;
}

YAML::Node list_node(py::handle object, int depth) {
  YAML::Node list(YAML::NodeType::Sequence);
  int index = 0;
  for (const py::handle item : object) {
    clothsim::inside(std::to_string(index++), [&] { list.push_back(to_yaml(item, depth + 1)); });
  }
  return list;
}

YAML::Node to_yaml(py::handle object, int depth) {
  if (depth > deepest) throw InvalidValue({}, "lists or maps too deep inside one another", "a few");
  if (object.is_none()) return YAML::Node();
  if (py::isinstance<py::bool_>(object)) return YAML::Node(py::cast<bool>(object));
  if (py::isinstance<py::int_>(object)) return YAML::Node(py::cast<std::string>(py::str(object)));
  if (py::isinstance<py::float_>(object)) return clothsim::number_node(py::cast<double>(object));
  if (py::isinstance<py::str>(object)) return clothsim::text_node(py::cast<std::string>(object));
  if (py::isinstance<py::dict>(object)) return map_node(object, depth);
  if (py::isinstance<py::list>(object) || py::isinstance<py::tuple>(object)) {
    return list_node(object, depth);
  }
  const py::object same = plain(object);
  if (!same.is(object)) return to_yaml(same, depth + 1);
  throw InvalidValue({}, describe(object), "a number, a text, True, False, a list or a dict");
}

/// Texts in quotes, so that they are read as texts.
void emit(const YAML::Node& node, YAML::Emitter& out) {
  if (node.IsMap()) {
    out << YAML::BeginMap;
    for (const auto& entry : node) {
      out << YAML::Key << YAML::DoubleQuoted << entry.first.Scalar() << YAML::Value;
      emit(entry.second, out);
    }
    out << YAML::EndMap;
  } else if (node.IsSequence()) {
    out << YAML::BeginSeq;
    for (const YAML::Node& item : node) emit(item, out);
    out << YAML::EndSeq;
  } else if (node.IsScalar() && node.Tag() == "!") {
    out << YAML::DoubleQuoted << node.Scalar();
  } else {
    out << node;
  }
}

template <class Number>
std::optional<Number> parse(const std::string& text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end) return std::nullopt;
  return value;
}

py::object scalar_to_python(const YAML::Node& node) {
  const std::string& text = node.Scalar();
  if (node.Tag() == "!") return py::str(text);
  if (text == "true" || text == "false") return py::bool_(text == "true");
  if (const auto whole = parse<long long>(text)) return py::int_(*whole);
  if (const auto number = parse<double>(text)) return py::float_(*number);
  return py::str(text);
}

}  // namespace

YAML::Node to_yaml(py::handle object) { return to_yaml(object, 0); }

std::string to_text(const YAML::Node& node) {
  YAML::Emitter text;
  text << YAML::Flow;
  emit(node, text);
  return text.c_str();
}

py::object to_python(const YAML::Node& node) {
  if (node.IsScalar()) return scalar_to_python(node);
  if (node.IsSequence()) {
    py::list list;
    for (const YAML::Node& item : node) list.append(to_python(item));
    return list;
  }
  if (!node.IsMap()) return py::none();
  py::dict map;
  for (const auto& entry : node) map[to_python(entry.first)] = to_python(entry.second);
  return map;
}

std::vector<std::string> assignments(const py::dict& overrides) {
  std::vector<std::string> all;
  for (const auto& [key, value] : overrides) {
    if (!py::isinstance<py::str>(key)) {
      throw InvalidValue({"overrides"}, describe(key) + " as a key", "path.to.key");
    }
    const auto name = py::cast<std::string>(key);
    clothsim::inside(name, [&] { all.push_back(name + "=" + to_text(to_yaml(value))); });
  }
  return all;
}

void override_from_dict(YAML::Node root, const py::dict& overrides) {
  clothsim::override_values(root, assignments(overrides));
}

YAML::Node load_source(const py::object& source, const py::dict& overrides) {
  YAML::Node root(YAML::NodeType::Map);
  const py::object value = plain(source);
  if (py::isinstance<py::str>(value)) {
    root = clothsim::load_scene_file(py::cast<std::string>(value));
  } else if (!value.is_none()) {
    root = to_yaml(value);
  }
  override_from_dict(root, overrides);
  return root;
}

}  // namespace clothsim_python
