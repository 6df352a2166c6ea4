// What a look goes on with.

#include <limits>
#include <numeric>

#include "near_pairs_impl.h"

namespace clothsim {

void NearPairs::forget() {
  impl_->last.resize(0, 3);
  impl_->patch_pairs.clear();
  impl_->edges.clear();
  impl_->slots.clear();
  impl_->looks = 0;
}

void NearPairs::write(MemoryWriter& memory) const {
  memory.add(impl_->last.rows() > 0);
  if (impl_->last.rows() == 0) return;
  memory.add(impl_->last);
  memory.add(impl_->looks);
  memory.add(impl_->has_gone);
  memory.add(impl_->paired_nearer);
  impl_->slots.write(memory);
  memory.add(static_cast<double>(impl_->patch_pairs.size()));
  for (const Impl::PatchPair& pair : impl_->patch_pairs) {
    for (const double number : {static_cast<double>(pair.p), static_cast<double>(pair.q),
                                pair.nearer, pair.step, pair.to_touch, pair.to_meet}) {
      memory.add(number);
    }
  }
  memory.add(static_cast<double>(impl_->edges.size()));
  for (const Impl::Edges& edges : impl_->edges) {
    for (const int number : {edges.pair, edges.a, edges.b, edges.number}) memory.add(number);
    memory.add(edges.gap);
  }
}

void NearPairs::read(MemoryReader& memory) {
  forget();
  if (memory.index(2) == 0) return;
  Impl& impl = *impl_;
  const std::size_t points = impl.mesh->around_point.size(), patches = impl.patches->size();
  impl.last = memory.points(static_cast<Eigen::Index>(points));
  impl.is_shaped.assign(patches, 0);
  impl.looks = memory.index(std::numeric_limits<int>::max());
  impl.has_gone = memory.index(2) == 1;
  impl.paired_nearer = memory.number();
  impl.slots.read(memory);
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int p = memory.index(patches), q = memory.index(patches);
    Impl::PatchPair pair{p, q, impl.are_neighbours(p, q)};
    for (double* number : {&pair.nearer, &pair.step, &pair.to_touch, &pair.to_meet}) {
      *number = memory.number();
    }
    impl.patch_pairs.push_back(pair);
  }
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int pair = memory.index(impl.patch_pairs.size());
    const int a = memory.index(points), b = memory.index(points);
    const int number = memory.index(TileFeatures::count);
    impl.edges.push_back({pair, a, b, number, memory.number()});
  }
  impl.soon.resize(impl.patch_pairs.size());
  std::iota(impl.soon.begin(), impl.soon.end(), 0);
}

}  // namespace clothsim
