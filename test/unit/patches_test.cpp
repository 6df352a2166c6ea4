#include "clothsim/collision/patches.h"

#include <cmath>

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(PatchMotions, BoundEveryChangeOfDistance) {
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  ASSERT_EQ(patches.size(), 9u);
  const Points from = shaken(cloth, 0.02, 1);
  const Eigen::AngleAxisd turn(1.1, Vector3(3, 1, 2).normalized());
  const Points turned = from * turn.toRotationMatrix().transpose();
  for (const double tremble : {0.0, 0.001, 0.5}) {
    const Points to = turned + random_points(cloth.num_points(), tremble, 2);
    PatchMotions motions;
    motions.follow(patches, from, to);
    for (std::size_t p = 0; p < patches.size(); ++p) {
      for (std::size_t q = 0; q < patches.size(); ++q) {
        const double bound = motions.between(static_cast<int>(p), static_cast<int>(q));
        EXPECT_LE(bound, 20 * tremble + 1e-12);
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
