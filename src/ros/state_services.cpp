#include "clothsim/ros/state_services.h"

#include <ros/console.h>

#include <string>
#include <utility>

#include "clothsim/model/errors.h"
#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

using clothsim::InvalidValue;

constexpr std::size_t longest_name = 255;  // bytes

void check_name(const std::string& name) {
  if (name.empty()) throw InvalidValue({"name"}, "nothing", "a name");
  if (name.size() > longest_name) {
    throw InvalidValue({"name"}, "one of " + std::to_string(name.size()) + " bytes",
                       "at most " + std::to_string(longest_name));
  }
}

}  // namespace

StateServices::StateServices(ros::NodeHandle& node, clothsim::Simulator& simulator,
                             StepTargets& targets, FrameFollower& follower, Changes& changes,
                             std::uint64_t& frame_number, const bool& paused,
                             std::uint64_t save_limit, std::function<void()> jumped)
    : simulator_(simulator),
      targets_(targets),
      follower_(follower),
      changes_(changes),
      frame_number_(frame_number),
      paused_(paused),
      save_limit_(save_limit),
      jumped_(std::move(jumped)) {
  services_ = {node.advertiseService("get_state", &StateServices::get, this),
               node.advertiseService("set_state", &StateServices::set, this),
               node.advertiseService("save_state", &StateServices::save, this),
               node.advertiseService("restore_state", &StateServices::restore, this),
               node.advertiseService("untangle", &StateServices::untangle, this)};
}

bool StateServices::get(clothsim::GetState::Request&, clothsim::GetState::Response& response) {
  response.state = to_whole_state_msg(simulator_.state(), simulator_.memory(), frame_number_);
  response.paused = static_cast<std::uint8_t>(paused_);
  response.wind =
      to_vector_msg(simulator_.scene().simulation.wind.value_or(clothsim::Vector3(0, 0, 0)));
  response.scene = changes_.scene();
  follower_.look_up();
  std::map<std::string, clothsim::Pose> frames = follower_.frames(simulator_);
  for (const auto& [name, grip] : simulator_.grips()) frames.insert_or_assign(name, grip.pose);
  for (const auto& [name, pose] : frames) {
    response.frames.emplace_back();
    response.frames.back().child_frame_id = name;
    response.frames.back().transform = to_transform_msg(pose);
  }
  return true;
}

bool StateServices::set(clothsim::SetState::Request& request,
                        clothsim::SetState::Response& response) {
  try {
    simulator_.set_state(to_state(request.state), request.state.memory);
  } catch (const InvalidValue& error) {
    response.message = error.message("state/", "/");
    return true;
  }
  changes_.publish("set_state");
  frame_number_ = request.state.step;
  jumped_();
  response.success = true;
  if (const int pairs = simulator_.given_crossings(); pairs > 0) {
    response.message = "the state crosses itself in " + std::to_string(pairs) +
                       " pairs of triangles, which stay crossed: ~untangle takes them apart";
    ROS_WARN("~set_state: %s", response.message.c_str());
  }
  return true;
}

bool StateServices::untangle(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const clothsim::Untangled result = simulator_.untangle();
  response.success = result.left == 0;
  response.message = std::to_string(result.before) + " pairs of triangles crossed, " +
                     std::to_string(result.left) + " do now";
  if (result.before == 0) return true;
  changes_.publish("untangle");
  jumped_();
  return true;
}

bool StateServices::save(clothsim::SaveState::Request& request,
                         clothsim::SaveState::Response& response) {
  try {
    check_name(request.name);
    Entry entry{simulator_.save(), targets_.save(), follower_.save(), frame_number_, 0};
    entry.bytes = sizeof(Entry) + request.name.size() +
                  entry.follower.size() * sizeof(FrameFollower::Memory) +
                  clothsim::Simulator::bytes_of(*entry.simulation);
    for (const auto& [frame, motion] : entry.targets) entry.bytes += frame.size() + sizeof(motion);
    keep(request.name, std::move(entry));
  } catch (const InvalidValue& error) {
    response.message = error.message("", "/");
    return true;
  }
  response.success = true;
  return true;
}

void StateServices::keep(const std::string& name, Entry entry) {
  const auto last = saved_.find(name);
  const std::uint64_t others = saved_bytes_ - (last == saved_.end() ? 0 : last->second.bytes);
  if (others + entry.bytes > save_limit_) {
    throw InvalidValue(
        {"state"},
        std::to_string(entry.bytes) + " bytes beside " + std::to_string(others) + " that are kept",
        "at most ~save_limit together, " + std::to_string(save_limit_));
  }
  saved_bytes_ = others + entry.bytes;
  saved_[name] = std::move(entry);
}

bool StateServices::restore(clothsim::RestoreState::Request& request,
                            clothsim::RestoreState::Response& response) {
  const auto entry = saved_.find(request.name);
  if (entry == saved_.end()) {
    response.message =
        InvalidValue({"name"}, '"' + request.name + '"', "that of a saved state").what();
    return true;
  }
  simulator_.restore(*entry->second.simulation);
  targets_.restore(entry->second.targets);
  follower_.look_up();
  follower_.restore(entry->second.follower, simulator_);
  changes_.publish("restore_state");
  frame_number_ = entry->second.frame_number;
  jumped_();
  response.success = true;
  return true;
}

}  // namespace clothsim_ros
