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
    const auto& [first_point, points] = item.own_points;
    const Scalars depth =
        (item.positions->middleRows(first_point, points) * (item.rotation.transpose() * forward))
            .array() +
        item.translation.dot(forward);
    const auto& [first, count] = item.own_triangles;
    for (int k = first; k < first + count; ++k) {
      double sum = 0;
      for (const int corner : (*item.triangles)[static_cast<std::size_t>(k)]) {
        sum += depth[corner - first_point];
      }
      keys.push_back({sum / 3, i, static_cast<std::size_t>(k)});
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
