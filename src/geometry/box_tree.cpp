#include "clothsim/geometry/box_tree.h"

#include <algorithm>

namespace clothsim {

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  leaves_.reserve(boxes.size());
  for (const Box& box : boxes) leaves_.push_back({box, static_cast<int>(leaves_.size())});
  nodes_.reserve(boxes.size());
  if (!boxes.empty()) build(0, static_cast<int>(boxes.size()));
}

int BoxTree::build(int begin, int end) {
  const int node = static_cast<int>(nodes_.size());
  Box box;
  for (int i = begin; i < end; ++i) box.extend(leaves_[static_cast<std::size_t>(i)].box);
  nodes_.push_back({box, begin, end, 0});
  if (end - begin <= max_leaves) return node;

  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  const auto twice_centre = [axis](const Leaf& leaf) {
    return leaf.box.min()[axis] + leaf.box.max()[axis];
  };
  std::nth_element(leaves_.begin() + begin, leaves_.begin() + middle, leaves_.begin() + end,
                   [&](const Leaf& p, const Leaf& q) { return twice_centre(p) < twice_centre(q); });
  build(begin, middle);
  const int right = build(middle, end);
  nodes_[static_cast<std::size_t>(node)].right = right;
  return node;
}

void BoxTree::visit_overlaps(const std::function<void(int, int)>& visit) const {
  if (!nodes_.empty()) visit_within(0, visit);
}

void BoxTree::visit_overlapping(const Box& box, const std::function<void(int)>& visit) const {
  if (!nodes_.empty()) visit_overlapping(0, box, visit);
}

void BoxTree::visit_overlapping(int node, const Box& box,
                                const std::function<void(int)>& visit) const {
  const Node& n = nodes_[static_cast<std::size_t>(node)];
  if (!overlap(n.box, box)) return;
  if (n.right != 0) {
    visit_overlapping(node + 1, box, visit);
    visit_overlapping(n.right, box, visit);
    return;
  }
  for (int i = n.begin; i < n.end; ++i) {
    const Leaf& leaf = leaves_[static_cast<std::size_t>(i)];
    if (overlap(leaf.box, box)) visit(leaf.id);
  }
}

void BoxTree::visit_within(int node, const std::function<void(int, int)>& visit) const {
  const Node& n = nodes_[static_cast<std::size_t>(node)];
  if (n.right != 0) {
    visit_within(node + 1, visit);
    visit_within(n.right, visit);
    visit_between(node + 1, n.right, visit);
    return;
  }
  for (int i = n.begin; i < n.end; ++i) {
    const Leaf& p = leaves_[static_cast<std::size_t>(i)];
    for (int j = i + 1; j < n.end; ++j) {
      const Leaf& q = leaves_[static_cast<std::size_t>(j)];
      if (overlap(p.box, q.box)) visit(std::min(p.id, q.id), std::max(p.id, q.id));
    }
  }
}

void BoxTree::visit_between(int p, int q, const std::function<void(int, int)>& visit) const {
  const Node& n = nodes_[static_cast<std::size_t>(p)];
  const Node& m = nodes_[static_cast<std::size_t>(q)];
  if (!overlap(n.box, m.box)) return;

  // Descend into the node with more boxes.
  if (n.right != 0 && (m.right == 0 || n.end - n.begin >= m.end - m.begin)) {
    visit_between(p + 1, q, visit);
    visit_between(n.right, q, visit);
    return;
  }
  if (m.right != 0) {
    visit_between(p, q + 1, visit);
    visit_between(p, m.right, visit);
    return;
  }
  for (int i = n.begin; i < n.end; ++i) {
    const Leaf& a = leaves_[static_cast<std::size_t>(i)];
    if (!overlap(a.box, m.box)) continue;
    for (int j = m.begin; j < m.end; ++j) {
      const Leaf& b = leaves_[static_cast<std::size_t>(j)];
      if (overlap(a.box, b.box)) visit(std::min(a.id, b.id), std::max(a.id, b.id));
    }
  }
}

}  // namespace clothsim
