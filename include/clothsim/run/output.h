#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/npz.h"
#include "clothsim/model/state.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim {

/// One line per point in row-major order under the header "x,y,z,vx,vy,vz" [m, m/s]; the digits
/// restore the same doubles.
std::string to_csv(const State&);

/// The surface as binary PLY: positions [m] in double precision, and triangles.
std::string to_ply(const Cloth&, const Points& positions);

/// A state to continue from: positions and velocities [N, 3], time, the simulator's memory, and the
/// poses of its colliders, [C, 7]: x, y, z [m] and a unit quaternion x, y, z, w.
struct StateFile {
  State state;
  std::vector<double> memory;   // empty: none
  std::vector<Pose> colliders;  // empty: unknown
};

/// The full state of a simulator.
StateFile state_file(const Simulator&);

/// Writes an NPZ file. Throws std::runtime_error where it cannot be written.
void write_state(const std::filesystem::path&, const StateFile&);

/// Reads a state from an NPZ file; a missing time is 0. From a file of frames: the last one,
/// without colliders. Throws InvalidValue with the path as first key.
StateFile read_state(const std::filesystem::path&);

/// The frames of a run as one NPZ file: positions and velocities [F, N, 3], times [F], and of the
/// cloth triangles [T, 3], springs [S, 3] (two points and the family), uv [N, 2] and pinned points.
/// Until finish(), the frames are in temporary files beside it. Throws std::runtime_error where it
/// cannot be written.
class FramesFile {
 public:
  FramesFile(std::filesystem::path path, const Cloth&);
  void append(const State&);
  void finish();

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string> topology_;  // as NPY
  GrowingNpy positions_, velocities_, times_;
};

}  // namespace clothsim
