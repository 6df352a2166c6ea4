// What a look goes on with.

#include <limits>

#include "clothsim/search/near_pairs.h"

namespace clothsim {

void NearPairs::forget() {
  last_.resize(0, 3);
  patch_pairs_.clear();
  slots_.clear();
  looks_ = 0;
}

void NearPairs::write(MemoryWriter& memory) const {
  memory.add(last_.rows() > 0);
  if (last_.rows() == 0) return;
  memory.add(last_);
  memory.add(looks_);
  memory.add(paired_nearer_);
  slots_.write(memory);
  memory.add(static_cast<double>(patch_pairs_.size()));
  for (const PatchPair& pair : patch_pairs_) {
    for (const int number : {pair.p, pair.q}) memory.add(number);
    for (const double number : {pair.step, pair.to_touch, pair.to_meet}) memory.add(number);
    memory.add(static_cast<double>(pair.edges.size()));
    for (const Edges& edges : pair.edges) {
      for (const int number : {edges.a, edges.b, edges.number}) memory.add(number);
      memory.add(edges.gap);
    }
  }
}

void NearPairs::read(MemoryReader& memory) {
  forget();
  if (memory.index(2) == 0) return;
  const std::size_t points = mesh_->around_point.size(), patches = patches_->size();
  last_ = memory.points(static_cast<Eigen::Index>(points));
  looks_ = memory.index(std::numeric_limits<int>::max());
  paired_nearer_ = memory.number();
  slots_.read(memory);
  for (std::size_t left = memory.count(); left > 0; --left) {
    PatchPair pair{memory.index(patches), memory.index(patches)};
    for (double* number : {&pair.step, &pair.to_touch, &pair.to_meet}) *number = memory.number();
    for (std::size_t edges = memory.count(); edges > 0; --edges) {
      const int a = memory.index(points), b = memory.index(points);
      const int number = memory.index(TileFeatures::count);
      pair.edges.push_back({a, b, number, memory.number()});
    }
    patch_pairs_.push_back(pair);
  }
}

}  // namespace clothsim
