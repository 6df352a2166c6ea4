#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/search/near_pairs.h"
#include "clothsim/search/nearest_distances.h"
#include "clothsim/search/patches.h"
#include "clothsim/search/surface_slots.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

struct NearPairs::Impl {
  using TileFeatureRows = std::array<TileShapes::Row, TileFeatures::count>;

  /// Two edges that are near, by tiles and the number of the pair among their features.
  struct Edges {
    int pair;  // of patches
    int a;
    int b;
    int number;
    double gap;  // when they were measured [m]
  };

  /// Two patches, or one with itself.
  struct PatchPair {
    int p;
    int q;
    bool are_neighbours;  // on the cloth
    double nearer = 0;    // that they may have come since they were measured, but for step [m]
    double step = 0;      // that they may come on the way looked at last [m]
    // By how much they may come nearer before features touch that have no slot, or any meet [m].
    double to_touch = 0;
    double to_meet = 0;
  };

  /// What is found of a band of patch pairs.
  struct Scratch {
    int band = -1;  // first patch pair
    TileShapes::Near tiles;
    TileShapes::Distances distances;
    std::vector<SurfaceSlots::Proposal> proposals;
    std::vector<NearPair> found;
    std::vector<Edges> edges;
  };

  explicit Impl(const Cloth&);

  /// Farther than anything [m].
  static constexpr double unbounded = 1e9;

  // near_pairs.cpp: patches, and when they are measured.
  double sees() const;
  bool are_neighbours(int p, int q) const;
  void fill_nearest();
  void pair_patches(const Points& positions);
  template <typename IsDropped>
  void drop_edges(const IsDropped&);
  void foresee(const Points& ends, double floor, const Workers&);
  void arrive(const Points& ends);
  void be_at(const Points& positions, const Workers&);
  /// What two have come nearer so far [m].
  double moved(const PatchPair& pair) const { return pair.nearer + (has_gone ? pair.step : 0); }
  bool is_due(const PatchPair& pair) const { return moved(pair) + pair.step > pair.to_touch; }
  void shape(const std::vector<int>& due, const Workers&);
  template <typename Within>
  std::vector<NearPair> measure_all(const std::vector<int>& due, const Within& within,
                                    const Workers&, WorkBudget*);
  bool may_touch(const SurfacePair&, const Separation&, const Points& ahead) const;
  void collect_points(const Points& ahead, const Workers&);
  void collect_edges(const Points& ahead);
  static std::uint64_t edge_key(const Edges&);

  // near_pairs_measure.cpp: what two patches have near each other.
  void measure(int pair, double within, Scratch&);
  struct Batch;
  void measure_batch(int pair, Batch&, double within, Scratch&);
  void prepare(const PatchPair&, Batch&) const;
  std::array<int, 2> patch_way(const PatchPair&) const;
  const TileShapes::PairValues& nearest_of(const PatchPair&) const;

  int columns;
  std::shared_ptr<const SurfaceMesh> mesh;
  std::shared_ptr<const NearestDistances> nearest;
  std::shared_ptr<const std::vector<Patch>> patches;  // along rows
  int patch_columns;
  TileFeatures features;
  TileShapes shapes;
  SurfaceSlots slots;
  // Nearest that any features of two tiles may come [m], and of neighbours, by the way from patch
  // to patch, near_patches at most.
  TileShapes::PairValues nearest_far;
  TileFeatureRows far_rows;  // of features inside the cloth
  int near_patches = 0;
  std::vector<TileShapes::PairValues> nearest_of_tiles;
  double spacing;  // shorter one at rest [m]
  double margin;   // [m]

  std::vector<PatchPair> patch_pairs;  // by p, then q
  std::vector<Edges> edges;
  std::vector<int> soon, now;  // pairs that may be due in the next look, and for what meets
  double paired_nearer = 0;    // that any two may have come since they were paired [m]
  int looks = 0;
  Points last;            // positions last given; none yet: no rows
  bool has_gone = false;  // the way looked at last
  PatchMotions motions;
  std::vector<char> is_shaped;  // by patch, at `last`

  std::vector<Scratch> scratches;  // by band, in any order
  std::vector<NearPair> near;
};

}  // namespace clothsim
