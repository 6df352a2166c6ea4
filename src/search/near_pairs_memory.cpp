// What a look goes on with.

#include <algorithm>
#include <limits>

#include "near_pairs_impl.h"

namespace clothsim {

void NearPairs::forget() {
  impl_->last.resize(0, 3);
  impl_->patch_pairs.clear();
  impl_->slots.clear();
  impl_->looks = 0;
  std::fill(impl_->is_shaped.begin(), impl_->is_shaped.end(), 0);
}

void NearPairs::write(MemoryWriter& memory) const {
  memory.add(impl_->last.rows() > 0);
  if (impl_->last.rows() == 0) return;
  memory.add(impl_->last);
  memory.add(impl_->looks);
  memory.add(impl_->paired_nearer);
  impl_->slots.write(memory);
  memory.add(static_cast<double>(impl_->patch_pairs.size()));
  for (const Impl::PatchPair& pair : impl_->patch_pairs) {
    for (const int number : {pair.p, pair.q}) memory.add(number);
    for (const double number : {pair.step, pair.to_touch, pair.to_meet}) memory.add(number);
    memory.add(static_cast<double>(pair.edges.size()));
    for (const Impl::Edges& edges : pair.edges) {
      for (const int number : {edges.a, edges.b, edges.number}) memory.add(number);
      memory.add(edges.gap);
    }
  }
}

void NearPairs::read(MemoryReader& memory) {
  forget();
  if (memory.index(2) == 0) return;
  Impl& impl = *impl_;
  const std::size_t points = impl.mesh->around_point.size(), patches = impl.patches->size();
  impl.last = memory.points(static_cast<Eigen::Index>(points));
  impl.looks = memory.index(std::numeric_limits<int>::max());
  impl.paired_nearer = memory.number();
  impl.slots.read(memory);
  for (std::size_t left = memory.count(); left > 0; --left) {
    Impl::PatchPair pair{memory.index(patches), memory.index(patches)};
    for (double* number : {&pair.step, &pair.to_touch, &pair.to_meet}) *number = memory.number();
    for (std::size_t edges = memory.count(); edges > 0; --edges) {
      const int a = memory.index(points), b = memory.index(points);
      const int number = memory.index(TileFeatures::count);
      pair.edges.push_back({a, b, number, memory.number()});
    }
    impl.patch_pairs.push_back(pair);
  }
}

}  // namespace clothsim
