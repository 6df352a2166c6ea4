// The search on surfaces that are no grid: sheets with holes, tubes, balls, fans, all with their
// triangles in any order.

#include <cmath>
#include <random>

#include "surface_testing.h"

namespace clothsim::mesh_search_test {
namespace {

using namespace test;

constexpr double pi = 3.14159265358979323846;

struct Mesh {
  Points rest;
  std::vector<std::array<int, 3>> triangles;

  SurfaceMesh surface() const { return {static_cast<int>(rest.rows()), triangles}; }
};

/// Triangles in another order, each with its corners turned.
Mesh shuffled(Mesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
  for (auto& corners : mesh.triangles) {
    std::rotate(corners.begin(), corners.begin() + random() % 3, corners.end());
  }
  return mesh;
}

/// Two sheets 0.1 m apart, the first with a hole, both with points moved within them.
Mesh sheets(int side) {
  const Cloth cloth = cloth_of(side, side, 0.01);
  const int n = cloth.num_points();
  Mesh mesh{Points::Zero(2 * n, 3), {}};
  mesh.rest << cloth.rest_positions, cloth.rest_positions;
  mesh.rest.leftCols(2) += random_points(2 * n, 0.2 / side, 4).leftCols(2);
  mesh.rest.bottomRows(n).col(2).array() += 0.1;
  for (const auto& [a, b, c] : cloth.triangles) {
    const Vector3 middle = (row(cloth.rest_positions, a) + row(cloth.rest_positions, b) +
                            row(cloth.rest_positions, c)) /
                           3;
    if ((middle - Vector3(0.5, 0.5, 0)).norm() > 0.25) mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({n + a, n + b, n + c});
  }
  return mesh;
}

/// A tube about x, closed around, open at its ends.
Mesh tube(int along, int around) {
  Mesh mesh{Points::Zero(along * around, 3), {}};
  for (int i = 0; i < along * around; ++i) {
    const double angle = 2 * pi * (i % around) / around;
    mesh.rest.row(i) << 0.05 * (i / around), 0.12 * std::cos(angle), 0.12 * std::sin(angle);
  }
  for (int i = 0; i + 1 < along; ++i) {
    for (int j = 0; j < around; ++j) {
      const int a = i * around + j, b = i * around + (j + 1) % around;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
  }
  return mesh;
}

/// A point with triangles all around it, a triangle apart, and a point that has none.
Mesh fan(int spokes) {
  Mesh mesh{Points::Zero(spokes + 5, 3), {}};
  for (int k = 0; k < spokes; ++k) {
    const double angle = 2 * pi * k / spokes;
    mesh.rest.row(k + 1) << 0.2 * std::cos(angle), 0.2 * std::sin(angle), 0;
    mesh.triangles.push_back({0, k + 1, (k + 1) % spokes + 1});
  }
  for (int k = 0; k < 4; ++k) mesh.rest.row(spokes + 1 + k) << 0.5 + 0.1 * k, 0.1 * (k % 2), 0;
  mesh.triangles.push_back({spokes + 1, spokes + 2, spokes + 3});
  return mesh;
}

std::vector<Mesh> meshes() {
  return {shuffled(sheets(7), 1), shuffled(tube(7, 9), 2), shuffled(fan(11), 3),
          shuffled(tube(3, 3), 4)};
}

TEST(Tiling, OfAMeshHasEachPointEdgeAndTriangleOnce) {
  for (const Mesh& mesh : meshes()) {
    const SurfaceMesh surface = mesh.surface();
    const Tiling tiling(surface);
    std::vector<int> points, triangles;
    std::vector<std::array<int, 2>> edges;
    for (const Tiling::Tile& tile : tiling.tiles()) {
      if (tile.own[Tiling::own_point] != Tiling::lacking) points.push_back(tile.points[0]);
      for (std::size_t k = 0; k < 3; ++k) {
        if (tile.own[Tiling::first_edge + k] == Tiling::lacking) continue;
        const int a = tile.points[0], b = tile.points[Tiling::edges[k][1]];
        edges.push_back({std::min(a, b), std::max(a, b)});
        const auto beside = std::count_if(
            surface.triangles.begin(), surface.triangles.end(), [&](const auto& corners) {
              return std::count(corners.begin(), corners.end(), a) == 1 &&
                     std::count(corners.begin(), corners.end(), b) == 1;
            });
        EXPECT_EQ(tile.own[Tiling::first_edge + k] == Tiling::border, beside == 1);
      }
      for (std::size_t k = 0; k < 2; ++k) {
        if (tile.own[Tiling::first_triangle + k] == Tiling::lacking) continue;
        triangles.push_back(tile.triangles[k]);
        std::array<int, 3> corners,
            of = surface.triangles[static_cast<std::size_t>(triangles.back())];
        for (std::size_t l = 0; l < 3; ++l) corners[l] = tile.points[Tiling::triangles[k][l]];
        std::sort(corners.begin(), corners.end());
        std::sort(of.begin(), of.end());
        EXPECT_EQ(corners, of);
      }
    }
    std::sort(points.begin(), points.end());
    std::sort(edges.begin(), edges.end());
    std::sort(triangles.begin(), triangles.end());
    auto all_edges = surface.edges;
    std::sort(all_edges.begin(), all_edges.end());
    std::vector<int> all_points(static_cast<std::size_t>(mesh.rest.rows())),
        all_triangles(mesh.triangles.size());
    std::iota(all_points.begin(), all_points.end(), 0);
    std::iota(all_triangles.begin(), all_triangles.end(), 0);
    EXPECT_EQ(points, all_points);
    EXPECT_EQ(edges, all_edges);
    EXPECT_EQ(triangles, all_triangles);
    // A regular mesh takes little more than a tile a point.
    EXPECT_LT(tiling.tiles().size(), 2 * all_points.size() + 4);
  }
}

TEST(Patches, OfAMeshHaveEachTileOnceAndAllOfItsCorners) {
  for (const Mesh& mesh : meshes()) {
    const Tiling tiling(mesh.surface());
    std::vector<int> tiles(tiling.tiles().size(), 0);
    for (const Patch& patch : cut_into_patches(tiling, mesh.rest)) {
      for (const int tile : patch.tiles) {
        if (tile == Patch::none) continue;
        ++tiles[static_cast<std::size_t>(tile)];
        for (const int corner : tiling.at(tile).points) {
          EXPECT_EQ(std::count(patch.points.begin(), patch.points.end(), corner), 1);
        }
      }
    }
    EXPECT_EQ(tiles, std::vector<int>(tiles.size(), 1));
  }
}

/// Both sheets as cloths of their own, and a third one that crosses them.
SurfaceMesh three_cloths(Mesh& mesh) {
  const auto n = static_cast<int>(mesh.rest.rows());
  Points more = mesh.rest.topRows(n / 2);
  more.col(2) = more.col(0);
  mesh.rest.conservativeResize(n + n / 2, 3);
  mesh.rest.bottomRows(n / 2) = more;
  for (std::size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    if (a < n / 2) mesh.triangles.push_back({n + a, n + b, n + c});
  }
  SurfaceMesh surface = mesh.surface();
  surface.first_points = {0, n / 2, n};
  return surface;
}

/// All of those, each of several cloths of a thickness of its own [m].
std::vector<Surface> surfaces(double thickness) {
  std::vector<Surface> all;
  for (const Mesh& mesh : meshes()) {
    all.emplace_back(mesh.rest, mesh.surface(), std::vector<double>{thickness});
  }
  Mesh mesh = sheets(5);
  const SurfaceMesh several = three_cloths(mesh);
  all.emplace_back(mesh.rest, several,
                   std::vector<double>{0.3 * thickness, thickness, 0.1 * thickness});
  return all;
}

TEST(NearestDistances, OfAMeshAreAQuarterOfThoseAtRestUpToTheContactDistance) {
  for (const double thickness : {0.002, 0.01, 0.1}) {
    for (const Surface& surface : surfaces(thickness)) {
      double least = 1, largest = 0;
      brute_force(surface, [&](const SurfacePair& pair) {
        const auto& [a, b, c, d] = pair.points;
        double expected = surface.whole_distance(pair);
        if (pair.edges()) {
          const auto side = [&](int from, int to) {
            const auto [tile, k] = surface.tile_of(from, to);
            return surface.tiling->at(tile).own[Tiling::first_edge + k];
          };
          const bool inside = side(a, b) == Tiling::inside && side(c, d) == Tiling::inside;
          if (inside) expected *= NearestDistances::edge_share;
        }
        const double rest = separation(pair, surface.rest).distance;
        const bool one_cloth = surface.mesh.cloth_of(a) == surface.mesh.cloth_of(d);
        if (one_cloth) expected = std::min(expected, rest / 4);
        EXPECT_NEAR(pair.nearest, expected, 1e-12);
        least = std::min(least, pair.nearest);
        largest = std::max(largest, pair.nearest);
        return false;
      });
      EXPECT_LE(surface.nearest.min(), least);
      EXPECT_LE(largest, surface.nearest.max());
    }
  }
}

TEST(NearestDistances, OfTilesOfAMeshAreThoseOfTheirFeatures) {
  for (const double thickness : {0.002, 0.1}) {
    for (const Surface& surface : surfaces(thickness)) expect_all_once(surface);
  }
}

TEST(NearPairs, OfAMeshMissNothingThatMeetsWhileItMoves) {
  unsigned seed = 10;
  for (const Mesh& mesh : meshes()) {
    const Surface surface(mesh.rest, mesh.surface(), {0.015});
    NearPairs finder(surface.mesh, surface.rest, surface.thickness);
    const int n = surface.num_points();
    const Points crumpled = random_points(n, 0.15, ++seed);
    const auto at = [&](int step) -> Points {
      const double share = std::min(step, 40) / 60.0;
      return (1 - share) * mesh.rest + share * crumpled +
             random_points(n, 1e-3, static_cast<std::uint64_t>(step));
    };
    std::size_t meeting = 0;
    for (int step = 0; step < 50; ++step) {
      const Points here = at(step), ends = at(step + 1);
      finder.approaching(here, ends);
      const auto found = sorted_features(finder.swept_query(here, ends, 0.002));
      for (const double time : {0.0, 0.5, 1.0}) {
        const Points then = here + time * (ends - here);
        const auto must = sorted_features(brute_force(surface, [&](const SurfacePair& pair) {
          return separation(pair, then).distance <= 0.002;
        }));
        ASSERT_TRUE(std::includes(found.begin(), found.end(), must.begin(), must.end())) << step;
        meeting = std::max(meeting, must.size());
      }
      ASSERT_LE(finder.max_approach(), finder.sees());
      finder.go(ends);
    }
    EXPECT_GT(meeting, 2u);
  }
}

TEST(NearPairs, OfAMeshFindTheTrianglesThatPointsTouch) {
  unsigned seed = 20;
  for (const Surface& surface : surfaces(0.015)) {
    const int n = surface.num_points();
    NearPairs finder(surface.mesh, surface.rest, surface.thickness);
    const Points x = random_points(n, 0.12, ++seed);
    const std::vector<NearPair> found = finder.approaching(x, x);
    int touching = 0;
    for (int i = 0; i < n; ++i) {
      // The nearest of the pairs that keep their whole distance.
      const auto of_point = brute_force(surface, [&](const SurfacePair& pair) {
        return pair.points[0] == i && !pair.edges() && pair.nearest == surface.whole_distance(pair);
      });
      double gap = 0, told = 1;
      for (const SurfacePair& pair : of_point) {
        gap = std::min(gap, separation(pair, x).distance - pair.nearest);
      }
      if (gap == 0) continue;
      ++touching;
      for (const NearPair& near : found) {
        if (near.pair.edges() || near.pair.points[0] != i) continue;
        EXPECT_EQ(near.separation.distance, separation(near.pair, x).distance);
        EXPECT_EQ(near.pair.nearest, surface.nearest_of(near.pair));
        told = std::min(told, near.separation.distance - near.pair.nearest);
      }
      EXPECT_LE(told, gap + 1e-9) << i;
    }
    EXPECT_GT(touching, 1);
  }
}

TEST(NearPairs, OfTheSameGridFindTheSameAsAMesh) {
  const Cloth cloth = cloth_of(13, 11, 0.015);
  const SurfaceMesh mesh(cloth);
  for (const Tiling::Range& stencils : {Tiling::of_surfaces, Tiling::of_points}) {
    NearPairs of_grid(cloth, stencils), of_mesh(mesh, cloth.rest_positions, {0.015}, stencils);
    // The least gap of each point: adjacent triangles may have it.
    const auto gaps = [&](const std::vector<NearPair>& pairs) {
      std::vector<double> least(static_cast<std::size_t>(cloth.num_points()), 1);
      for (const NearPair& near : pairs) {
        const bool points = stencils.begin == Tiling::own_points;
        if (!points && near.pair.edges()) continue;
        for (const std::size_t k : {0u, 2u}) {
          if (!points && k > 0) continue;
          double& gap = least[static_cast<std::size_t>(near.pair.points[k])];
          gap = std::min(gap, near.separation.distance - near.pair.nearest);
        }
      }
      return least;
    };
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Points x = random_points(cloth.num_points(), 0.2, seed);
      of_grid.forget();
      of_mesh.forget();
      const auto grid = gaps(of_grid.approaching(x, x)), other = gaps(of_mesh.approaching(x, x));
      int touching = 0;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        if (grid[i] >= 0 && other[i] >= 0) continue;
        EXPECT_NEAR(grid[i], other[i], 1e-12) << i;
        ++touching;
      }
      EXPECT_GT(touching, 10);
    }
  }
}

TEST(NearPairs, OfAMeshGoOnToTheSameWithTheirMemory) {
  for (const Tiling::Range& stencils : {Tiling::of_surfaces, Tiling::of_points}) {
    for (const Mesh& mesh : meshes()) {
      const int n = static_cast<int>(mesh.rest.rows());
      const SurfaceMesh surface = mesh.surface();
      NearPairs finder(surface, mesh.rest, {0.02}, stencils), other = finder;
      const auto at = [&](int step) -> Points {
        return random_points(n, 0.15, 5) +
               random_points(n, 3e-3, static_cast<std::uint64_t>(100 + step));
      };
      for (int step = 0; step < 20; ++step) {
        if (step == 10) {
          MemoryWriter memory;
          finder.write(memory);
          MemoryReader reader(memory.numbers());
          other.read(reader);
          reader.finish();
        }
        const std::vector<NearPair> found = finder.approaching(at(step), at(step + 1));
        if (step < 10) continue;
        const std::vector<NearPair> again = other.approaching(at(step), at(step + 1));
        ASSERT_EQ(found.size(), again.size()) << step;
        for (std::size_t k = 0; k < found.size(); ++k) {
          EXPECT_EQ(found[k].key, again[k].key);
          EXPECT_EQ(found[k].separation.distance, again[k].separation.distance);
        }
      }
    }
  }
}

TEST(NearPairs, OfAMeshBearWhatIsNoSurface) {
  // Nothing at all, points alone, two sheets sewn along an edge, edges without length.
  std::vector<Mesh> odd{{Points::Zero(0, 3), {}}, {random_points(3, 0.1, 1), {}}, sheets(5)};
  odd.back().rest.bottomRows(25).col(2).array() -= 0.1;
  odd.push_back(fan(5));
  odd.back().rest.row(2) = odd.back().rest.row(1);
  for (const Mesh& mesh : odd) {
    for (const Tiling::Range& stencils : {Tiling::of_surfaces, Tiling::of_points}) {
      NearPairs finder(mesh.surface(), mesh.rest, {0.004}, stencils);
      EXPECT_TRUE(finder.approaching(mesh.rest, mesh.rest).empty());
      EXPECT_GT(finder.sees(), 0);
      EXPECT_GT(finder.min_nearest(), 0);
      MemoryWriter memory;
      finder.write(memory);
      MemoryReader reader(memory.numbers());
      finder.read(reader);
      reader.finish();
    }
  }
}

TEST(SurfaceMesh, RefusesWhatIsNoTriangle) {
  EXPECT_THROW(SurfaceMesh(3, {{0, 0, 1}}), InvalidValue);
  EXPECT_THROW(SurfaceMesh(3, {{0, 1, 3}}), InvalidValue);
  EXPECT_THROW(SurfaceMesh(3, {{-1, 1, 2}}), InvalidValue);
  EXPECT_EQ(SurfaceMesh(3, {{0, 1, 2}}).edges.size(), 3u);
}

}  // namespace
}  // namespace clothsim::mesh_search_test
