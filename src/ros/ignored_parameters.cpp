#include "clothsim/ros/ignored_parameters.h"

#include <ros/console.h>

#include <algorithm>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/nearest_word.h"
#include "clothsim/ros/parameters.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim_ros {
namespace {

using NameList = std::vector<std::string>;

/// Up to this many unknown names get a message each, with the probable meaning; more, as those of
/// another program, get one line with a few names.
constexpr std::size_t max_told = 5;
constexpr std::size_t examples = 3;

std::string text_of(const XmlRpc::XmlRpcValue& value) {
  try {
    return clothsim::describe(to_yaml(value));
  } catch (const clothsim::InvalidValue&) {
    return "binary data or a date";
  }
}

void add_texts(const std::string& name, XmlRpc::XmlRpcValue& value, ParameterTexts& texts) {
  if (value.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    texts[name] = text_of(value);
    return;
  }
  for (auto& [key, item] : value) add_texts(name.empty() ? key : name + '/' + key, item, texts);
}

bool has(const NameList& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The namespaces in names: "a" and "a/b" from "a/b/c".
std::set<std::string> spaces_of(const NameList& names) {
  std::set<std::string> spaces;
  for (const std::string& name : names) {
    for (auto end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1)) {
      spaces.insert(name.substr(0, end));
    }
  }
  return spaces;
}

/// The part of an unknown name that identifies it: up to the first namespace that is not known,
/// which may contain many names, of another node or of an earlier scene's collider.
std::string telling_part(const std::string& name, const std::set<std::string>& spaces) {
  std::size_t end = name.find('/');
  while (end != std::string::npos && spaces.count(name.substr(0, end)) > 0) {
    end = name.find('/', end + 1);
  }
  return name.substr(0, end);
}

/// The probable meaning of an unknown name, as the end of a message.
std::string suggestion(const std::string& name, const KnownParameters& known) {
  const std::string read = clothsim::nearest_word(name, known.read);
  if (!read.empty()) return "; did you mean " + read + '?';
  const std::string live = clothsim::nearest_word(name, known.live);
  if (live.empty()) return "";
  return "; did you mean " + live + "? It starts as ~scene or ~camera has it";
}

NameList messages_of_unknown(const std::string& prefix, const KnownParameters& known,
                             const std::set<std::string>& names) {
  const std::string expected = ", expected one of " + clothsim::join(known.read);
  NameList messages;
  if (names.size() > max_told) {
    std::string some;
    auto name = names.begin();
    for (std::size_t i = 0; i < examples; ++i) some += (i > 0 ? ", " : "") + *name++;
    messages.push_back(prefix + some + " and " + std::to_string(names.size() - examples) +
                       " more: got unknown parameters" + expected);
    return messages;
  }
  for (const std::string& name : names) {
    messages.push_back(prefix + name + ": got an unknown parameter" + expected +
                       suggestion(name, known));
  }
  return messages;
}

}  // namespace

ParameterTexts parameter_texts(const ros::NodeHandle& node) {
  ParameterTexts texts;
  XmlRpc::XmlRpcValue all;
  if (node.getParam(node.getNamespace(), all)) add_texts("", all, texts);
  return texts;
}

std::vector<std::string> ignored_parameters(const std::string& prefix, const KnownParameters& known,
                                            const ParameterTexts& given,
                                            const ParameterTexts& now) {
  const std::set<std::string> live_spaces = spaces_of(known.live);
  NameList overridden;
  std::set<std::string> unknown;
  for (const auto& [name, text] : given) {
    if (has(known.read, name.substr(0, name.find('/')))) continue;
    if (!has(known.live, name)) {
      unknown.insert(telling_part(name, live_spaces));
    } else if (now.count(name) > 0 && now.at(name) != text) {
      overridden.push_back(prefix + name + ": got " + text +
                           " before the start, expected it in ~scene or ~camera, whose " +
                           now.at(name) + " holds");
    }
  }
  NameList messages = messages_of_unknown(prefix, known, unknown);
  messages.insert(messages.end(), overridden.begin(), overridden.end());
  return messages;
}

void warn_of_ignored_parameters(const ros::NodeHandle& node, const KnownParameters& known,
                                const ParameterTexts& given) {
  const ParameterTexts now = parameter_texts(node);
  for (const std::string& message :
       ignored_parameters(node.getNamespace() + "/", known, given, now)) {
    ROS_WARN("%s", message.c_str());
  }
}

}  // namespace clothsim_ros
