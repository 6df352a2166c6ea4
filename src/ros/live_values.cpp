#include "clothsim/ros/live_values.h"

#include <vector>

namespace clothsim_ros {

std::string live_message(const clothsim::InvalidValue& error, const std::string& ns) {
  const std::vector<std::string>& key = error.key();
  std::string name = key.back();
  const bool is_component = key.size() >= 2 && (name == "0" || name == "1" || name == "2");
  if (is_component) {
    const std::string& vector = key[key.size() - 2];
    const bool is_color = vector == "color" || vector == "background";
    name = vector + "_" + (is_color ? "rgb" : "xyz")[std::stoul(name)];
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

}  // namespace clothsim_ros
