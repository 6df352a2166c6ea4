#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "clothsim/model/errors.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

using Keys = std::vector<std::string>;

/// Checks the size first: a file without a size, as a pipe or a device, may never end.
std::string read_file(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw InvalidValue({path}, error.message(), "a regular file");
  if (size > max_file_size) {
    throw InvalidValue({path}, std::to_string(size) + " bytes",
                       "at most " + std::to_string(max_file_size));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string text(size, '\0');
  file.read(text.data(), static_cast<std::streamsize>(size));
  if (!file.is_open() || file.bad()) {
    throw InvalidValue({path}, std::strerror(errno), "a readable file");
  }
  text.resize(static_cast<size_t>(file.gcount()));
  return text;
}

/// Ignores all events of a parser.
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

/// Is there more than the one document that YAML::Load reads? YAML::LoadAll would show it, but
/// never returns on some malformed files.
bool has_more(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  IgnoreEvents ignore;
  parser.HandleNextDocument(ignore);
  return static_cast<bool>(parser);
}

/// Throws InvalidValue with `keys` unless `text` is one document of YAML.
YAML::Node parse(const std::string& text, const Keys& keys) {
  try {
    if (has_more(text)) throw InvalidValue(keys, "more after the first document", "one document");
    return YAML::Load(text);
  } catch (const YAML::DeepRecursion& error) {
    throw InvalidValue(
        keys,
        "lists or maps too deep inside one another in line " + std::to_string(error.mark.line + 1),
        "YAML of a few levels");
  } catch (const YAML::Exception& error) {
    throw InvalidValue(keys, error.what(), "YAML");
  }
}

Keys split(const std::string& text, char separator) {
  Keys parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

/// The changes of one value by assignments: a new value, then changes by key inside it.
struct Change {
  std::optional<YAML::Node> value;
  std::map<std::string, Change> inside;
};

void add(const std::string& assignment, Change& root) {
  const size_t equals = assignment.find('=');
  const Keys keys = split(assignment.substr(0, equals), '.');
  bool empty_key = false;
  for (const std::string& key : keys) empty_key = empty_key || key.empty();
  if (equals == std::string::npos || empty_key) {
    throw InvalidValue({"assignment"}, '"' + assignment + '"', "path.to.key=value");
  }
  if (keys.size() > longest_shown) {
    throw InvalidValue({"assignment"}, "a path of " + std::to_string(keys.size()) + " keys",
                       "at most " + std::to_string(longest_shown));
  }
  Change* place = &root;
  for (const std::string& key : keys) place = &place->inside[key];
  place->value = parse(assignment.substr(equals + 1), keys);
  place->inside.clear();
}

/// Makes changed copies of the parts of a tree. Copies the path to each change rather than writing
/// into it, as an anchor may share the nodes with another key.
class Changer {
 public:
  explicit Changer(const YAML::Node& root) { memory_.push_back(root); }

  YAML::Node changed(const YAML::Node& node, const Change& change, Keys& path) {
    const YAML::Node& base = change.value ? *change.value : node;
    if (change.inside.empty()) return base;
    const bool is_list = base.IsDefined() && base.IsSequence();
    return is_list ? changed_list(base, change, path) : changed_map(base, change, path);
  }

 private:
  /// yaml-cpp merges the memory pools of nodes that are joined, at a cost that grows with the
  /// second pool: a new node joins the tree's pool while its own is small.
  YAML::Node make(YAML::NodeType::value type) {
    YAML::Node node(type);
    memory_.push_back(node);
    return node;
  }

  YAML::Node changed_item(const YAML::Node& node, const Change& change, const std::string& key,
                          Keys& path) {
    path.push_back(key);
    const YAML::Node item = changed(node, change, path);
    path.pop_back();
    return item;
  }

  YAML::Node changed_list(const YAML::Node& node, const Change& change, Keys& path) {
    YAML::Node list = make(YAML::NodeType::Sequence);
    std::set<std::string> missing;
    for (const auto& entry : change.inside) missing.insert(entry.first);
    size_t index = 0;
    for (const YAML::Node& item : node) {
      const std::string key = std::to_string(index++);
      const bool here = missing.erase(key) > 0;
      list.push_back(here ? changed_item(item, change.inside.at(key), key, path) : item);
    }
    if (!missing.empty()) {
      path.push_back(*missing.begin());
      throw InvalidValue(path, "no such item", "an index into a list of " + std::to_string(index));
    }
    return list;
  }

  YAML::Node changed_map(const YAML::Node& node, const Change& change, Keys& path) {
    YAML::Node map = make(YAML::NodeType::Map);
    std::set<std::string> missing;
    for (const auto& entry : change.inside) missing.insert(entry.first);
    if (node.IsDefined() && node.IsMap()) {
      for (const auto& entry : node) {
        // The second one of a repeated key stays, for the reader to refuse.
        const bool here = entry.first.IsScalar() && missing.erase(entry.first.Scalar()) > 0;
        const std::string key = here ? entry.first.Scalar() : "";
        map.force_insert(
            entry.first,
            here ? changed_item(entry.second, change.inside.at(key), key, path) : entry.second);
      }
    }
    for (const std::string& key : missing) {
      map.force_insert(key, changed_item(YAML::Node(), change.inside.at(key), key, path));
    }
    return map;
  }

  YAML::Node memory_{YAML::NodeType::Sequence};
};

}  // namespace

YAML::Node load_scene_text(const std::string& text, const std::string& key) {
  return parse(text, {key});
}

YAML::Node load_scene_file(const std::string& path) { return parse(read_file(path), {path}); }

void override_values(YAML::Node root, const std::vector<std::string>& assignments) {
  Change change;
  for (const std::string& assignment : assignments) add(assignment, change);
  Keys path;
  root = Changer(root).changed(root, change, path);
}

}  // namespace clothsim
