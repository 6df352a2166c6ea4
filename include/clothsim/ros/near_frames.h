#pragma once

#include <set>
#include <string>
#include <vector>

#include "clothsim/ros/tf_frame.h"

namespace clothsim_ros {

/// Warns of tf frames that are nearly called as ones that nobody broadcasts, such as Sphere beside
/// sphere: once each.
class NearFrames {
 public:
  /// `frames` are those that something follows.
  void warn(const std::vector<FrameStatus>& frames, const TfListener&);

 private:
  std::set<std::string> told_;
};

}  // namespace clothsim_ros
