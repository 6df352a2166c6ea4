#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

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
  std::uint64_t key;  // the same for the same features at any time, and where a point's slot walks
  SurfacePair pair;
  Separation separation;
};

/// Finds the pairs of a cloth's features that are near each other while it moves, in two ways.
///
/// What may touch: points have slots that walk over the surface, and edges that cross where no
/// point does are listed. These may be found a little late, and are few. Of points alone, all that
/// are near each other are listed.
///
/// What may meet: all features that come as near as a floor on the way. None is missed.
///
/// The surface is any of triangles: a cloth's grid, or several sheets, with holes and seams. It is
/// cut into patches. Two of them are measured against each other, and then sleep until
/// they have used up what was between them. So what is found depends on what came before: see
/// write().
class NearPairs {
 public:
  /// Of a mesh whose points are at `rest` [m, N x 3], of surfaces or of points. It takes
  /// some 17 kB a point, and three to four times the time of a grid.
  NearPairs(const SurfaceMesh&, const Points& rest, double thickness,
            const Tiling::Range& stencils = Tiling::of_surfaces);
  /// Of a cloth's grid, also of one row or column.
  explicit NearPairs(const Cloth&, const Tiling::Range& stencils = Tiling::of_surfaces);

  /// Pairs at `positions` that may touch on the way to `ahead` [m, N x 3, finite], or are nearer
  /// than they may come plus a margin, by ascending key. Edges are closest inside both, and of the
  /// triangles that a point is as near to there is one. Some are missing where the budget is spent.
  const std::vector<NearPair>& approaching(const Points& positions, const Points& ahead,
                                           const Workers& = {}, WorkBudget* = nullptr);
  /// Those that it found last.
  const std::vector<NearPair>& approaching() const { return near_; }

  /// All pairs of surfaces that may come within `floor` [m] of each other while points go straight
  /// from `here` to `ends`, in no order to rely on: as long as no distance between patches falls by
  /// more than sees(). Some are missing where the budget is spent.
  std::vector<NearPair> swept_query(const Points& here, const Points& ends, double floor,
                                    const Workers& = {}, WorkBudget* = nullptr);

  /// Points have gone to the ends that it looked at last.
  void go(const Points& ends, const Workers& = {});

  /// Forgets all that came before.
  void forget();

  /// How much nearer any two points come on the ways that swept_query() looked at last, at most
  /// [m].
  double max_approach() const { return motions_.max(); }
  double sees() const { return sees_; }

  /// Nearest that any pair may come [m].
  double min_nearest() const { return nearest_->min(); }

  /// What the next look goes on with. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  /// What does not change as points move.
  struct Surface {
    std::shared_ptr<const SurfaceMesh> mesh;  // nothing of points
    std::shared_ptr<const Tiling> tiling;
    std::shared_ptr<const std::vector<Patch>> patches;
    std::shared_ptr<const NearestDistances> nearest;
  };
  static Surface of_grid(const Cloth&, const Tiling::Range& stencils);
  static Surface of_mesh(const SurfaceMesh&, const Points& rest, double thickness,
                         const Tiling::Range& stencils);
  NearPairs(const Surface&, const Tiling::Range& stencils);

  /// Two edges or points that are near, by tiles and the number of the pair among their features.
  struct Listed {
    int a;
    int b;
    int number;
    double gap;  // that is left of the one last measured [m]
  };

  /// Two patches, or one with itself.
  struct PatchPair {
    int p;
    int q;
    double step = 0;  // that they may come nearer on the way looked at last [m]
    // How much nearer they may come before features touch that have no slot, or any meet [m].
    double to_touch = 0;
    double to_meet = 0;
    std::vector<Listed> listed = {};  // where no point sees a triangle
  };

  /// What is found of a band of patch pairs.
  struct Found {
    std::vector<SurfacePair> to_track;  // that may be missing
    std::vector<NearPair> meet;
  };

  // near_pairs.cpp: patches, and when they are measured.
  void pair_patches();
  void foresee(const Points& ends, const Workers&);
  void be_at(const Points& positions, const Workers&);
  void shape(const std::vector<PatchPair*>& due, const Workers&);
  std::vector<NearPair> measure_all(const std::vector<PatchPair*>& due, double floor,
                                    const Workers&, WorkBudget*);
  bool may_touch(const SurfacePair&, const Separation&, const Points& ahead) const;
  void collect_points(const Points& ahead, const Workers&);
  void collect_listed(const Points& ahead, const Workers&);

  // near_pairs_measure.cpp: what two patches have near each other.
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
  double sees_;    // how much nearer patches may come before they are paired anew [m]
  double paired_;  // patches are from so far on [m]
  double margin_;  // [m]

  std::vector<PatchPair> patch_pairs_;  // ascending
  double paired_nearer_ = 0;            // that any two may have come since they were paired [m]
  int looks_ = 0;
  Points last_;  // positions last given; none yet: no rows
  PatchMotions motions_;
  std::vector<NearPair> near_;
};

}  // namespace clothsim
