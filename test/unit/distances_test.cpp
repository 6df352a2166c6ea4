#include "clothsim/collision/distances.h"

#include <algorithm>

#include "clothsim/collision/surface_pair.h"
#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(Distances, AreThoseOfEachPair) {
  // Of any points: also of triangles and edges without extent, and of features that meet.
  const int count = 40;
  Points x = random_points(count, 1, 3);
  for (int i = 0; i < 10; ++i) x.row(i) = x.row(i + 10);               // the same twice
  for (int i = 20; i < 30; ++i) x.row(i).tail(2) = x.row(20).tail(2);  // on a line
  Distances edges(true), triangles(false);
  std::vector<SurfacePair> pairs;
  std::uint64_t random = 1;
  const auto draw = [&] {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return static_cast<int>((random >> 33) % count);
  };
  double most = 0;
  int at_ends = 0, inside = 0;
  for (Distances* distances : {&edges, &triangles}) {
    for (int round = 0; round < 20; ++round) {
      pairs.clear();
      distances->clear();
      while (distances->room() > 0) {
        const int triangle = distances == &edges ? SurfacePair::no_triangle : 0;
        pairs.push_back({triangle, {draw(), draw(), draw(), draw()}, 0});
        distances->add(pairs.back().points);
      }
      distances->measure(x);
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        const Separation s = separation(pairs[k], x);
        const double exact = s.distance;
        EXPECT_LE((*distances)[k], exact + 1e-12);
        EXPECT_GE((*distances)[k], (1 - 1e-10) * exact - 1e-6);
        most = std::max(most, exact);
        const bool apart = exact > 1e-3 && pairs[k].points[0] != pairs[k].points[1] &&
                           pairs[k].points[2] != pairs[k].points[3];
        if (distances != &edges || !apart) continue;
        const bool at_end =
            std::any_of(s.weights.begin(), s.weights.end(), [](double w) { return w == 0; });
        EXPECT_EQ(edges.at_end(k), at_end);
        ++(at_end ? at_ends : inside);
      }
    }
  }
  EXPECT_GT(most, 1);
  EXPECT_GT(at_ends, 100);
  EXPECT_GT(inside, 100);
}

}  // namespace
}  // namespace clothsim
