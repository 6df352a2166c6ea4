#include "clothsim/search/cell_outlines.h"

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

struct Looked {
  std::array<double, CellOutlines::pairs> distances;
  std::vector<int> near;
};

Looked look(const CellOutlines& outlines, std::size_t p, std::size_t q, double reach) {
  Looked result;
  std::array<int, CellOutlines::pairs> near;
  const std::size_t count = outlines.look(p, q, reach, result.distances.data(), near.data());
  result.near.assign(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count));
  return result;
}

/// The corners of cell `c` of a patch.
std::array<Vector3, 4> corners(const Cloth& cloth, const Patch& patch, std::size_t c,
                               const Points& x) {
  const int cell = patch.cells[c], columns = cloth.columns;
  const int first = cell + cell / (columns - 1);
  return {row(x, first), row(x, first + 1), row(x, first + columns), row(x, first + columns + 1)};
}

/// Between planes square to the line between their centres, with the plainest loops.
double distance_of_cells(const std::array<Vector3, 4>& a, const std::array<Vector3, 4>& b) {
  const auto centre = [](const std::array<Vector3, 4>& c) {
    return Vector3((c[0] + c[1] + c[2] + c[3]) / 4);
  };
  const Vector3 way = (centre(b) - centre(a)).normalized();
  double lowest = 1e9, highest = -1e9;
  for (const Vector3& corner : b) lowest = std::min(lowest, way.dot(corner));
  for (const Vector3& corner : a) highest = std::max(highest, way.dot(corner));
  return std::max(0.0, lowest - highest);
}

TEST(CellOutlines, AreNearWhereNoPlaneIsBetweenThem) {
  // The last patches have fewer cells than the others.
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const Points x = cloth.rest_positions + random_points(cloth.num_points(), 0.3, 5);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  CellOutlines outlines(patches.size());
  for (std::size_t p = 0; p < patches.size(); ++p) outlines.update(p, patches[p], x);

  constexpr double reach = 0.12;
  std::size_t near = 0, far = 0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::size_t q = p; q < patches.size(); ++q) {
      const Looked looked = look(outlines, p, q, reach);
      std::vector<int> expected;
      for (std::size_t i = 0; i < patches[p].cells.size(); ++i) {
        for (std::size_t j = p == q ? i : 0; j < patches[q].cells.size(); ++j) {
          const std::size_t k = i * CellOutlines::cells + j;
          const double distance =
              distance_of_cells(corners(cloth, patches[p], i, x), corners(cloth, patches[q], j, x));
          EXPECT_LE(looked.distances[k], distance);
          EXPECT_GE(looked.distances[k], (1 - 1e-4) * distance - 1e-12);
          ++(looked.distances[k] <= reach ? near : far);
          if (looked.distances[k] <= reach) expected.push_back(static_cast<int>(k));
        }
      }
      EXPECT_TRUE(looked.near == expected) << p << " and " << q;
    }
  }
  EXPECT_GT(near, 100u);
  EXPECT_GT(far, 100u);
}

TEST(CellOutlines, AreNearWhereTheyLieInEachOther) {
  const Cloth cloth = cloth_of(9, 9, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  CellOutlines outlines(patches.size());
  const Points point = Points::Ones(cloth.num_points(), 3);
  for (std::size_t p = 0; p < patches.size(); ++p) outlines.update(p, patches[p], point);
  EXPECT_EQ(look(outlines, 0, 1, 0.03).near.size(), CellOutlines::pairs);
}

}  // namespace
}  // namespace clothsim
