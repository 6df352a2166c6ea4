// Peirce's cantilever cut out of a mesh at any angle to the threads.

#include <cmath>

#include "verification/elastica.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::mesh_cantilever_test {
namespace {

using namespace test;

/// Drop over reach of a strip whose first two columns are held: clamped halfway between them.
double ratio_at_rest(double gamma, double warp, Sheet sheet) {
  Material material = strip(gamma, 10, false).material;
  material.fabric->bending_stiffness = {strip_bending(gamma), strip_bending(gamma)};
  const double spacing = strip_length / (sheet.columns - 1.5);
  sheet.width = spacing * (sheet.columns - 1);
  sheet.height = spacing * (sheet.rows - 1);
  sheet.straight = 2;
  ClothSpec spec = mesh_spec(triangles_of(sheet), material, warp);
  const Points& start = spec.mesh->positions;
  for (int i = 0; i < spec.columns; ++i) {
    if (start(i, 0) < 1.5 * spacing) spec.pinned.push_back({i, 0, "", {}});
  }
  const Points x = at_rest(make_cloth(spec));
  double drop = 0, reach = 0;
  int count = 0;
  for (int i = 0; i < spec.columns; ++i) {
    if (start(i, 0) < sheet.width - 1e-9) continue;
    drop -= x(i, 2);
    reach += x(i, 0) - spacing / 2;
    ++count;
  }
  EXPECT_EQ(count, sheet.rows);
  return drop / reach;
}

double exact_ratio(double gamma) {
  const EndOfStrip end = elastica(gamma);
  return end.drop / end.reach;
}

constexpr double degree = M_PI / 180;

TEST(MeshCantilever, HangsAsPeircesStripAtAnyAngleToTheThreads) {
  for (const double warp : {0.0, 22.5, 45.0, 90.0}) {
    for (const double gamma : {0.1, 1.0, 10.0, 100.0}) {
      SCOPED_TRACE(std::to_string(gamma) + ", warp " + std::to_string(warp));
      const double exact = exact_ratio(gamma);
      EXPECT_NEAR(ratio_at_rest(gamma, warp * degree, {10, 4}), exact, 0.03 * exact);
    }
  }
  for (const double gamma : {1.0, 10.0, 100.0}) {
    SCOPED_TRACE(gamma);
    const double exact = exact_ratio(gamma);
    EXPECT_NEAR(ratio_at_rest(gamma, 45 * degree, {40, 4}), exact, 0.01 * exact);
  }
}

TEST(MeshCantilever, HangsTheSameOnUnevenMeshes) {
  // Points that are up to a fifth of a cell off their places, with diagonals at random.
  Sheet sheet{10, 4};
  sheet.uneven = 0.2;
  for (const auto& [gamma, warp] : {std::pair(1.0, 0.0), {10.0, 22.5}, {100.0, 90.0}}) {
    SCOPED_TRACE(std::to_string(gamma) + ", warp " + std::to_string(warp));
    const double exact = exact_ratio(gamma);
    EXPECT_NEAR(ratio_at_rest(gamma, warp * degree, sheet), exact, 0.03 * exact);
  }
  sheet.columns = 40;
  sheet.rows = 9;
  const double exact = exact_ratio(10);
  EXPECT_NEAR(ratio_at_rest(10, 45 * degree, sheet), exact, 0.01 * exact);
}

TEST(MeshCantilever, IsALittleTooStiffOnVeryUnevenMeshes) {
  for (const double gamma : {1.0, 10.0}) {
    SCOPED_TRACE(gamma);
    const double exact = exact_ratio(gamma);
    Sheet sheet{20, 7};
    sheet.uneven = 0.35;
    const double ratio = ratio_at_rest(gamma, 0, sheet);
    EXPECT_LT(ratio, 1.01 * exact);
    EXPECT_GT(ratio, 0.96 * exact);
  }
}

}  // namespace
}  // namespace clothsim::mesh_cantilever_test
