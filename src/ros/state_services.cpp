#include "clothsim/ros/state_services.h"

#include <utility>

#include "clothsim/model/errors.h"
#include "clothsim/ros/conversions.h"

namespace clothsim_ros {
namespace {

/// States that may be kept at once: a client that saves in a loop is not to eat up the memory.
constexpr std::size_t most_saved = 1000;

}  // namespace

StateServices::StateServices(ros::NodeHandle& node, clothsim::Simulator& simulator,
                             FrameFollower& follower, Changes& changes, std::uint64_t& frame_number,
                             std::function<void()> jumped)
    : simulator_(simulator),
      follower_(follower),
      changes_(changes),
      frame_number_(frame_number),
      jumped_(std::move(jumped)) {
  services_ = {node.advertiseService("get_state", &StateServices::get, this),
               node.advertiseService("set_state", &StateServices::set, this),
               node.advertiseService("save_state", &StateServices::save, this),
               node.advertiseService("restore_state", &StateServices::restore, this)};
}

bool StateServices::get(clothsim::GetState::Request&, clothsim::GetState::Response& response) {
  response.state = to_whole_state_msg(simulator_.state(), simulator_.memory(), frame_number_);
  return true;
}

bool StateServices::set(clothsim::SetState::Request& request,
                        clothsim::SetState::Response& response) {
  try {
    simulator_.set_state(to_state(request.state), request.state.memory);
  } catch (const clothsim::InvalidValue& error) {
    response.message = error.message("state/", "/");
    return true;
  }
  changes_.publish("set_state");
  frame_number_ = request.state.step;
  jumped_();
  response.success = true;
  return true;
}

bool StateServices::save(clothsim::SaveState::Request& request,
                         clothsim::SaveState::Response& response) {
  if (request.name.empty()) {
    response.message = "name: got nothing, expected a name";
    return true;
  }
  if (saved_.size() >= most_saved && saved_.count(request.name) == 0) {
    response.message = "name: got one more than the " + std::to_string(most_saved) +
                       " that may be kept, expected one of theirs";
    return true;
  }
  saved_[request.name] = {simulator_.save(), follower_.save(), frame_number_};
  response.success = true;
  return true;
}

bool StateServices::restore(clothsim::RestoreState::Request& request,
                            clothsim::RestoreState::Response& response) {
  const auto entry = saved_.find(request.name);
  if (entry == saved_.end()) {
    response.message =
        clothsim::InvalidValue({"name"}, '"' + request.name + '"', "that of a saved state").what();
    return true;
  }
  simulator_.restore(*entry->second.simulation);
  follower_.look_up();
  follower_.restore(entry->second.follower, simulator_);
  changes_.publish("restore_state");
  frame_number_ = entry->second.frame_number;
  jumped_();
  response.success = true;
  return true;
}

}  // namespace clothsim_ros
