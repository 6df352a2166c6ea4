#pragma once

#include <functional>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// Axis-aligned box [m], its surface included.
using Box = Eigen::AlignedBox3d;

/// A tree of boxes around boxes: finds those that overlap without looking at all pairs, whatever
/// their sizes. Ericson, Real-Time Collision Detection, chapter 6.
class BoxTree {
 public:
  /// O(n log n); each node is halved across its longest side.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls visit(i, j), i < j, once for each pair of boxes that overlap or touch, in no order to
  /// rely on.
  void visit_overlaps(const std::function<void(int, int)>& visit) const;

 private:
  struct Leaf {
    Box box;
    int id;  // index in the boxes given
  };
  struct Node {
    Box box;
    int begin;  // its range of leaves_
    int end;
    int right;  // second child; the first is the next node. 0: has none
  };

  int build(int begin, int end);
  void visit_within(int node, const std::function<void(int, int)>& visit) const;
  void visit_between(int p, int q, const std::function<void(int, int)>& visit) const;

  std::vector<Leaf> leaves_;
  std::vector<Node> nodes_;  // parents before children
};

}  // namespace clothsim
