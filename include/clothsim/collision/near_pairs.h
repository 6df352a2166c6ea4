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
                                           const Points& ahead);

  /// Pairs within a `distance` [m], up to reach(), of each other at `positions`, by ascending key.
  const std::vector<NearPair>& within(const Cloth&, const Points& positions, double distance);

  double margin() const { return margin_; }
  double least_margin() const { return least_margin_share * margin_; }
  /// Nearest that any pair may come [m].
  double least_nearest() const { return nearest_.least(); }
  double reach() const { return least_nearest() + margin_; }
  const SurfaceMesh& mesh() const { return mesh_; }

 private:
  /// Pairs are looked at from this share of the margin on, however slowly they approach.
  static constexpr double least_margin_share = 0.1;

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
    double least_wake;     // of all candidates
    double least_nearest;  // of all candidates [m]
    std::vector<Candidate> candidates;
    std::vector<double> wake_at;  // moved from which on the candidate may be nearest
  };

  /// Of a cell, at `positions` of the last search.
  struct CellBounds {
    long search = 0;
    Box box;
    GradientBounds gradient;
  };

  void advance(const Cloth&, const Points& positions);
  void pair_patches(const Points& positions, double reach);
  void seek(const Cloth&, const Points& positions, PatchPair&);
  void seek_in_cells(const Points& positions, int cell, int other, double within, PatchPair&,
                     std::uint64_t key);
  void take_candidates(const Points& positions);
  const CellBounds& bound(const Cloth&, const Points& positions, int cell);
  bool proved_apart(const Cloth&, const Points& positions, int cell, int other, double range);
  template <typename Reach>
  void wake(const Points& positions, PatchPair&, const Reach& reach);
  void measure_awake(const Points& positions);

  SurfaceMesh mesh_;
  NearestDistances nearest_;
  double spacing_;              // shorter one at rest [m]
  double least_rest_distance_;  // of two features that share no point [m]
  double margin_;

  std::vector<Patch> patches_;
  std::vector<PatchPair> patch_pairs_;  // by p, then q
  Points last_;                         // positions last given; none yet: no rows
  Points paired_at_;                    // positions where patches were paired
  PatchMotions motions_;
  std::vector<NearPair> near_;

  long search_ = 0;                 // counts positions
  std::vector<CellBounds> bounds_;  // by cell

  // Scratch: what is measured at once.
  struct Sought {
    PatchPair* of;
    Candidate candidate;
  };
  struct Awake {
    PatchPair* of;
    std::size_t number;  // of the candidate
    double reach;        // see wake()
  };
  std::vector<Sought> sought_;
  std::vector<Awake> awake_;
  Distances distances_;
};

}  // namespace clothsim
