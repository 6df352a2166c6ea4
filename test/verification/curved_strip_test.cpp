// A strip that is a quarter of a circle at rest, held at its lower end: its sag under its weight.

#include <cmath>

#include "verification/elastica.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::curved_strip_test {
namespace {

using namespace test;

constexpr double quarter = M_PI / 2;
constexpr double radius = strip_length / quarter;

struct Way {
  double right;
  double down;
};

/// By Castigliano's theorem: the moment M of the weight w per length at the angle t from the clamp
/// and that m of a unit force on the tip bend a thin beam of stiffness B by the integral of M m R /
/// B.
Way exact_way(double weight, double bending) {
  constexpr int steps = 2000;
  constexpr double dt = quarter / steps;
  Way way{0, 0};
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) * dt;
    // w R times the integral of R (sin a - sin t) over the angles a from t to a quarter.
    const double moment = weight * radius * radius * (std::cos(t) - (quarter - t) * std::sin(t));
    way.right += moment * radius * std::cos(t) * radius * dt / bending;
    way.down += moment * radius * (1 - std::sin(t)) * radius * dt / bending;
  }
  return way;
}

/// Of the tip, from the shape at the start to that at rest.
Way way_of_tip(double gamma, int points) {
  Sheet sheet{points, 4};
  const double turn = quarter / (points - 1.5);  // of a cell: clamped halfway in the first
  sheet.width = points - 1;
  sheet.height = 3 * radius * turn;
  MeshTriangles triangles = triangles_of(sheet);
  for (Vector3& p : triangles.vertices) {
    const double t = (p.x() - 0.5) * turn;
    p = {radius * std::sin(t), p.y(), radius * (1 - std::cos(t))};
  }
  Material material = strip(gamma, 10, false).material;
  material.fabric->bending_stiffness = {strip_bending(gamma), strip_bending(gamma)};
  ClothSpec spec = curved_spec(triangles, material);
  const Points& start = spec.mesh->positions;
  for (int i = 0; i < spec.columns; ++i) {
    if (start(i, 0) < radius * std::sin(turn)) spec.pinned.push_back({i, 0, "", {}});
  }
  EXPECT_EQ(spec.pinned.size(), 8U);
  const Points x = at_rest(make_cloth(spec));
  Eigen::Index tip;
  start.col(2).maxCoeff(&tip);
  return {x(tip, 0) - start(tip, 0), start(tip, 2) - x(tip, 2)};
}

TEST(CurvedStrip, SagsAsAThinBeam) {
  constexpr double gamma = 0.02;
  const Way exact = exact_way(fabric_density * 9.8, strip_bending(gamma));
  EXPECT_GT(exact.down, 1e-4 * strip_length);
  for (const auto& [points, share] : {std::pair(10, 0.03), std::pair(40, 0.01)}) {
    SCOPED_TRACE(points);
    const Way way = way_of_tip(gamma, points);
    EXPECT_NEAR(way.right, exact.right, share * exact.right);
    EXPECT_NEAR(way.down, exact.down, share * exact.down);
  }
}

}  // namespace
}  // namespace clothsim::curved_strip_test
