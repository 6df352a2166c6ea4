#include "clothsim/search/tiles.h"

#include "surface_testing.h"

namespace clothsim::tiles_test {
namespace {

using namespace test;

/// Tiles of patches at given positions.
struct Shapes {
  Shapes(const Surface& surface, const Points& x)
      : patches(surface.patches),
        tiling(surface.tiling),
        shapes(tiling, std::make_shared<std::vector<Patch>>(patches)) {
    for (int p = 0; p < static_cast<int>(patches.size()); ++p) shapes.update(p, x);
  }
  int tile(int patch, std::size_t k) const {
    return patches[static_cast<std::size_t>(patch)].tiles[k];
  }

  std::vector<Patch> patches;
  std::shared_ptr<const Tiling> tiling;
  TileShapes shapes;
};

TEST(TileShapes, AreNeverFartherThanTheyAre) {
  const Cloth cloth = cloth_of(10, 9, 0.01);
  const Surface surface(cloth);
  const auto lacks = [&](int tile, std::size_t own) {
    return surface.tiling->at(tile).own[own] == Tiling::lacking;
  };
  Points needles = random_points(cloth.num_points(), 0.1, 5);
  needles.col(1) *= 1e-4;
  needles.col(2) *= 1e-6;
  Points line = cloth.rest_positions;
  line.rightCols(2).setZero();
  const std::vector<Points> all{cloth.rest_positions,
                                shaken(cloth, 0.05, 1),
                                random_points(cloth.num_points(), 0.2, 2),
                                needles,
                                line,
                                Points::Zero(cloth.num_points(), 3)};
  for (std::size_t shape = 0; shape < all.size(); ++shape) {
    const Points& x = all[shape];
    const Shapes of(cloth, x);
    double closest = 0;
    int compared = 0;
    for (int p = 0; p < static_cast<int>(of.patches.size()); ++p) {
      for (int q = p; q < static_cast<int>(of.patches.size()); ++q) {
        TileShapes::PairValues nearest;
        nearest.fill(1e6F);
        TileShapes::Near near;
        of.shapes.look(p, q, nearest, 0, 0, near);
        for (std::size_t first = 0; first < near.count; first += TileShapes::tiles) {
          const std::size_t count = std::min(near.count - first, TileShapes::tiles);
          TileShapes::Distances found;
          of.shapes.measure(p, q, near.pairs.data() + first, count, found);
          for (std::size_t i = 0; i < count; ++i) {
            const auto pair = static_cast<std::size_t>(near.pairs[first + i]);
            const int a = of.tile(p, pair / TileShapes::tiles),
                      b = of.tile(q, pair % TileShapes::tiles);
            for (std::size_t k = 0; k < Tiling::own_points; ++k) {
              if (lacks(a, Tiling::of_a[k]) || lacks(b, Tiling::of_b[k])) continue;
              const double exact = separation(of.tiling->pair(a, b, k), x).distance;
              const double told = found.values[k][i] - of.shapes.rounding(p, q);
              ASSERT_LE(told, exact) << shape << ' ' << k;
              closest = std::max(closest, exact - told);
              ++compared;
            }
          }
        }
      }
    }
    EXPECT_GT(compared, 20000);
    if (shape < 3) {
      EXPECT_LT(closest, 3e-3) << shape;  // a slight turn of edges of 0.2 m
    }
  }
}

TEST(TileShapes, LookPastNoTileThatIsNear) {
  const Cloth cloth = cloth_of(10, 9, 0.01);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Points x = shaken(cloth, 0.02 * static_cast<double>(seed), seed);
    const Shapes of(cloth, x);
    for (int p = 0; p < static_cast<int>(of.patches.size()); ++p) {
      for (int q = p; q < static_cast<int>(of.patches.size()); ++q) {
        TileShapes::PairValues nearest;
        nearest.fill(0.1F);
        TileShapes::Near near;
        of.shapes.look(p, q, nearest, 0.05F, 0.05F, near);
        std::vector<bool> is_near(TileShapes::tiles * TileShapes::tiles, false);
        for (std::size_t k = 0; k < near.count; ++k) {
          is_near[static_cast<std::size_t>(near.pairs[k])] = true;
        }
        double rest = TileShapes::infinity;
        for (std::size_t k = 0; k < is_near.size(); ++k) {
          const int a = of.tile(p, k / TileShapes::tiles), b = of.tile(q, k % TileShapes::tiles);
          const bool counts = p != q || k / TileShapes::tiles < k % TileShapes::tiles;
          if (a == Patch::none || b == Patch::none || !counts) {
            EXPECT_FALSE(is_near[k]);
            continue;
          }
          if (is_near[k]) continue;
          for (const std::size_t c : {0u, 1u, 2u, 3u}) {
            const auto corner = [&](int tile, std::size_t number) {
              return of.tiling->at(tile).points[number];
            };
            for (const std::size_t d : {0u, 1u, 2u, 3u}) {
              rest = std::min(rest, (x.row(corner(a, c)) - x.row(corner(b, d))).norm());
            }
          }
        }
        EXPECT_LE(near.rest - of.shapes.rounding(p, q), rest);
        EXPECT_LE(near.rest_gap - of.shapes.rounding(p, q), rest - 0.1);
        EXPECT_GT(near.rest, 0.15F);
      }
    }
  }
}

}  // namespace
}  // namespace clothsim::tiles_test
