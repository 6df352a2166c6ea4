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

/// What points are near: each slot is a point and a triangle, the one of a layer with the least
/// gap. It is kept from step to step and walks over the surface: where a triangle beside it has
/// less, it goes on to that. Not from where it touches to what may come nearer, as nearer
/// neighbours on the cloth may: nothing would see any more that it touches.
class TrackedPairs {
 public:
  struct TrackedPair {
    SurfacePair pair;
    int number;            // among those of its point: stays as it walks
    int owner;             // of the triangles that have the closest place, the first
    Separation last = {};  // when it was looked at

    double gap() const { return last.distance - pair.nearest; }
  };

  /// A slot ends where its distance is more than this, of the nearest that its features may come.
  static constexpr double range = 1.5;

  TrackedPairs(std::shared_ptr<const SurfaceMesh>, std::shared_ptr<const NearestDistances>);

  /// Has slots walk, and ends those that have come far, or to where one of the same point is.
  /// Returns how many are left.
  std::int64_t track(const Points& positions, const Workers& = {});

  /// Makes a slot of each point and triangle that none of the point has.
  void add(std::vector<SurfacePair>, const Points& positions, const Workers& = {});

  /// Does a slot of the point keep it off a triangle that is at a `distance` [m]? It is there, or
  /// beside it with no larger a gap.
  bool covers(const SurfacePair&, float distance) const;

  /// Points that may have slots.
  int size() const { return static_cast<int>(pairs_.size()); }
  /// Of a point, by number.
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
