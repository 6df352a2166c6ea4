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

/// Plays the motions of a scene. Times are rounded to whole frames of simulation, and a frame moves
/// from key frame to key frame as DrivenFrames has it, which is as ~step has it. The first one is
/// reached from where the frame is at the start; at time 0 the frame is put there.
class MotionPlayer {
 public:
  /// Files are looked for from `folder` on. Throws InvalidValue with keys from {"motions"} on, also
  /// for two key frames of one frame within one frame of simulation.
  MotionPlayer(const Simulator&, const std::filesystem::path& folder);

  /// Does what is due before the next frame: to be called before each Simulator::step(). Throws
  /// InvalidValue where the cloth does not have what an entry asks for.
  void play(Simulator&);

  /// When the last entry has its effect [s].
  double duration() const { return duration_; }

  /// How far it has come, for an archive that writes or reads its arguments. The motions
  /// themselves are the scene's.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(driven_, events_.next, frame_);
    for (auto& [frame, track] : keys_) archive(track.next);
  }

 private:
  /// An entry of the scene, before the frame of simulation that it comes before.
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

    std::size_t sort_in(Due<Action>);  // returns its place
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
