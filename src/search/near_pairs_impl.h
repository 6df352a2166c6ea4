#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>

#include "clothsim/search/near_pairs.h"
#include "clothsim/search/nearest_distances.h"
#include "clothsim/search/patches.h"
#include "clothsim/search/surface_slots.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

struct NearPairs::Impl {
  /// Two edges that are near, by tiles and the number of the pair among their features.
  struct Edges {
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
    std::vector<Edges> edges = {};  // that points may not keep apart

    bool operator<(const PatchPair& other) const {
      return std::tie(p, q) < std::tie(other.p, other.q);
    }
  };

  /// What is found of a band of patch pairs.
  struct Found {
    std::vector<SurfaceSlots::Proposal> proposals;
    std::vector<NearPair> meet;
  };

  explicit Impl(const Cloth&);

  // near_pairs.cpp: patches, and when they are measured.
  void pair_patches(const Points& positions);
  void foresee(const Points& ends, const Workers&);
  void arrive(const Points& ends, const Workers&);
  void be_at(const Points& positions, const Workers&);
  void shape(const std::vector<int>& due, const Workers&);
  std::vector<NearPair> measure_all(const std::vector<int>& due, double floor, const Workers&,
                                    WorkBudget*);
  bool may_touch(const SurfacePair&, const Separation&, const Points& ahead) const;
  void collect_points(const Points& ahead, const Workers&);
  void collect_edges(const Points& ahead, const Workers&);

  // near_pairs_measure.cpp: what two patches have near each other.
  void measure(PatchPair&, double within, Found&) const;
  void measure_batch(PatchPair&, const int* pairs, std::size_t count, double within, Found&) const;
  void propose(const SurfacePair&, float distance, float may, Found&) const;

  std::shared_ptr<const SurfaceMesh> mesh;
  std::shared_ptr<const NearestDistances> nearest;
  std::shared_ptr<const std::vector<Patch>> patches;  // along rows
  TileFeatures features;
  TileShapes shapes;
  SurfaceSlots slots;
  double sees;    // how much nearer patches may come before they are paired anew [m]
  double paired;  // patches are from so far on [m]
  double margin;  // [m]

  std::vector<PatchPair> patch_pairs;  // ascending
  double paired_nearer = 0;            // that any two may have come since they were paired [m]
  int looks = 0;
  Points last;  // positions last given; none yet: no rows
  PatchMotions motions;
  std::vector<char> is_shaped;  // by patch, at `last`
  std::vector<NearPair> near;
};

/// The same for the same features at any time.
std::uint64_t key_of(const SurfacePair&, int a, int b, std::size_t number);

}  // namespace clothsim
