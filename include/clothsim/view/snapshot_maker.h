#pragma once

#include "clothsim/simulation/simulator.h"
#include "clothsim/view/view.h"

namespace clothsim {

/// Takes snapshots of a simulation. Unchanged parts are shared with the last snapshot, so that they
/// are not uploaded again.
class SnapshotMaker {
 public:
  Snapshot make(const Simulator&, const PreparedView&);

 private:
  const Simulator* simulator_ = nullptr;
  unsigned topology_seq_ = 0;
  std::shared_ptr<const Cloth> cloth_;
  std::shared_ptr<const Points> positions_;
};

}  // namespace clothsim
