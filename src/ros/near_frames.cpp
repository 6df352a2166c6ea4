#include "clothsim/ros/near_frames.h"

#include <ros/console.h>

#include <algorithm>

#include "clothsim/model/nearest_word.h"

namespace clothsim_ros {

void NearFrames::warn(const std::vector<FrameStatus>& frames, const TfListener& tf) {
  std::vector<std::string> strangers;  // known to tf but not used
  for (const FrameStatus& frame : frames) {
    if (frame.seen || !frame.apart_from.empty() || told_.count(frame.frame) > 0) continue;
    if (strangers.empty()) {
      tf.buffer()._getFrameStrings(strangers);
      const auto is_followed = [&](const std::string& name) {
        return name == tf.world_frame() ||
               std::any_of(frames.begin(), frames.end(),
                           [&](const FrameStatus& other) { return other.frame == name; });
      };
      strangers.erase(std::remove_if(strangers.begin(), strangers.end(), is_followed),
                      strangers.end());
      if (strangers.empty()) return;
    }
    const std::string meant = clothsim::nearest_word(frame.frame, strangers);
    if (meant.empty()) continue;
    told_.insert(frame.frame);
    ROS_WARN("Nobody broadcasts tf frame %s, which the scene follows; did you mean %s?",
             frame.frame.c_str(), meant.c_str());
  }
}

}  // namespace clothsim_ros
