#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/model/workers.h"

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
/// point does are listed. These may be found a little late, and are few.
///
/// What may meet: all features that come as near as a floor on the way. None is missed.
///
/// The cloth is cut into patches. Two of them are measured against each other, and then sleep until
/// they have used up what was between them. So what is found depends on what came before: see
/// write().
class NearPairs {
 public:
  explicit NearPairs(const Cloth&);
  ~NearPairs();
  NearPairs(const NearPairs&);
  NearPairs(NearPairs&&) noexcept;
  NearPairs& operator=(NearPairs) noexcept;

  /// Pairs at `positions` that may touch on the way to `ahead` [m, N x 3, finite], or are nearer
  /// than they may come plus a margin, by ascending key. Edges are closest inside both, and of the
  /// triangles that a point is as near to there is one. Some are missing where the budget is spent.
  const std::vector<NearPair>& approaching(const Points& positions, const Points& ahead,
                                           const Workers& = {}, WorkBudget* = nullptr);

  /// All pairs that may come within `floor` [m] of each other while points go straight from `here`
  /// to `ends`, in no order to rely on: as long as no distance between patches falls by more than
  /// sees(). Some are missing where the budget is spent.
  std::vector<NearPair> may_meet(const Points& here, const Points& ends, double floor,
                                 const Workers& = {}, WorkBudget* = nullptr);

  /// Points have gone to the ends that it looked at last.
  void go(const Points& ends, const Workers& = {});

  /// Forgets all that came before.
  void forget();

  /// How much nearer any two points come on the ways that may_meet() looked at last, at most [m].
  double most_nearer() const;
  double sees() const;

  /// Nearest that any pair may come [m].
  double least_nearest() const;

  /// What the next look goes on with. `read` throws InvalidValue for what was not written.
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
