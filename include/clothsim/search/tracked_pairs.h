#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/workers.h"
#include "clothsim/search/nearest_distances.h"

namespace clothsim {

/// Pairs of a point and a triangle near it, the one of a layer with the least gap. A pair is kept
/// from step to step and moves to an adjacent triangle with a smaller gap. It does not move from a
/// triangle that it touches to one with a smaller contact distance, as nearer neighbours on the
/// cloth have: the contact would no longer be seen.
class TrackedPairs {
 public:
  struct TrackedPair {
    SurfacePair pair;
    int number;            // among those of its point: stays as the triangle changes
    int owner;             // first of the triangles with the closest place
    Separation last = {};  // at the last measurement

    double gap() const { return last.distance - pair.nearest; }
  };

  /// Distance beyond which a pair is no longer tracked, of its contact distance.
  static constexpr double range = 1.5;

  TrackedPairs(std::shared_ptr<const SurfaceMesh>, std::shared_ptr<const NearestDistances>);

  /// Moves pairs to adjacent triangles, and drops those that are far, or at the same place as
  /// another one of the point. Returns the number left.
  std::int64_t track(const Points& positions, const Workers& = {});

  /// Tracks each of these pairs that is not tracked yet.
  void add(std::vector<SurfacePair>, const Points& positions, const Workers& = {});

  /// Does a tracked pair of the point keep it off a triangle at a `distance` [m]? It is at that
  /// triangle, or at an adjacent one with no larger a gap.
  bool covers(const SurfacePair&, float distance) const;

  /// Points that may have tracked pairs.
  int size() const { return static_cast<int>(pairs_.size()); }
  /// Those of a point, by number.
  const std::vector<TrackedPair>& of(int point) const {
    return pairs_[static_cast<std::size_t>(point)];
  }

  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  const std::array<int, 3>& corners(int triangle) const {
    return mesh_->triangles[static_cast<std::size_t>(triangle)];
  }
  bool has(int triangle, int point) const {
    const auto& [a, b, c] = corners(triangle);
    return a == point || b == point || c == point;
  }
  SurfacePair pair(int point, int triangle) const;
  template <typename Visit>
  void for_each_adjacent(const TrackedPair&, const Visit&) const;
  void go_to_nearest(TrackedPair&, const Points&) const;
  void add(int point, int triangle, const Points& positions);
  bool is_kept(const TrackedPair&, const TrackedPair* begin, const TrackedPair* end) const;

  std::shared_ptr<const SurfaceMesh> mesh_;
  std::shared_ptr<const NearestDistances> nearest_;
  std::vector<std::vector<TrackedPair>> pairs_;  // by point
};

}  // namespace clothsim
