#include "clothsim/search/cell_outlines.h"

#include "surface_testing.h"

namespace clothsim {
namespace {

using namespace testing;

constexpr double awake_at_once = -1e9;
constexpr double never = 1e9;

struct Looked {
  std::array<double, CellOutlines::pairs> wake_at;
  std::vector<int> awake;
};

Looked look(const CellOutlines& outlines, std::size_t p, std::size_t q, double moved,
            double nearest, double reach, double wake_at) {
  Looked result;
  result.wake_at.fill(wake_at);
  std::array<int, CellOutlines::pairs> awake;
  const std::size_t count =
      outlines.look(p, q, moved, nearest, reach, result.wake_at.data(), awake.data());
  result.awake.assign(awake.begin(), awake.begin() + static_cast<std::ptrdiff_t>(count));
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
  double lowest = never, highest = -never;
  for (const Vector3& corner : b) lowest = std::min(lowest, way.dot(corner));
  for (const Vector3& corner : a) highest = std::max(highest, way.dot(corner));
  return std::max(0.0, lowest - highest);
}

TEST(CellOutlines, SleepForAsLongAsTheyAreApart) {
  // The last patches have fewer cells than the others.
  const Cloth cloth = cloth_of(11, 10, 0.01);
  const Points x = cloth.rest_positions + random_points(cloth.num_points(), 0.3, 5);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  CellOutlines outlines(patches.size());
  for (std::size_t p = 0; p < patches.size(); ++p) outlines.update(p, patches[p], x);

  constexpr double moved = 0.3, nearest = 0.02, reach = 0.1;
  int near = 0, far = 0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (std::size_t q = p; q < patches.size(); ++q) {
      const Looked looked = look(outlines, p, q, moved, nearest, reach, awake_at_once);
      for (std::size_t i = 0; i < patches[p].cells.size(); ++i) {
        for (std::size_t j = 0; j < patches[q].cells.size(); ++j) {
          const std::size_t k = i * CellOutlines::cells + j;
          const double gap = distance_of_cells(corners(cloth, patches[p], i, x),
                                               corners(cloth, patches[q], j, x)) -
                             nearest;
          EXPECT_LE(looked.wake_at[k], moved + gap + 1e-12);
          EXPECT_GE(looked.wake_at[k], moved + gap - 1e-4 * (gap + nearest) - 1e-12);
          const bool awake = std::find(looked.awake.begin(), looked.awake.end(),
                                       static_cast<int>(k)) != looked.awake.end();
          EXPECT_EQ(awake, looked.wake_at[k] <= moved + reach);
          ++(awake ? near : far);
        }
      }
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_GT(far, 100);
}

TEST(CellOutlines, LetSleepWhatIsNotAsked) {
  const Cloth cloth = cloth_of(9, 9, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  CellOutlines outlines(patches.size());
  for (std::size_t p = 0; p < patches.size(); ++p) {
    outlines.update(p, patches[p], cloth.rest_positions);
  }
  const Looked looked = look(outlines, 0, 1, 0, 0.02, 0.5, never);
  EXPECT_TRUE(looked.awake.empty());
  for (const double wake_at : looked.wake_at) EXPECT_EQ(wake_at, never);
}

TEST(CellOutlines, AreAwakeWhereTheyLieInEachOther) {
  const Cloth cloth = cloth_of(9, 9, 0.01);
  const std::vector<Patch> patches = cut_into_patches(cloth, 4);
  CellOutlines outlines(patches.size());
  const Points point = Points::Ones(cloth.num_points(), 3);
  for (std::size_t p = 0; p < patches.size(); ++p) outlines.update(p, patches[p], point);
  const Looked looked = look(outlines, 0, 1, 0, 0.02, 0.01, awake_at_once);
  EXPECT_EQ(looked.awake.size(), CellOutlines::pairs);
}

}  // namespace
}  // namespace clothsim
