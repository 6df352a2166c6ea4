#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "clothsim/geometry/surface_mesh.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"
#include "clothsim/search/surface_pair.h"

namespace clothsim {

/// A pair of features, at the positions last measured.
struct NearPair {
  std::uint64_t key;  // the same for the same features at any time
  SurfacePair pair;
  Separation separation;
};

/// Finds the pairs of a cloth's features that are near each other while it moves.
///
/// While it hardly moves within itself, pairs found once serve as long as no other may be asked
/// for. Otherwise the cloth is cut into patches of some cells. Two patches, and two cells of them,
/// sleep until the patches may have come so much nearer to each other as there was between them
/// when last looked at. What is found depends on the arguments alone.
class NearPairs {
 public:
  explicit NearPairs(const Cloth&);
  ~NearPairs();
  NearPairs(const NearPairs&);
  NearPairs(NearPairs&&) noexcept;
  NearPairs& operator=(NearPairs) noexcept;

  /// Pairs at `positions` that may touch on the way to `ahead` [m, N x 3, finite], by ascending
  /// key. All that are within the nearest they may come plus least_margin() are among them, and
  /// none that is further than that plus margin(). Edges that are closest at an end of one are left
  /// out: there its point is as near. Some are missing where the budget is spent.
  const std::vector<NearPair>& approaching(const Cloth&, const Points& positions,
                                           const Points& ahead, const Workers& = {},
                                           WorkBudget* = nullptr);

  /// Pairs within a `distance` [m], up to reach(), of each other at `positions`, by ascending key.
  /// Some are missing where the budget is spent.
  const std::vector<NearPair>& within(const Cloth&, const Points& positions, double distance,
                                      const Workers& = {}, WorkBudget* = nullptr);

  /// How far features that approach each other are looked at: however slowly, and at most [m].
  double least_margin() const;
  double margin() const;
  /// Nearest that any pair may come [m].
  double least_nearest() const;
  double reach() const { return least_nearest() + margin(); }
  const SurfaceMesh& mesh() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
