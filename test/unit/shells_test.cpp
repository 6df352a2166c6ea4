#include "clothsim/shapes/shells.h"

#include <gtest/gtest.h>

#include "meshes.h"

namespace clothsim::shells_test {
namespace {

using namespace test;

TriangleSoup inside_out(TriangleSoup soup) {
  for (auto& [a, b, c] : soup.triangles) std::swap(b, c);
  return soup;
}

/// Triangles of each group.
std::vector<std::size_t> split(const std::vector<TriangleSoup>& soups) {
  std::vector<std::size_t> counts;
  for (const TriangleSoup& group : split_overlapping(Solid(together(soups)))) {
    EXPECT_NO_THROW(Solid{group});
    counts.push_back(group.triangles.size());
  }
  return counts;
}

using Counts = std::vector<std::size_t>;
const TriangleSoup box = box_soup({0.1, 0.1, 0.1});  // of twelve triangles

TEST(Shells, ThatAreApartStayOneSolid) {
  EXPECT_EQ(split({box}), Counts({12}));
  EXPECT_EQ(split({box, moved(box, {0.2, 0, 0}), moved(box, {0.11, 0.11, 0})}), Counts({36}));
}

TEST(Shells, ThatOverlapTouchOrHideOneAnotherAreSolidsOfTheirOwn) {
  EXPECT_EQ(split({box, moved(box, {0.03, 0.02, 0.01})}), Counts({12, 12}));
  EXPECT_EQ(split({box, moved(box, {0.1 + 1e-8, 0.02, 0.01})}), Counts({12, 12})) << "touch";
  EXPECT_EQ(split({box_soup({0.3, 0.3, 0.3}), box}), Counts({12, 12})) << "within";
  const TriangleSoup along = box_soup({1, 0.1, 0.1}), across = box_soup({0.05, 1, 0.05});
  EXPECT_EQ(split({along, across}), Counts({12, 12})) << "no vertex of one is in the other";
}

TEST(Shells, OfAChainMakeTwoSolids) {
  std::vector<TriangleSoup> chain;
  for (int k = 0; k < 7; ++k) chain.push_back(moved(box, {0.08 * k, 0.01 * k, 0.01}));
  EXPECT_EQ(split(chain), Counts({48, 36}));
}

TEST(Shells, OfHollowsGoWithTheirSolid) {
  const TriangleSoup around = box_soup({0.3, 0.3, 0.3}), hollow = inside_out(box);
  EXPECT_EQ(split({around, hollow}), Counts({24}));
  EXPECT_EQ(split({around, hollow, moved(around, {0.25, 0.01, 0.02})}), Counts({24, 12}));
  EXPECT_EQ(split({moved(around, {0.25, 0.01, 0.02}), around, hollow}), Counts({12, 24}));
}

}  // namespace
}  // namespace clothsim::shells_test
