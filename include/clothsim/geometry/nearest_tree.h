#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/geometry/box_tree.h"

namespace clothsim {

/// Square of the distance between a box and a point, or another box [m^2]; 0 where they overlap.
inline double squared_distance(const Box& box, const Vector3& p) {
  return (box.min() - p).cwiseMax(p - box.max()).cwiseMax(0.0).squaredNorm();
}
inline double squared_distance(const Box& a, const Box& b) {
  return (a.min() - b.max()).cwiseMax(b.min() - a.max()).cwiseMax(0.0).squaredNorm();
}

/// A tree of boxes for nearest neighbour searches by branch and bound.
class NearestTree {
 public:
  /// O(n log n); each node is halved across its longest side.
  explicit NearestTree(const std::vector<Box>& boxes);

  /// Calls visit(i) with the indices of the boxes in nodes with bound(box) <= `most`, the nearer
  /// ones first. `visit` may lower `most`.
  template <class Bound, class Visit>
  void search(const Bound& bound, double& most, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::array<Waiting, deepest> stack;
    std::size_t size = 0;
    stack[size++] = {0, bound(nodes_[0].box)};
    while (size > 0) {
      const Waiting at = stack[--size];
      if (at.bound > most) continue;
      const Node& node = nodes_[at.node];
      if (node.right == 0) {
        for (int i = node.begin; i < node.end; ++i) visit(items_[static_cast<std::size_t>(i)]);
        continue;
      }
      Waiting near{at.node + 1, bound(nodes_[at.node + 1].box)};
      Waiting far{node.right, bound(nodes_[node.right].box)};
      if (far.bound < near.bound) std::swap(near, far);
      stack[size++] = far;
      stack[size++] = near;
    }
  }

 private:
  /// Each node has half the boxes of its parent: 2^32 boxes give a depth of 32.
  enum : std::size_t { deepest = 64 };

  struct Waiting {
    std::size_t node;
    double bound;
  };
  struct Node {
    Box box;
    int begin;  // its range of items_
    int end;
    std::size_t right;  // second child; the first is the next node. 0: a leaf
  };

  void build(const std::vector<Box>& boxes, int begin, int end);

  std::vector<int> items_;
  std::vector<Node> nodes_;  // parents before children
};

}  // namespace clothsim
