#pragma once

#include "clothsim/model/cloth.h"

namespace clothsim {

/// Calls visit(run, a, b) for every spring, in the order of cloth.springs. For what is not hot.
template <typename Visitor>
void for_each_spring(const Cloth& cloth, Visitor&& visit) {
  for (const SpringRun& run : cloth.springs) {
    for (int i = 0; i < run.count; ++i) {
      visit(run, run.first + i, run.first + i + run.offset);
    }
  }
}

}  // namespace clothsim
