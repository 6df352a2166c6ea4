#include "clothsim/ros/live_values.h"

#include <array>
#include <vector>

#include "clothsim/model/checks.h"

namespace clothsim_ros {
namespace {

/// The name of a component of a value.
std::string component_name(const std::string& value, std::size_t index) {
  using Names = std::array<const char*, 2>;
  if (value == "color" || value == "background") return std::string(1, "rgb"[index]);
  if (value == "stretch_stiffness" || value == "bending_stiffness") {
    return Names{"warp", "weft"}.at(index);
  }
  if (value == "internal_damping") return Names{"stretch", "bending"}.at(index);
  if (value == "drag") return Names{"across", "along"}.at(index);
  return std::string(1, "xyz"[index]);
}

}  // namespace

std::string live_message(const clothsim::InvalidValue& error, const std::string& ns) {
  const std::vector<std::string>& key = error.key();
  std::string name = key.back();
  const bool is_component = key.size() >= 2 && (name == "0" || name == "1" || name == "2");
  if (is_component) {
    const std::string& vector = key[key.size() - 2];
    name = vector + "_" + component_name(vector, std::stoul(name));
  }
  const std::string message = error.message("", "/");
  return ns + "/" + name + message.substr(message.find(": got"));
}

std::optional<std::string> refusal(const std::function<void()>& apply, const std::string& ns) {
  try {
    apply();
  } catch (const clothsim::InvalidValue& error) {
    return live_message(error, ns);
  } catch (const std::exception& error) {
    return ns + ": " + error.what();
  }
  return {};
}

std::string text_of(const dynamic_reconfigure::Config& msg) {
  for (const auto& item : msg.bools) return item.name + (item.value != 0 ? " true" : " false");
  for (const auto& item : msg.ints) return item.name + ' ' + std::to_string(item.value);
  for (const auto& item : msg.strs) return item.name + " \"" + item.value + '"';
  for (const auto& item : msg.doubles) return item.name + ' ' + clothsim::to_text(item.value);
  return "";
}

}  // namespace clothsim_ros
