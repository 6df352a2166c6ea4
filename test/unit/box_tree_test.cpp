// Overlapping boxes from the tree: exactly those of a check of all pairs, each once.

#include "clothsim/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace clothsim::box_tree_test {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

Pairs by_tree(const std::vector<Box>& boxes) {
  Pairs pairs;
  BoxTree(boxes).visit_overlaps([&](int i, int j) { pairs.emplace_back(i, j); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs by_queries(const std::vector<Box>& boxes) {
  Pairs pairs;
  const BoxTree tree(boxes);
  for (int i = 0; i < static_cast<int>(boxes.size()); ++i) {
    tree.visit_overlapping(boxes[static_cast<std::size_t>(i)], [&](int j) {
      if (i < j) pairs.emplace_back(i, j);
    });
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs by_all_pairs(const std::vector<Box>& boxes) {
  Pairs pairs;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      if (boxes[i].intersects(boxes[j])) {
        pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
      }
    }
  }
  return pairs;
}

TEST(BoxTree, FindsWhatAllPairsFind) {
  std::mt19937_64 random(1);
  const auto unit = [&random] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (const int n : {0, 1, 2, 4, 5, 6, 100, 500}) {
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<Box> boxes;
      for (int i = 0; i < n; ++i) {
        // Random sizes, from nothing to the whole range.
        const double size = std::pow(unit(), 4);
        const Vector3 corner(unit(), unit(), unit());
        boxes.emplace_back(corner, corner + size * Vector3(unit(), unit(), unit()));
      }
      ASSERT_EQ(by_tree(boxes), by_all_pairs(boxes)) << n;
      ASSERT_EQ(by_queries(boxes), by_all_pairs(boxes)) << n;
    }
  }
}

TEST(BoxTree, TouchingIsOverlapping) {
  // Unit cubes side by side in a row: each touches the next.
  std::vector<Box> boxes;
  for (int i = 0; i < 20; ++i) boxes.emplace_back(Vector3(i, 0, 0), Vector3(i + 1, 1, 1));
  EXPECT_EQ(by_tree(boxes).size(), 19u);
  EXPECT_EQ(by_tree(boxes), by_all_pairs(boxes));
}

TEST(BoxTree, TakesBoxesThatAreAllAlike) {
  const std::vector<Box> points(50, Box(Vector3(1, 2, 3), Vector3(1, 2, 3)));
  EXPECT_EQ(by_tree(points).size(), 50u * 49 / 2);
}

}  // namespace
}  // namespace clothsim::box_tree_test
