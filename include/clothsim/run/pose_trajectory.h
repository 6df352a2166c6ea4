#pragma once

#include <optional>

#include "clothsim/scene/motion.h"

namespace clothsim {

/// The trajectory of a frame between two poses. Without a twist at its end, the origin moves in a
/// straight line at constant speed, and the frame turns at constant speed by at most half a turn
/// (slerp). With one, position and rotation vector are cubics (Hermite) with the given twists at
/// both ends, so that consecutive trajectories have a continuous velocity.
class PoseTrajectory {
 public:
  /// Stays at `pose`.
  explicit PoseTrajectory(const Pose& pose) : start_(pose), end_(pose) {}

  /// `duration` > 0 [s]. `start_twist` is used where `end_twist` is given.
  PoseTrajectory(const Pose& start, const Twist& start_twist, const Pose& end,
                 const std::optional<Twist>& end_twist, double duration);

  /// The pose at a share from 0 to 1 of the duration. At 1 the end, to the last bit.
  Pose pose_at(double share) const;
  Twist twist_at(double share) const;

  const Pose& end() const { return end_; }

  /// For an archive that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(start_, end_, position_, turn_, duration_);
  }

 private:
  /// s d + s (1 - s) ((1 - s) first - s last): from 0 at s = 0 to d, the displacement, at
  /// s = 1. `first` and `last`:
  /// differences of the slopes there from d, which may be 0.
  struct Cubic {
    Vector3 displacement{0, 0, 0};
    Vector3 first{0, 0, 0};
    Vector3 last{0, 0, 0};

    Vector3 at(double s) const;
    Vector3 slope(double s) const;  // by s

    template <class Archive>
    void serialize(Archive& archive) {
      archive(displacement, first, last);
    }
  };

  Pose start_;
  Pose end_;
  Cubic position_;  // from the start [m]
  Cubic turn_;      // rotation vector from the start, in the world [rad]
  double duration_ = 1;
};

}  // namespace clothsim
