#include "clothsim/search/patches.h"

#include <cmath>

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

/// No two points of two patches come more nearer or farther than the bound, which is `most` at
/// most.
void expect_bound(const std::vector<Patch>& patches, const Points& from, const Points& to,
                  double most) {
  PatchMotions motions;
  motions.follow(patches, from, to);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::size_t q = 0; q < patches.size(); ++q) {
      const double bound = motions.between(static_cast<int>(p), static_cast<int>(q));
      EXPECT_LE(bound, most + 1e-12);
      for (const int i : patches[p].points) {
        for (const int j : patches[q].points) {
          const double before = (from.row(i) - from.row(j)).norm();
          const double after = (to.row(i) - to.row(j)).norm();
          EXPECT_LE(std::abs(after - before), bound + 1e-12);
        }
      }
    }
  }
}

TEST(PatchMotions, BoundEveryChangeOfDistance) {
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  ASSERT_EQ(patches.size(), 9u);
  const Points from = shaken(cloth, 0.02, 1);
  const Eigen::AngleAxisd turn(1.1, Vector3(3, 1, 2).normalized());
  const Points turned = from * turn.toRotationMatrix().transpose();
  for (const double tremble : {0.0, 0.001, 0.5}) {
    SCOPED_TRACE(tremble);
    const Points ways = random_points(cloth.num_points(), tremble, 2);
    expect_bound(patches, from, turned + ways, 20 * tremble);
    expect_bound(patches, from, from + ways, 2 * std::sqrt(3.0) * tremble);
  }
}

TEST(PatchMotions, BoundThemWhereAPatchIsSqueezedToALine) {
  const Cloth cloth = cloth_of(5, 9, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  PatchMotions motions;
  motions.follow(patches, cloth.rest_positions, line);
  double worst = 0;
  for (const int i : patches[0].points) {
    for (const int j : patches[1].points) {
      const auto distance = [&](const Points& x) { return (x.row(i) - x.row(j)).norm(); };
      worst = std::max(worst, std::abs(distance(line) - distance(cloth.rest_positions)));
    }
  }
  EXPECT_GE(motions.between(0, 1), worst);
}

}  // namespace
}  // namespace clothsim
