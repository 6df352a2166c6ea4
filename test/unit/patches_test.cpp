#include "clothsim/search/patches.h"

#include <algorithm>

#include "surface_testing.h"

namespace clothsim::patches_test {
namespace {

using namespace test;

/// At no time on straight paths has the distance between points on two patches shrunk by more than
/// the bound, which is `most` at most.
void expect_bound(const std::vector<Patch>& patches, const Points& from, const Points& to,
                  double most) {
  PatchMotions motions;
  motions.follow(patches, from, to);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::size_t q = 0; q < patches.size(); ++q) {
      const double bound = motions.between(static_cast<int>(p), static_cast<int>(q));
      EXPECT_LE(bound, most + 1e-12);
      EXPECT_LE(bound, motions.max() + 1e-12);
      for (const double time : {0.2, 0.5, 0.8, 1.0}) {
        const Points at = from + time * (to - from);
        for (const int i : patches[p].points) {
          for (const int j : patches[q].points) {
            const double before = (from.row(i) - from.row(j)).norm();
            const double after = (at.row(i) - at.row(j)).norm();
            EXPECT_GE(after, before - bound - 1e-12);
          }
        }
      }
    }
  }
}

TEST(Patches, HaveEachTileOnceAndAllOfItsCorners) {
  const Cloth cloth = cloth_of(11, 10, 0.01);
  std::vector<int> tiles(static_cast<std::size_t>(cloth.num_points()), 0);
  for (const Patch& patch : Surface(cloth).patches) {
    for (const int tile : patch.tiles) {
      if (tile == Patch::none) continue;
      ++tiles[static_cast<std::size_t>(tile)];
      for (const int corner : {0, 1, cloth.columns, cloth.columns + 1}) {
        const bool exists = (corner % cloth.columns == 0 || tile % cloth.columns < 10) &&
                            (corner < cloth.columns || tile / cloth.columns < 9);
        const auto count = std::count(patch.points.begin(), patch.points.end(), tile + corner);
        EXPECT_TRUE(!exists || count == 1) << tile << ' ' << corner;
      }
    }
  }
  EXPECT_EQ(tiles, std::vector<int>(tiles.size(), 1));
}

TEST(PatchMotions, BoundHowMuchNearerPointsComeAtAnyTime) {
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const std::vector<Patch> patches = Surface(cloth).patches;
  ASSERT_EQ(patches.size(), 9u);
  const Points from = shaken(cloth, 0.02, 1);
  // A common motion brings nothing nearer.
  const Points moved = from.rowwise() + Eigen::RowVector3d(1, -2, 3);
  for (const double tremble : {0.0, 0.001, 0.5}) {
    SCOPED_TRACE(tremble);
    const Points ways = random_points(cloth.num_points(), tremble, 2);
    expect_bound(patches, from, moved + ways, 4 * std::sqrt(3.0) * tremble + 1e-12);
  }
}

TEST(PatchMotions, BoundItWhereAPatchIsSqueezedToALineAndToAPoint) {
  const Cloth cloth = cloth_of(5, 9, 0.01);
  const std::vector<Patch> patches = Surface(cloth).patches;
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  const Points spot = Points::Zero(cloth.num_points(), 3);
  for (const auto& [from, to] : {std::pair(cloth.rest_positions, line),
                                 {line, cloth.rest_positions},
                                 {line, spot},
                                 {spot, line}}) {
    expect_bound(patches, from, to, 10);
  }
}

}  // namespace
}  // namespace clothsim::patches_test
