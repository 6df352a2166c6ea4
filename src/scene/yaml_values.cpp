#include "clothsim/scene/yaml_values.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene.h"

namespace clothsim {
namespace {

/// Tags of scalars in yaml-cpp: "?" read without quotes, "!" read with quotes, "" made by a
/// program.
bool is_plain(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() && (node.Tag() == "?" || node.Tag().empty());
}

bool is_quoted(const YAML::Node& node) {
  return node.IsDefined() && node.IsScalar() &&
         (node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str");
}

enum class Parsed { number, too_large, no_number };

/// Numbers in decimal; numbers that YAML 1.1 and 1.2 read differently (010, 1_000, 1:30) are
/// refused.
template <class Number>
Parsed parse(const std::string& text, Number& value) {
  const size_t sign = !text.empty() && (text[0] == '+' || text[0] == '-') ? 1 : 0;
  const size_t first = text.find_first_of(".0123456789");  // excludes inf and nan
  const bool octal = text.size() > sign + 1 && text[sign] == '0' &&
                     text.find_first_not_of("0123456789", sign) == std::string::npos;
  if (first != sign || octal) return Parsed::no_number;

  const char* begin = text.data() + (text[0] == '+' ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(begin, end, value);
  if (result.ptr != end) return Parsed::no_number;
  return result.ec == std::errc() ? Parsed::number : Parsed::too_large;
}

/// An integer in any notation: 50, 50.0 or 5.0e+1.
Parsed parse_whole(const std::string& text, std::int64_t& value) {
  const double exact = std::ldexp(1.0, std::numeric_limits<double>::digits);  // exact up to this
  const Parsed parsed = parse(text, value);
  double number = 0;
  if (parsed != Parsed::no_number || parse(text, number) != Parsed::number) return parsed;
  if (std::trunc(number) != number || std::abs(number) > exact) return Parsed::no_number;
  value = static_cast<std::int64_t>(number);
  return Parsed::number;
}

std::optional<bool> parse_switch(const YAML::Node& node) {
  bool value = false;
  if (!is_plain(node) || !YAML::convert<bool>::decode(node, value)) return std::nullopt;
  return value;
}

std::string shortened(const std::string& text) { return clothsim::shortened(text, longest_shown); }

std::string describe_scalar(const YAML::Node& node) {
  if (is_plain(node)) return shortened(node.Scalar());
  if (is_quoted(node)) return '"' + shortened(node.Scalar()) + "\" (text)";
  return shortened(node.Tag()) + ' ' + shortened(node.Scalar());
}

[[noreturn]] void refuse(const YAML::Node& node, const std::string& expected) {
  throw InvalidValue({}, describe(node), expected);
}

std::int64_t read_integer(const YAML::Node& node, std::int64_t min, std::int64_t max,
                          const std::string& expected = "a whole number") {
  std::int64_t value = 0;
  const Parsed parsed = is_plain(node) ? parse_whole(node.Scalar(), value) : Parsed::no_number;
  if (parsed == Parsed::no_number) refuse(node, expected);

  const bool negative = node.Scalar()[0] == '-';
  const bool too_large = parsed == Parsed::too_large;
  if (value < min || (too_large && negative)) {
    refuse(node, expected + " of at least " + std::to_string(min));
  }
  if (value > max || too_large) refuse(node, expected + " of at most " + std::to_string(max));
  return value;
}

}  // namespace

std::string describe(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "nothing";
  if (node.IsScalar()) return describe_scalar(node);
  if (node.IsMap()) return "a map";

  // One level only, as a list may contain itself.
  std::string items;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar() || items.size() > longest_shown) {
      return "a list of " + std::to_string(node.size());
    }
    items += (items.empty() ? "" : ", ") + describe_scalar(item);
  }
  return '[' + items + ']';
}

YAML::Node number_node(double value) {
  return std::isfinite(value) ? YAML::Node(to_text(value)) : YAML::Node(value);
}

YAML::Node text_node(const std::string& text) {
  YAML::Node node(text);
  node.SetTag("!");
  return node;
}

double read_number(const YAML::Node& node, const std::string& expected) {
  double value = 0;
  if (!is_plain(node) || parse(node.Scalar(), value) != Parsed::number) refuse(node, expected);
  return value;
}

int read_int(const YAML::Node& node, const std::string& expected) {
  using Limits = std::numeric_limits<int>;
  return static_cast<int>(read_integer(node, Limits::min(), Limits::max(), expected));
}

bool read_switch(const YAML::Node& node, const std::string& expected) {
  const auto value = parse_switch(node);
  if (!value) refuse(node, expected);
  return *value;
}

std::string read_text(const YAML::Node& node) {
  double number = 0;
  const bool is_text = is_quoted(node) || (is_plain(node) && !parse_switch(node) &&
                                           parse(node.Scalar(), number) == Parsed::no_number);
  if (!is_text || node.Scalar().empty()) refuse(node, "a text that is not empty");
  return node.Scalar();
}

Vector3 read_vector(const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 3) refuse(node, "a list of three numbers");
  Vector3 vector;
  int axis = 0;
  read_list(node, [&](const YAML::Node& item) { vector[axis++] = read_number(item); });
  return vector;
}

