#include "clothsim/constraints/triangle_blocks.h"

#include <gtest/gtest.h>

#include <random>

#include "clothsim/model/grid.h"
#include "clothsim/shapes/face_distance.h"

namespace clothsim::triangle_blocks_test {
namespace {

/// A crumpled cloth about the origin, `columns` x `rows` points.
Cloth crumpled(int columns, int rows, unsigned seed) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  Cloth cloth = make_grid(spec, 9.81);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.02, 0.02);
  cloth.rest_positions.rowwise() -= cloth.rest_positions.colwise().mean();
  cloth.rest_positions =
      cloth.rest_positions.unaryExpr([&](double x) { return x + shift(random); });
  return cloth;
}

Triangle triangle(const Cloth& cloth, std::size_t t) {
  const auto& [a, b, c] = cloth.triangles[t];
  const Points& x = cloth.rest_positions;
  return {x.row(a), x.row(b), x.row(c)};
}

TEST(TriangleBlocks, HoldEachTriangleOnceInABoxOfItsPoints) {
  for (const auto& [columns, rows] : {std::pair(20, 13), std::pair(2, 2), std::pair(9, 3)}) {
    const Cloth cloth = crumpled(columns, rows, 1);
    TriangleBlocks blocks;
    EXPECT_FALSE(blocks.fits(cloth));
    blocks.reset(cloth);
    ASSERT_TRUE(blocks.fits(cloth));
    std::size_t next = 0;
    for (int b = 0; b < blocks.count(); ++b) {
      ASSERT_EQ(blocks.first_of(b), next);
      Eigen::AlignedBox3d expected;
      double least = 1e9;
      for (; next < blocks.end_of(b); ++next) {
        for (const Vector3& corner : triangle(cloth, next)) expected.extend(corner);
        for (const int i : cloth.triangles[next])
          least = std::min(least, cloth.rest_positions(i, 1));
      }
      const Eigen::AlignedBox3d box = blocks.box(b, cloth.rest_positions);
      EXPECT_EQ(box.min(), expected.min());
      EXPECT_EQ(box.max(), expected.max());
      EXPECT_EQ(blocks.min(b, cloth.rest_positions.col(1)), least);
    }
    EXPECT_EQ(next, cloth.triangles.size());
  }
}

TEST(TriangleBlocks, LeaveOutNoTriangleThatTouchesWithMoreThanACorner) {
  // Against the distance of each triangle; many must be left out, or the boxes have no effect.
  int touching = 0, left_out = 0, blocks_seen = 0;
  const Cloth cloth = crumpled(40, 40, 2);
  TriangleBlocks blocks;
  blocks.reset(cloth);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int turn = 0; turn < 60; ++turn) {
    for (const Shape& shape :
         {Shape(Sphere{0.1}), Shape(Capsule{0.3, 0.02}), Shape(Cuboid{{0.5, 0.3, 0.1}}),
          Shape(Cylinder{0.1, 0.25}), Shape(Cylinder{0.5, 0.1})}) {
      const Vector3 to(shift(random), shift(random), shift(random));
      Points moved = cloth.rest_positions.rowwise() + to.transpose();
      for (int b = 0; b < blocks.count(); ++b) {
        const double reach = 0.01;
        const bool may = touches_between_corners(shape, blocks.box(b, moved), reach);
        ++blocks_seen;
        left_out += !may;
        for (std::size_t t = blocks.first_of(b); t < blocks.end_of(b); ++t) {
          Triangle corners = triangle(cloth, t);
          for (Vector3& p : corners) p += to;
          const auto found = face_distance(shape, corners, reach);
          if (!found) continue;
          if (std::count(found->weights.begin(), found->weights.end(), 0.0) > 1) continue;
          ++touching;
          ASSERT_TRUE(may) << "block " << b << ", triangle " << t << ", shape " << shape.index();
        }
      }
    }
  }
  EXPECT_GT(touching, 500);
  EXPECT_GT(left_out, blocks_seen / 2);
}

}  // namespace
}  // namespace clothsim::triangle_blocks_test
