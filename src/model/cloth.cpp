#include "clothsim/model/cloth.h"

namespace clothsim {

int Cloth::num_springs() const {
  int count = 0;
  for (const SpringRun& run : springs) count += run.count;
  return count;
}

}  // namespace clothsim