bool is_word(const YAML::Node& node, const std::string& word) {
  return (is_plain(node) || is_quoted(node)) && node.Scalar() == word;
}

int read_choice(const YAML::Node& node, const std::vector<std::string>& choices) {
  for (size_t i = 0; i < choices.size(); ++i) {
    if (is_word(node, choices[i])) return static_cast<int>(i);
  }
  refuse(node, "one of " + join(choices));
}

void read_map(const YAML::Node& node, const std::vector<Field>& fields) {
  if (!node.IsMap()) refuse(node, "a map");

  std::set<std::string> seen;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      throw InvalidValue({}, describe(entry.first) + " as a key", "a name");
    const std::string& key = entry.first.Scalar();
    const Field* field = nullptr;
    std::vector<std::string> known;
    for (const Field& candidate : fields) {
      known.push_back(candidate.key);
      if (candidate.key == key) field = &candidate;
    }
    if (field == nullptr) {
      throw InvalidValue({shortened(key)}, "an unknown key", "one of " + join(known));
    }
    if (!seen.insert(key).second) throw InvalidValue({key}, "the key again", "it once");
    inside(key, [&] { field->read(entry.second); });
  }
}

void append(std::vector<Field> more, std::vector<Field>& fields) {
  for (Field& field : more) fields.push_back(std::move(field));
}

void read_list(const YAML::Node& node, const std::function<void(const YAML::Node&)>& read_item) {
  if (!node.IsSequence()) refuse(node, "a list");
  size_t index = 0;
  for (const YAML::Node& item : node) {
    inside(std::to_string(index++), [&] { read_item(item); });
  }
}

ReadValue into(double& target) {
  return [&target](const YAML::Node& node) { target = read_number(node); };
}

ReadValue into(int& target) {
  return [&target](const YAML::Node& node) { target = read_int(node); };
}

ReadValue into(std::uint64_t& target) {
  return [&target](const YAML::Node& node) {
    target =
        static_cast<std::uint64_t>(read_integer(node, 0, std::numeric_limits<std::int64_t>::max()));
  };
}

ReadValue into(bool& target) {
  return [&target](const YAML::Node& node) { target = read_switch(node); };
}

ReadValue into(std::string& target) {
  return [&target](const YAML::Node& node) { target = read_text(node); };
}

ReadValue into(Vector3& target) {
  return [&target](const YAML::Node& node) { target = read_vector(node); };
}

ReadValue into(std::array<double, 2>& target) {
  return [&target](const YAML::Node& node) {
    if (node.IsSequence() && node.size() == 2) {
      std::size_t i = 0;
      read_list(node, [&](const YAML::Node& item) { target[i++] = read_number(item); });
    } else {
      target.fill(read_number(node, "a finite number or a list of two"));
    }
  };
}

ReadValue into(std::optional<double>& target) {
  return [&target](const YAML::Node& node) {
    if (is_word(node, "off") || is_word(node, "false")) {  // YAML 1.1 reads off as false
      target.reset();
    } else {
      target = read_number(node, "a finite number or off");
    }
  };
}

}  // namespace clothsim
