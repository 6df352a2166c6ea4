#include "clothsim/constraints/changed_points.h"

#include <gtest/gtest.h>

namespace clothsim::changed_points_test {
namespace {

TEST(ChangedPoints, AreThoseThatChangedByMoreThanIsAsked) {
  constexpr double least = 0.1;
  ChangedPoints changed;
  changed.mark_all(4);
  Points v = Points::Zero(4, 3);
  changed.look(0, v, least);
  EXPECT_TRUE(changed.any({0, 0, 0, 0}));
  changed.look(0, v, least);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(changed.any({i, i, i, i}));

  v(1, 2) = -0.11;
  v(2, 0) = 0.09;
  changed.look(0, v, least);
  EXPECT_TRUE(changed.any({1, 1, 1, 1}));
  EXPECT_TRUE(changed.any({0, 2, 3, 1}));
  EXPECT_FALSE(changed.any({0, 2, 3, 3}));

  v(2, 0) = 0.18;  // small changes add up
  changed.look(0, v, least);
  EXPECT_FALSE(changed.any({0, 1, 3, 3}));
  EXPECT_TRUE(changed.any({2, 2, 2, 2}));
}

TEST(ChangedPoints, AreThoseMarkedOnce) {
  ChangedPoints changed;
  changed.mark_all(5);
  const Points v = Points::Ones(5, 3);
  changed.look(0, v, 1);
  changed.mark({0, 1, 2, 2});
  changed.look(0, v, 1);
  EXPECT_TRUE(changed.any({0, 4, 4, 4}));
  EXPECT_FALSE(changed.any({3, 3, 4, 4}));
  changed.look(0, v, 1);
  EXPECT_FALSE(changed.any({0, 1, 2, 3}));
}

}  // namespace
}  // namespace clothsim::changed_points_test
