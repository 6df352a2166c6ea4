#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/distances.h"
#include "clothsim/search/cell_outlines.h"
#include "clothsim/search/feature_pairs.h"
#include "clothsim/search/near_pairs.h"
#include "clothsim/search/nearest_distances.h"
#include "clothsim/search/patches.h"
#include "clothsim/search/unfolded.h"

namespace clothsim {

struct NearPairs::Impl {
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  /// Pairs are looked at from this share of the margin on, however slowly they approach: with 0.1,
  /// some of a pile at rest come and go.
  static constexpr double least_margin_share = 0.3;
  /// Cells along the side of a patch.
  static constexpr int patch_cells = CellOutlines::cells_along_side;
  /// So many looks like that of now what is listed or kept is to serve: with 1.2, more is found
  /// anew while a cloth folds than is saved.
  static constexpr double looks = 4;
  /// Makes up for the rounding of lengths to single precision.
  static constexpr double rounding = std::numeric_limits<float>::epsilon();
  static float rounded_up(double length) {
    return static_cast<float>(length) * (1 + static_cast<float>(rounding));
  }

  /// Features of two patches that are near: not more of them than it takes to measure them.
  struct Listed {
    std::array<int, 4> points;
    float nearest;  // that they may come, or a little more [m]
    unsigned key;   // its end
  };
  struct List {
    std::vector<Listed> features;
    // How far the patches will have moved since the list was made when there may be no gap [m].
    std::vector<float> wake_at;

    void clear() {
      features.clear();
      wake_at.clear();
    }
  };

  /// Two patches, or one with itself. A gap is what is left of a distance over the nearest that two
  /// features may come.
  struct PatchPair {
    int p;
    int q;
    bool are_neighbours;  // on the cloth
    double moved = 0;     // how much nearer they may have come so far [m]
    // `moved` from which on there may be no gap, by SurfacePair::edges.
    std::array<double, 2> wake_at = {-infinity, -infinity};
    // Features whose gap may be none before `moved` is list_until, by SurfacePair::edges.
    std::array<List, 2> lists = {};
    double listed_at = 0;  // `moved` when the lists were made
    double list_until = -infinity;
  };

  /// What is asked for: of features whose gap is within some reach those that are within a
  /// `distance`, and may meet on the way `ahead`, if that matters.
  struct Query {
    const Points& positions;
    const Points* ahead;
    double distance;
    WorkBudget* budget;           // none: all is looked at
    std::array<double, 2> reach;  // [m], by PatchPair::are_neighbours

    double within(const PatchPair& pair) const { return reach[pair.are_neighbours]; }

    /// Takes visits from the budget. False where it is spent.
    bool spend(std::size_t visits) const {
      if (!budget) return true;
      budget->spend(static_cast<std::int64_t>(visits));
      return !budget->is_spent();
    }
  };

  /// Two cells whose features are measured.
  struct Cells {
    PatchPair* of;
    std::size_t number;  // among those of the patches, see CellOutlines
    std::array<int, 2> cells;
    double most_nearest;  // of their features [m]
    double reach;         // of the list
  };
  /// Features on a list that are measured.
  struct Awake {
    PatchPair* of;
    std::size_t place;  // on the list
  };
  /// What is measured of a band of patch pairs.
  struct Scratch {
    int band = -1;  // first patch pair
    std::vector<PatchPair*> awake;
    // By SurfacePair::edges.
    std::array<std::array<std::vector<Cells>, FeaturePairs::num_lists>, 2> cells;
    std::vector<Awake> features;
    std::array<Distances, 2> distances{Distances(false), Distances(true)};
    std::vector<std::uint64_t> found;  // keys
    std::vector<NearPair> near;
  };

  explicit Impl(const Cloth&);
  double least_margin() const { return least_margin_share * margin; }

  // near_pairs.cpp: patches, and when they are looked at.
  void advance(const Cloth&, const Points& positions, const Workers&);
  void pair_patches(double reach);
  bool are_neighbours(int p, int q) const;
  void outline(const Cloth&, const Points& positions, const Workers&);
  const std::vector<NearPair>& look(const Query&, const Workers&);
  const std::vector<NearPair>& collect();

  // near_pairs_kept.cpp: pairs kept over some looks.
  /// Farthest way of a point beyond the common one [m].
  static double spread(const Points& from, const Points& to);
  double kept_reach() const;
  double nearer_than_kept(const Points& positions) const;
  std::optional<double> keep(const Cloth&, const Query&, double step, const Workers&);
  const std::vector<NearPair>& look_at_kept(const Query&, double reach);

  // near_pairs_search.cpp: what two of them have near each other.
  double gap_of_patches(const PatchPair&) const;
  void seek(const Query&, PatchPair&, Scratch&) const;
  void measure_later(const Query&, bool edges, const Cells&, Scratch&) const;
  void measure_cells(const Query&, bool edges, std::size_t number, Scratch&) const;
  void look_at_lists(const Query&, bool edges, Scratch&) const;
  void measure_awake(const Query&, bool edges, Scratch&) const;
  bool is_asked_for(const Query&, double within, const Distances&, std::size_t k,
                    const std::array<int, 4>& points, double least) const;
  float consider(const Query&, const Distances&, std::size_t k, const Listed&, PatchPair&,
                 Scratch&) const;
  void keep_found(const Query&, Scratch&) const;
  SurfacePair features_of(std::uint64_t key) const;

  SurfaceMesh mesh;
  NearestDistances nearest;
  FeaturePairs feature_pairs;
  double spacing;              // shorter one at rest [m]
  double least_rest_distance;  // of two features that share no point [m]
  double contact;              // distance, of layers [m]
  double margin;

  std::vector<Patch> patches;  // along rows
  int patch_columns;
  std::vector<PatchPair> patch_pairs;  // by p, then q
  Points last;                         // positions last given; none yet: no rows
  Points paired_at;                    // positions where patches were paired
  PatchMotions motions;

  // At the positions last given.
  CellOutlines outlines;
  std::vector<Box> boxes;                 // by patch
  std::vector<GradientBounds> gradients;  // by patch

  struct Kept {
    double gap;  // when it was kept [m]
    std::uint64_t key;
    std::size_t place;  // by key, among all that are kept
    SurfacePair pair;
  };
  // Pairs whose gap was within kept_reach(), by SurfacePair::edges and gap.
  std::array<std::vector<Kept>, 2> kept;
  Points kept_at;                      // positions then; none are kept: no rows
  std::vector<const Kept*> asked_for;  // of a look, by place; none where nothing is asked for

  std::vector<Scratch> scratches;  // by band, in any order
  std::vector<NearPair> near;
};

}  // namespace clothsim
