#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"
#include "clothsim/search/nearest_distances.h"
#include "clothsim/search/patches.h"
#include "clothsim/search/tiles.h"
#include "clothsim/search/tracked_pairs.h"

namespace clothsim {

/// A pair of features, at the positions last measured.
struct NearPair {
  std::uint64_t key;  // constant for the same features, and for a tracked pair
  SurfacePair pair;
  Separation separation;
};

/// Detects the pairs of a cloth's features that are near each other while it moves, in two ways.
///
/// approaching(): pairs that may touch. Tracked pairs of a point and a triangle move over the
/// surface, and edges that cross where no point is near are listed. These may be found a little
/// late, and are few. With points alone, all near pairs are listed.
///
/// swept_query(): all features that come as near as a floor on their paths. None is missed.
///
/// The surface is any mesh of triangles: a cloth's grid, or several sheets, with holes and seams.
/// It is cut into patches. Two of them are measured against each other, and then sleep until their
/// approach may have used up the distance between them. So results depend on the history: see
/// write().
class NearPairs {
 public:
  /// For a mesh with points at `rest` [m, N x 3], of surfaces or of points. `thickness`: by cloth
  /// [m]. Construction takes some 17 kB a point, and three to four times the time of a grid.
  NearPairs(const SurfaceMesh&, const Points& rest, const std::vector<double>& thickness,
            const Tiling::Range& stencils = Tiling::of_surfaces);
  /// For a cloth, a mesh or a grid, also of one row or column.
  explicit NearPairs(const Cloth&, const Tiling::Range& stencils = Tiling::of_surfaces);

  /// Pairs at `positions` that may touch on the paths to `ahead` [m, N x 3, finite], or are nearer
  /// than their contact distance plus a margin, by ascending key. Edges are closest at inner points
  /// of both, and of several triangles at the same distance from a point one is returned. Some are
  /// missing where the budget is spent.
  const std::vector<NearPair>& approaching(const Points& positions, const Points& ahead,
                                           const Workers& = {}, WorkBudget* = nullptr);
  /// The result of the last call.
  const std::vector<NearPair>& approaching() const { return near_; }

  /// All pairs of surfaces that may come within `floor` [m] of each other while points move
  /// straight from `here` to `ends`, in no reliable order: as long as no distance between patches
  /// falls by more than sees(). Some are missing where the budget is spent.
  std::vector<NearPair> swept_query(const Points& here, const Points& ends, double floor,
                                    const Workers& = {}, WorkBudget* = nullptr);

  /// The points have moved to the ends of the last query.
  void go(const Points& ends, const Workers& = {});

  /// Forgets the history.
  void forget();

  /// Largest approach of any two points on the paths of the last swept_query() [m].
  double max_approach() const { return motions_.max(); }
  double sees() const { return sees_; }

  /// Least contact distance of any pair [m].
  double min_nearest() const { return nearest_->min(); }

  /// The state for the next query. `read` throws InvalidValue for data that is not from `write`.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  /// Data that does not change as points move.
  struct Surface {
    std::shared_ptr<const SurfaceMesh> mesh;  // empty with points alone
    std::shared_ptr<const Tiling> tiling;
    std::shared_ptr<const std::vector<Patch>> patches;
    std::shared_ptr<const NearestDistances> nearest;
  };
  static Surface of_grid(const Cloth&, const Tiling::Range& stencils);
  static Surface of_mesh(const SurfaceMesh&, const Points& rest,
                         const std::vector<double>& thickness, const Tiling::Range& stencils);
  NearPairs(const Surface&, const Tiling::Range& stencils);

  /// Two edges or points that are near, by tiles and the number of the pair among their features.
  struct Listed {
    int a;
    int b;
    int number;
    double gap;  // rest of the gap at the last measurement [m]
  };

  /// Two patches, or one with itself.
  struct PatchPair {
    int p = 0;
    int q = 0;
    double step = 0;  // approach on the paths of the last query, at most [m]
    // Approach before features touch that are not tracked, or before any meet [m].
    double to_touch = 0;
    double to_meet = 0;
    std::vector<Listed> listed = {};  // edges where no point is near, or near points
  };

  /// Results of a band of patch pairs.
  struct Found {
    std::vector<SurfacePair> to_track;  // candidates for tracking
    std::vector<NearPair> meet;
  };

  // near_pairs.cpp: patches, and when they are measured.
  std::vector<std::array<int, 2>> near_patches(const std::vector<Box>&, const Workers&) const;
  void pair_patches(const Workers&);
  void bound_motion(const Points& ends, const Workers&);
  void move_to(const Points& positions, const Workers&);
  template <typename Condition>
  std::vector<PatchPair*> select(const Workers&, const Condition& meets);
  void shape(const std::vector<PatchPair*>& due, const Workers&);
  std::vector<NearPair> measure_all(const std::vector<PatchPair*>& due, double floor,
                                    const Workers&, WorkBudget*);
  bool may_touch(const SurfacePair&, const Separation&, const Points& ahead) const;
  void collect_points(const Points& ahead, const Workers&);
  void collect_listed(const Points& ahead, const Workers&);

  // near_pairs_measure.cpp: features of two patches that are near each other.
  void measure(PatchPair&, double within, Found&) const;
  void measure_points(PatchPair&) const;
  void measure_batch(PatchPair&, const int* pairs, std::size_t count, double within, Found&) const;
  std::pair<int, int> tiles(const PatchPair&, int number) const;

  bool of_points_;
  std::shared_ptr<const SurfaceMesh> mesh_;
  std::shared_ptr<const Tiling> tiling_;
  std::shared_ptr<const std::vector<Patch>> patches_;
  std::shared_ptr<const NearestDistances> nearest_;
  TileShapes shapes_;
  TrackedPairs tracked_;
  double sees_;    // approach of patches until they are paired again [m]
  double paired_;  // distance within which patches are paired [m]
  double margin_;  // [m]

  std::vector<PatchPair> patch_pairs_;  // ascending
  std::vector<PatchPair> last_pairs_;   // scratch: new memory would take longer than the pairing
  double paired_nearer_ = 0;            // approach of any two since they were paired, at most [m]
  int looks_ = 0;
  Points last_;  // positions last given; at first no rows
  PatchMotions motions_;
  std::vector<NearPair> near_;
};

}  // namespace clothsim
