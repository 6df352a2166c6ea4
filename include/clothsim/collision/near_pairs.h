#pragma once

#include <cstdint>
#include <vector>

#include "clothsim/collision/box_tree.h"
#include "clothsim/collision/distances.h"
#include "clothsim/collision/nearest_distances.h"
#include "clothsim/collision/patches.h"
#include "clothsim/collision/surface_mesh.h"
#include "clothsim/collision/surface_pair.h"
#include "clothsim/collision/unfolded.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/workers.h"

namespace clothsim {

/// A pair of features, at the positions last measured.
struct NearPair {
  std::uint64_t key;  // the same for the same features at any time
  SurfacePair pair;
  Separation separation;
};

/// Keeps the pairs of a cloth's features that are near each other while it moves.
///
/// The cloth is cut into patches. Of two patches, pairs are sought again only when the patches may
/// have come so much nearer to each other as the search had to spare, and a pair is measured
/// only when the same may have brought it near. What is found depends on the arguments alone.
class NearPairs {
 public:
  explicit NearPairs(const Cloth&);

  /// Pairs at `positions` that may touch on the way to `ahead` [m, N x 3, finite], by ascending
  /// key. Of two features these are within the nearest they may come plus what their patches'
  /// motion against each other can close, between least_margin() and margin().
  const std::vector<NearPair>& approaching(const Cloth&, const Points& positions,
                                           const Points& ahead, const Workers& = {});

  /// Pairs within a `distance` [m], up to reach(), of each other at `positions`, by ascending key.
  const std::vector<NearPair>& within(const Cloth&, const Points& positions, double distance,
                                      const Workers& = {});

  double margin() const { return margin_; }
  double least_margin() const { return least_margin_share * margin_; }
  /// Nearest that any pair may come [m].
  double least_nearest() const { return nearest_.least(); }
  double reach() const { return least_nearest() + margin_; }
  const SurfaceMesh& mesh() const { return mesh_; }

 private:
  /// Pairs are looked at from this share of the margin on, however slowly they approach.
  static constexpr double least_margin_share = 0.1;
  /// Cells along the side of a patch.
  static constexpr int patch_cells = 4;

  struct Candidate {
    std::uint64_t key;
    SurfacePair pair;
  };

  /// Two patches, or one with itself.
  struct PatchPair {
    int p;
    int q;
    double moved;          // how much nearer they may have come since candidates were sought [m]
    double allowance;      // candidates serve while they have moved by less [m]
    bool is_sought;        // anew, now
    double least_wake;     // of all candidates
    double least_nearest;  // of all candidates [m]
    std::vector<Candidate> candidates;
    std::vector<double> wake_at;  // moved from which on the candidate may be nearest
  };

  /// Of a cell, at `positions` of the last search.
  struct CellBounds {
    Box box;
    GradientBounds gradient;
  };

  struct Sought {
    PatchPair* of;
    Candidate candidate;
  };
  struct Awake {
    PatchPair* of;
    std::size_t number;  // of the candidate
    double reach;        // see wake()
  };
  /// What one thread measures.
  struct Scratch {
    int band;  // first patch pair
    std::vector<Sought> sought;
    std::vector<Awake> awake;
    Distances distances;
    std::vector<NearPair> near;
  };

  template <typename Body, typename Finish>
  void share_patch_pairs(const Workers&, const Body&, const Finish&);

  void advance(const Cloth&, const Points& positions, const Workers&);
  void pair_patches(const Points& positions, double reach);
  bool are_neighbours(const PatchPair&) const;
  bool is_to_be_sought(const Points& positions, PatchPair&) const;
  void bound_cells(const Cloth&, const Points& positions, const Workers&);
  void seek(const Points& positions, PatchPair&, Scratch&) const;
  void seek_in_cells(const Points& positions, int cell, int other, double within, PatchPair&,
                     std::uint64_t key, Scratch&) const;
  void take_candidates(const Points& positions, Scratch&) const;
  bool proved_apart(int cell, int other, double range) const;
  template <typename Reach>
  void wake(const Points& positions, PatchPair&, const Reach& reach, Scratch&) const;
  void measure_awake(const Points& positions, Scratch&) const;
  const std::vector<NearPair>& collect();

  SurfaceMesh mesh_;
  NearestDistances nearest_;
  double spacing_;              // shorter one at rest [m]
  double least_rest_distance_;  // of two features that share no point [m]
  double contact_;              // distance, of layers [m]
  double margin_;

  std::vector<Patch> patches_;
  std::vector<PatchPair> patch_pairs_;  // by p, then q
  Points last_;                         // positions last given; none yet: no rows
  Points paired_at_;                    // positions where patches were paired
  PatchMotions motions_;
  std::vector<NearPair> near_;

  std::vector<CellBounds> bounds_;  // by cell
  std::vector<int> bounded_;        // cells of the last search
  std::vector<char> is_bounded_;    // by cell
  std::vector<Scratch> scratches_;  // by thread
};

}  // namespace clothsim
