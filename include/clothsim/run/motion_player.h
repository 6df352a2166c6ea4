#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "clothsim/run/driven_frames.h"
#include "clothsim/scene/motion.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// Plays the motions of a scene. Times are rounded to whole frames of simulation. A frame moves
/// from key frame to key frame by DrivenFrames, as with ~step. It starts towards the first one from
/// its pose at the start; a key frame at time 0 puts the frame there.
class MotionPlayer {
 public:
  /// Paths of files are relative to `folder`. Throws InvalidValue with keys from {"motions"} on,
  /// also for two key frames of one frame within one frame of simulation.
  MotionPlayer(const Simulator&, const std::filesystem::path& folder);

  /// Applies the entries due before the next frame: to be called before each Simulator::step().
  /// Throws InvalidValue where an entry does not fit the cloth.
  void play(Simulator&);

  /// Time at which the last entry takes effect [s].
  double duration() const { return duration_; }

  /// The progress, for an archive that writes or reads its arguments. The motions themselves are
  /// part of the scene.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(driven_, events_.next, frame_);
    for (auto& [frame, track] : keys_) archive(track.next);
  }

 private:
  /// An entry of the scene, and the frame of simulation that it precedes.
  template <class Action>
  struct Due {
    long long frame;
    std::size_t item;
    Action action;
  };
  template <class Action>
  struct Track {
    std::vector<Due<Action>> entries;  // by time
    std::size_t next = 0;

    std::size_t sort_in(Due<Action>);  // returns its index
  };

  void sort_in(const Simulator&, const MotionEntry&, std::size_t item);
  void set_target(const std::string& frame, Track<FrameTarget>&, Simulator&);
  void act(const MotionAction&, Simulator&);
  void attach(const AttachPoints&, Simulator&) const;

  DrivenFrames driven_;
  std::map<std::string, Track<FrameTarget>> keys_;  // by frame's name
  Track<MotionAction> events_;
  long long frame_ = 0;
  double duration_ = 0;
};

}  // namespace clothsim
