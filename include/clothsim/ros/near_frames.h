#pragma once

#include <set>
#include <string>
#include <vector>

#include "clothsim/ros/tf_frame.h"

namespace clothsim_ros {

/// Warns of followed tf frames that nobody broadcasts where a broadcast frame has a similar name,
/// such as Sphere and sphere: once each.
class NearFrames {
 public:
  /// `frames`: the followed ones.
  void warn(const std::vector<FrameStatus>& frames, const TfListener&);

 private:
  std::set<std::string> told_;
};

}  // namespace clothsim_ros
