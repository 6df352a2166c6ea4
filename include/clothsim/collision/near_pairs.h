#pragma once

#include <cstdint>
#include <vector>

#include "clothsim/collision/box_tree.h"
#include "clothsim/collision/nearest_distances.h"
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
/// A pair is near while its distance is within the nearest they may come (see NearestDistances)
/// plus margin().
///
/// The cloth is cut into patches. Of two patches, pairs are sought again only when the patches may
/// have come so much nearer to each other as the search had to spare, and a pair is measured
/// only when the same may have brought it near. What is found depends on the positions alone.
class NearPairs {
 public:
  explicit NearPairs(const Cloth&);

  /// All near pairs at `positions` [m, N x 3, finite], by ascending key. Valid until the next call.
  const std::vector<NearPair>& measure(const Cloth&, const Points& positions);

  /// The last measure().
  const std::vector<NearPair>& pairs() const { return near_; }

  double margin() const { return margin_; }
  /// Nearest that any pair may come [m].
  double least_nearest() const { return nearest_.least(); }
  const SurfaceMesh& mesh() const { return mesh_; }

 private:
  struct Candidate {
    std::uint64_t key;
    SurfacePair pair;
    Vector3 direction;  // of the normal when it was measured last
  };

  /// Two patches, or one with itself.
  struct PatchPair {
    int p;
    int q;
    double moved;      // how much nearer they may have come since candidates were sought [m]
    double allowance;  // candidates serve while they have moved by less [m]
    std::vector<Candidate> candidates;
    std::vector<double> wake_at;  // moved from which on the candidate may be near
  };

  /// A rectangle of cells.
  struct Patch {
    std::vector<int> cells;
    std::vector<int> points;  // of the cells, borders too
    Vector3 way{0, 0, 0};     // mean of the points since the last measure() [m]
    double deviation = 0;     // farthest of a point from that [m]
  };

  void cut_into_patches(const Cloth&);
  void follow(const Points& positions);
  void pair_patches(double reach);
  void bound(const Cloth&, const Points& positions);
  void seek(const Cloth&, const Points& positions, PatchPair&) const;
  void seek_in_cells(const Points& positions, int cell, int other, double range, std::uint64_t key,
                     std::vector<Candidate>&) const;
  bool proved_apart(int cell, int other, double range) const;

  SurfaceMesh mesh_;
  NearestDistances nearest_;
  double spacing_;              // shorter one at rest [m]
  double least_rest_distance_;  // of two features that share no point [m]
  double margin_;

  std::vector<Patch> patches_;
  std::vector<PatchPair> patch_pairs_;  // by p, then q
  Points last_;                         // positions last measured; none yet: no rows
  double spread_ = 0;                   // farthest way of a point, beyond the common one, since
                                        // patches were paired [m]
  std::vector<NearPair> near_;

  // Scratch of one measure().
  std::vector<Box> patch_boxes_;
  std::vector<Box> cell_boxes_;
  std::vector<GradientBounds> gradients_;  // by cell
};

}  // namespace clothsim
