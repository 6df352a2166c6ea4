#include "clothsim/geometry/nearest_tree.h"

#include <algorithm>
#include <numeric>

namespace clothsim {

NearestTree::NearestTree(const std::vector<Box>& boxes) : items_(boxes.size()) {
  std::iota(items_.begin(), items_.end(), 0);
  nodes_.reserve(boxes.size());
  if (!boxes.empty()) build(boxes, 0, static_cast<int>(boxes.size()));
}

void NearestTree::build(const std::vector<Box>& boxes, int begin, int end) {
  const auto box_of = [&](int item) -> const Box& { return boxes[static_cast<std::size_t>(item)]; };
  const std::size_t node = nodes_.size();
  nodes_.push_back({{}, begin, end, 0});
  Box centers;
  for (int i = begin; i < end; ++i) {
    const Box& box = box_of(items_[static_cast<std::size_t>(i)]);
    nodes_[node].box.extend(box);
    centers.extend(box.center());
  }
  if (end - begin <= max_leaves) return;
  Eigen::Index axis = 0;
  centers.sizes().maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                   [&](int a, int b) {
                     const double of_a = box_of(a).center()[axis], of_b = box_of(b).center()[axis];
                     return of_a < of_b || (of_a == of_b && a < b);
                   });
  build(boxes, begin, middle);
  nodes_[node].right = nodes_.size();
  build(boxes, middle, end);
}

}  // namespace clothsim
