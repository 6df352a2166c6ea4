#include <yaml-cpp/eventhandler.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "clothsim/model/errors.h"
#include "clothsim/simulation/scene_yaml.h"
#include "clothsim/simulation/yaml_values.h"

namespace clothsim {
namespace {

/// Far above any scene written by hand.
constexpr std::streamsize max_file_size = 4'000'000;  // bytes

std::string read_file(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text(max_file_size + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad()) {
    throw InvalidValue({path}, std::strerror(errno), "a readable file");
  }
  if (file.gcount() > max_file_size) {
    throw InvalidValue({path}, "a larger file",
                       "at most " + std::to_string(max_file_size) + " bytes");
  }
  text.resize(static_cast<size_t>(file.gcount()));
  return text;
}

/// Takes no notice of what a parser finds.
class IgnoreEvents : public YAML::EventHandler {
  using Mark = YAML::Mark;
  using Anchor = YAML::anchor_t;
  using Style = YAML::EmitterStyle::value;

  void OnDocumentStart(const Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const Mark&, Anchor) override {}
  void OnAlias(const Mark&, Anchor) override {}
  void OnScalar(const Mark&, const std::string&, Anchor, const std::string&) override {}
  void OnSequenceStart(const Mark&, const std::string&, Anchor, Style) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const Mark&, const std::string&, Anchor, Style) override {}
  void OnMapEnd() override {}
};

/// Is there more than the one document that YAML::Load reads? YAML::LoadAll would tell, but never
/// returns on some malformed files.
bool has_more(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  IgnoreEvents ignore;
  parser.HandleNextDocument(ignore);
  return static_cast<bool>(parser);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

using Keys = std::vector<std::string>;

/// A copy of `node` with the value at keys[depth...] replaced. Copies the way there rather than
/// writing into it: an anchor may share the nodes with another key.
YAML::Node with_value(const YAML::Node& node, const Keys& keys, size_t depth,
                      const YAML::Node& value) {
  if (depth == keys.size()) return value;
  const std::string& key = keys[depth];

  if (node.IsDefined() && node.IsSequence()) {
    YAML::Node list(YAML::NodeType::Sequence);
    bool found = false;
    for (size_t i = 0; i < node.size(); ++i) {
      const bool here = std::to_string(i) == key;
      list.push_back(here ? with_value(node[i], keys, depth + 1, value) : node[i]);
      found = found || here;
    }
    if (!found) {
      throw InvalidValue(Keys(keys.begin(), keys.begin() + static_cast<long>(depth) + 1),
                         "no such item", "an index into a list of " + std::to_string(node.size()));
    }
    return list;
  }

  YAML::Node map(YAML::NodeType::Map);
  bool found = false;
  if (node.IsDefined() && node.IsMap()) {
    for (const auto& entry : node) {
      const bool here = !found && entry.first.IsScalar() && entry.first.Scalar() == key;
      map.force_insert(entry.first,
                       here ? with_value(entry.second, keys, depth + 1, value) : entry.second);
      found = found || here;
    }
  }
  if (!found) map.force_insert(key, with_value(YAML::Node(), keys, depth + 1, value));
  return map;
}

}  // namespace

YAML::Node load_scene_file(const std::string& path) {
  const std::string text = read_file(path);
  try {
    if (has_more(text)) throw InvalidValue({path}, "more after the first document", "one document");
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InvalidValue({path}, error.what(), "YAML");
  }
}

void override_value(YAML::Node root, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  const Keys keys = split(assignment.substr(0, equals), '.');
  bool empty_key = false;
  for (const std::string& key : keys) empty_key = empty_key || key.empty();
  if (equals == std::string::npos || empty_key) {
    throw InvalidValue({"assignment"}, '"' + assignment + '"', "path.to.key=value");
  }

  try {
    const YAML::Node value = YAML::Load(assignment.substr(equals + 1));
    root = with_value(root, keys, 0, value);
  } catch (const YAML::Exception& error) {
    throw InvalidValue(keys, error.what(), "YAML");
  }
}

}  // namespace clothsim
