#include "clothsim/render/translucency.h"

#include <algorithm>
#include <tuple>

namespace clothsim {
namespace {

struct Key {
  double depth;
  std::size_t item;
  std::size_t triangle;
};

}  // namespace

BackToFront sort_back_to_front(const std::vector<const DrawItem*>& items, const Vector3& forward) {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const DrawItem& item = *items[i];
    const Scalars depth = (*item.positions * (item.rotation.transpose() * forward)).array() +
                          item.translation.dot(forward);
    for (std::size_t k = 0; k < item.triangles->size(); ++k) {
      const std::array<int, 3>& t = (*item.triangles)[k];
      keys.push_back({(depth[t[0]] + depth[t[1]] + depth[t[2]]) / 3, i, k});
    }
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return std::tie(b.depth, a.item, a.triangle) < std::tie(a.depth, b.item, b.triangle);
  });

  BackToFront order;
  for (const Key& key : keys) {
    if (order.stretches.empty() || order.stretches.back().item != items[key.item])
      order.stretches.push_back({items[key.item], static_cast<int>(order.triangles.size()), 0});
    ++order.stretches.back().count;
    order.triangles.push_back((*items[key.item]->triangles)[key.triangle]);
  }
  return order;
}

}  // namespace clothsim
