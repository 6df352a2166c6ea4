#pragma once

#include <clothsim/GetState.h>
#include <clothsim/RestoreState.h>
#include <clothsim/SaveState.h>
#include <clothsim/SetState.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/ros/changes.h"
#include "clothsim/ros/frame_follower.h"
#include "clothsim/ros/step_targets.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim_ros {

/// The services ~get_state, ~set_state, ~save_state, ~restore_state and ~untangle.
class StateServices {
 public:
  /// All arguments must outlive this. `paused`: whether the simulation is. States may take
  /// `save_limit` bytes together. `jumped` is called after another state was set, and its frame
  /// number.
  StateServices(ros::NodeHandle&, clothsim::Simulator&, StepTargets&, FrameFollower&, Changes&,
                std::uint64_t& frame_number, const bool& paused, std::uint64_t save_limit,
                std::function<void()> jumped);

  /// Deletes the saved states.
  void clear() {
    saved_.clear();
    saved_bytes_ = 0;
  }

 private:
  struct Entry {
    std::shared_ptr<const clothsim::Simulator::Saved> simulation;
    StepTargets::Saved targets;
    FrameFollower::Saved follower;
    std::uint64_t frame_number;
    std::uint64_t bytes;
  };

  /// Stores an entry, and replaces one of the same name. Throws InvalidValue where there is no
  /// room.
  void keep(const std::string& name, Entry);

  bool get(clothsim::GetState::Request&, clothsim::GetState::Response&);
  bool set(clothsim::SetState::Request&, clothsim::SetState::Response&);
  bool save(clothsim::SaveState::Request&, clothsim::SaveState::Response&);
  bool restore(clothsim::RestoreState::Request&, clothsim::RestoreState::Response&);
  bool untangle(std_srvs::Trigger::Request&, std_srvs::Trigger::Response&);

  clothsim::Simulator& simulator_;
  StepTargets& targets_;
  FrameFollower& follower_;
  Changes& changes_;
  std::uint64_t& frame_number_;
  const bool& paused_;
  std::uint64_t save_limit_;
  std::function<void()> jumped_;
  std::map<std::string, Entry> saved_;
  std::uint64_t saved_bytes_ = 0;
  std::vector<ros::ServiceServer> services_;
};

}  // namespace clothsim_ros
