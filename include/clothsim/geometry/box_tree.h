#pragma once

#include <functional>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// Axis-aligned box [m], its surface included.
using Box = Eigen::AlignedBox3d;

/// Most boxes of a leaf: few enough to test all pairs, enough to keep the tree small.
inline constexpr int max_leaves = 4;

/// The box around the points of a list with these numbers.
template <typename List>
Box around(const Points& positions, const List& points) {
  Box box;
  for (const int i : points) box.extend(row(positions, i));
  return box;
}

/// Do two boxes come within a distance of each other along every axis? Written out, as Eigen's own
/// function goes through arrays of three and takes twice the time.
inline bool overlap(const Box& p, const Box& q, double within = 0) {
  return p.min().x() - q.max().x() <= within && q.min().x() - p.max().x() <= within &&
         p.min().y() - q.max().y() <= within && q.min().y() - p.max().y() <= within &&
         p.min().z() - q.max().z() <= within && q.min().z() - p.max().z() <= within;
}

/// A tree of boxes around boxes: finds the pairs that overlap without testing all, for boxes of any
/// size. Ericson, Real-Time Collision Detection, chapter 6.
class BoxTree {
 public:
  /// O(n log n); each node is halved across its longest side.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls visit(i, j), i < j, once for each pair of boxes that overlap or touch, in no particular
  /// order.
  void visit_overlaps(const std::function<void(int, int)>& visit) const;

  /// Calls visit(i) for each box that overlaps or touches this one, in no particular order.
  void visit_overlapping(const Box& box, const std::function<void(int)>& visit) const;

 private:
  struct Leaf {
    Box box;
    int id;  // index in the boxes given
  };
  struct Node {
    Box box;
    int begin;  // its range of leaves_
    int end;
    int right;  // second child; the first is the next node. 0: a leaf
  };

  int build(int begin, int end);
  void visit_overlapping(int node, const Box& box, const std::function<void(int)>& visit) const;
  void visit_within(int node, const std::function<void(int, int)>& visit) const;
  void visit_between(int p, int q, const std::function<void(int, int)>& visit) const;

  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;  // parents before children
};

}  // namespace clothsim
