// Panels of a sewing pattern: Delaunay's triangles, sides, filling, seams.

#include "clothsim/geometry/panel.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "clothsim/geometry/delaunay.h"
#include "clothsim/geometry/pattern.h"
#include "clothsim/model/errors.h"
#include "says.h"

namespace clothsim::panel_test {
namespace {

/// Twice the area of a triangle; positive if anticlockwise.
double twice_area(const std::vector<PlanePoint>& points, const std::array<int, 3>& t) {
  const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(t[k])]; };
  return cross(at(1) - at(0), at(2) - at(0));
}

double area_of(const PanelMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) area += twice_area(mesh.points, t) / 2;
  return area;
}

std::string mistake(const std::function<void()>& run) {
  try {
    run();
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

// ---- Delaunay's triangles

std::vector<PlanePoint> random_points(int count, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<> random(-3, 5);
  std::vector<PlanePoint> points;
  for (int i = 0; i < count; ++i) points.emplace_back(random(engine), random(engine));
  return points;
}

TEST(Delaunay, CirclesOfTrianglesHaveNoPointInside) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const std::vector<PlanePoint> points = random_points(60, seed);
    const auto triangles = delaunay_triangles(points);
    double area = 0;
    for (const auto& t : triangles) {
      const PlanePoint a = points[static_cast<std::size_t>(t[0])],
                       b = points[static_cast<std::size_t>(t[1])] - a,
                       c = points[static_cast<std::size_t>(t[2])] - a;
      ASSERT_GT(cross(b, c), 0);
      area += cross(b, c) / 2;
      const PlanePoint offset = PlanePoint(c.y() * b.squaredNorm() - b.y() * c.squaredNorm(),
                                           b.x() * c.squaredNorm() - c.x() * b.squaredNorm()) /
                                (2 * cross(b, c));
      for (const PlanePoint& p : points) {
        EXPECT_GT((p - a - offset).norm(), offset.norm() * (1 - 1e-6));
      }
    }
    // The convex hull, by Andrew's chain.
    std::vector<PlanePoint> sorted = points, hull;
    std::sort(sorted.begin(), sorted.end(), [](const PlanePoint& p, const PlanePoint& q) {
      return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
    });
    for (int pass = 0; pass < 2; ++pass) {
      const std::size_t first = hull.size();
      for (const PlanePoint& p : sorted) {
        while (hull.size() >= first + 2 &&
               cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
          hull.pop_back();
        }
        hull.push_back(p);
      }
      hull.pop_back();
      std::reverse(sorted.begin(), sorted.end());
    }
    double of_hull = 0;
    for (std::size_t i = 0; i < hull.size(); ++i) {
      of_hull += cross(hull[i], hull[(i + 1) % hull.size()]) / 2;
    }
    EXPECT_NEAR(area, of_hull, 1e-6 * of_hull) << seed;
  }
}

TEST(Delaunay, FillsAGridWhosePointsAreOnCircles) {
  std::vector<PlanePoint> points;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) points.emplace_back(0.1 * i, 0.1 * j);
  }
  double area = 0;
  for (const auto& t : delaunay_triangles(points)) area += twice_area(points, t) / 2;
  EXPECT_NEAR(area, 0.4 * 0.3, 1e-12);
}

TEST(Delaunay, HasNoTrianglesOfFewerThanThreePoints) {
  EXPECT_TRUE(delaunay_triangles({{0, 0}, {1, 0}}).empty());
}

// ---- Sides

TEST(Panel, ArcsAreOnTheirCircle) {
  for (const double side : {1.0, -1.0}) {
    const PanelSide arc = arc_side({2, 0}, {1, side}, {0, 0});
    for (const PlanePoint& p : arc) EXPECT_NEAR((p - PlanePoint(1, 0)).norm(), 1, 1e-12);
    EXPECT_NEAR(length_of(arc), M_PI, 1e-3 * M_PI);
    EXPECT_GT(side * arc[arc.size() / 2].y(), 0.99);
  }
  const PanelSide most = arc_side({1, 0}, {-1, 0}, {0, 1});  // three quarters of a circle
  EXPECT_NEAR(length_of(most), 1.5 * M_PI, 1e-3 * M_PI);
  EXPECT_TRUE(says(mistake([] {
                     arc_side({0, 0}, {1, 0}, {2, 0});
                   }),
                   "scene: got [1, 0], on the line ... beside"));
}

TEST(Panel, CurvesPassThroughTheirPoints) {
  const PanelSide curve = curved_side({0, 0}, {{1, 1}, {2, 0.5}}, {3, 2});
  for (const PlanePoint& knot : {PlanePoint(0, 0), {1, 1}, {2, 0.5}, {3, 2}}) {
    double nearest = 1;
    for (const PlanePoint& p : curve) nearest = std::min(nearest, (p - knot).norm());
    EXPECT_LT(nearest, 1e-12);
  }
  // Points on a line at even steps: the line.
  for (const PlanePoint& p : curved_side({0, 0}, {{1, 2}, {2, 4}}, {3, 6})) {
    EXPECT_NEAR(p.y(), 2 * p.x(), 1e-12);
  }
}

TEST(Panel, PointsAreEvenAlongASide) {
  const PanelSide arc = arc_side({1, 0}, {0, 1}, {-1, 0});
  const std::vector<PlanePoint> points = points_along(arc, 7);
  ASSERT_EQ(points.size(), 8u);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double angle = M_PI * double(k) / 7;
    EXPECT_LT((points[k] - PlanePoint(std::cos(angle), std::sin(angle))).norm(), 1e-3);
  }
}

// ---- Filling

std::vector<PlanePoint> circle(int points) {
  std::vector<PlanePoint> outline;
  for (int k = 0; k < points; ++k) {
    const double angle = 2 * M_PI * k / points;
    outline.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle));
  }
  return outline;
}

TEST(Panel, IsFilledWithEvenTriangles) {
  const PanelMesh mesh = fill_panel(circle(157), 0.02);
  EXPECT_NEAR(area_of(mesh), M_PI / 4, 1e-3);
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const PlanePoint a = mesh.points[static_cast<std::size_t>(t[k])],
                       b = mesh.points[static_cast<std::size_t>(t[(k + 1) % 3])];
      EXPECT_GT((b - a).norm(), 0.5 * 0.02);
      EXPECT_LT((b - a).norm(), 1.6 * 0.02);
    }
  }
}

TEST(Panel, KeepsItsOutlineInEitherDirection) {
  std::vector<PlanePoint> outline = circle(30);
  const PanelMesh one = fill_panel(outline, 0.1);
  std::reverse(outline.begin(), outline.end());
  const PanelMesh other = fill_panel(outline, 0.1);
  for (std::size_t i = 0; i < outline.size(); ++i) EXPECT_EQ(other.points[i], outline[i]);
  EXPECT_NEAR(area_of(other), area_of(one), 1e-12);
  for (const auto& t : other.triangles) EXPECT_GT(twice_area(other.points, t), 0);
}

TEST(Panel, NoInnerEdgeJoinsTwoSewnPoints) {
  const std::vector<PlanePoint> square = {{0, 0},     {0.1, 0},   {0.2, 0},   {0.3, 0},
                                          {0.3, 0.1}, {0.3, 0.2}, {0.3, 0.3}, {0.2, 0.3},
                                          {0.1, 0.3}, {0, 0.3},   {0, 0.2},   {0, 0.1}};
  const auto inner = [&](const std::vector<bool>& sewn) {
    int count = 0;
    for (const auto& t : fill_panel(square, 0.1, sewn).triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        count += a < 12 && b < 12 && (a + 1) % 12 != b;
      }
    }
    return count;
  };
  EXPECT_GT(inner({}), 0);
  EXPECT_EQ(inner(std::vector<bool>(12, true)), 0);
}

TEST(Panel, RefusesOutlinesThatCannotBeFilled) {
  EXPECT_TRUE(says(mistake([] {
                     fill_panel({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0.1);
                   }),
                   "scene: got an outline that crosses itself ... near ["));
}

// ---- Seams

Panel panel_of(const std::string& name, const std::vector<PlanePoint>& corners, double z) {
  Panel panel;
  panel.name = name;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    panel.sides.push_back(straight_side(corners[k], corners[(k + 1) % corners.size()]));
  }
  panel.origin = {0, 0, z};
  return panel;
}

Panel square_panel(const std::string& name, double size, double z) {
  return panel_of(name, {{0, 0}, {size, 0}, {size, size}, {0, size}}, z);
}

TEST(Pattern, ABagIsSewnAtThreeSides) {
  Pattern pattern;
  pattern.cell = 0.02;
  pattern.panels = {square_panel("front", 0.2, 0.01), square_panel("back", 0.2, 0)};
  for (const std::size_t k : {0u, 1u, 3u}) pattern.seams.push_back({{{0, k}, {1, k}}});
  const SewnPattern sewn = sew(pattern);
  const ClothMesh mesh = make_cloth_mesh(sewn.mesh, Vector3::UnitX(), RestLengths::uv);
  double area = 0;
  for (const auto& [a, b, c] : mesh.flat) area += std::abs(cross(b - a, c - a)) / 2;
  EXPECT_NEAR(area, 2 * 0.2 * 0.2, 1e-9);
  // Open at the fourth side alone: 10 edges of each panel.
  int open = 0;
  for (const MeshEdge& edge : mesh_edges(mesh.triangles)) open += edge.triangles[1] < 0;
  EXPECT_EQ(open, 20);
  // Seams lie halfway between the panels, other points where the panels are.
  for (const Vector3& x : sewn.sides[0][1]) EXPECT_NEAR(x.z(), 0.005, 1e-12);
  EXPECT_NEAR(sewn.sides[0][2][5].z(), 0.01, 1e-12);
  EXPECT_EQ(sewn.sides[0][1], sewn.sides[1][1]);
}

/// Two equal panels, sewn at all sides but one: its mesh, after the check of edges and angles.
ClothMesh pocket(const std::vector<PlanePoint>& corners, std::size_t open, double cell) {
  Pattern pattern;
  pattern.cell = cell;
  pattern.panels = {panel_of("front", corners, 0.02), panel_of("back", corners, 0)};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (k != open) pattern.seams.push_back({{{0, k}, {1, k}}});
  }
  return make_cloth_mesh(sew(pattern).mesh, Vector3::UnitX(), RestLengths::uv);
}

int open_edges(const ClothMesh& mesh) {
  int open = 0;
  for (const MeshEdge& edge : mesh_edges(mesh.triangles)) open += edge.triangles[1] < 0;
  return open;
}

TEST(Pattern, AnOpeningOfACellStaysOpen) {
  const std::vector<PlanePoint> cut = {{0, 0}, {0.3, 0}, {0.3, 0.28}, {0.28, 0.3}, {0, 0.3}};
  EXPECT_EQ(open_edges(pocket(cut, 2, 0.02)), 4);  // two of each panel
}

TEST(Pattern, AcuteCornersBetweenSeamsAreFilled) {
  for (const double apex : {60.0, 45.0, 30.0, 15.0}) {  // [degrees], of a pocket of 0.4 m
    const double half = 0.4 * std::tan(apex / 2 * M_PI / 180);
    for (const double cell : {0.04, 0.02, 0.01}) {
      const ClothMesh mesh = pocket({{-half, 0}, {half, 0}, {0, 0.4}}, 0, cell);
      double area = 0;
      for (const auto& [a, b, c] : mesh.flat) area += std::abs(cross(b - a, c - a)) / 2;
      EXPECT_NEAR(area, 2 * half * 0.4, 1e-9) << apex;
      EXPECT_EQ(open_edges(mesh), 2 * std::max(2l, std::lround(2 * half / cell))) << apex;
    }
  }
}

TEST(Pattern, StarsAndSleevesAreFilled) {
  std::vector<PlanePoint> star;
  for (int k = 0; k < 10; ++k) {
    const double angle = M_PI * k / 5, radius = k % 2 == 0 ? 0.2 : 0.08;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  EXPECT_EQ(open_edges(pocket(star, star.size(), 0.02)), 0);  // a cushion
  Pattern sleeve;
  sleeve.panels = {panel_of("a", {{0, 0}, {0.3, 0}, {0.3, 0.03}, {0, 0.03}}, 0.01),
                   panel_of("b", {{0, 0}, {0.3, 0}, {0.3, 0.03}, {0, 0.03}}, 0)};
  sleeve.seams = {{{{0, 0}, {1, 0}}}, {{{0, 2}, {1, 2}}}};
  EXPECT_EQ(open_edges(make_cloth_mesh(sew(sleeve).mesh, Vector3::UnitX(), RestLengths::uv)), 8);
}

TEST(Pattern, RefusesPanelsThatTouchWithoutASeam) {
  Pattern pattern;
  pattern.cell = 0.025;
  pattern.panels = {square_panel("a", 0.25, 0), square_panel("b", 0.25, 0)};
  pattern.panels[1].origin = {0.25, 0, 0};
  EXPECT_TRUE(says(mistake([&] { sew(pattern); }), "panels: got panels that touch at [0.25"));
  pattern.seams = {{{{0, 1}, {1, 3}}}};
  EXPECT_EQ(mistake([&] { sew(pattern); }), "accepted");
}

TEST(Pattern, SidesOfDifferentLengthsHaveAsManyPoints) {
  Pattern pattern;
  pattern.cell = 0.05;
  pattern.panels = {square_panel("a", 0.4, 0), square_panel("b", 0.3, 0)};
  pattern.panels[1].origin = {0.1, 0.5, 0};
  pattern.seams = {{{{0, 2}, {1, 0}}}};  // the upper side of a, the lower one of b
  const SewnPattern sewn = sew(pattern);
  ASSERT_EQ(sewn.sides[0][2].size(), 9u);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(sewn.sides[0][2][k], sewn.sides[1][0][8 - k]);
  pattern.panels[1] = square_panel("b", 0.1, 0);
  EXPECT_TRUE(says(mistake([&] { sew(pattern); }), "seams.0: got sides of 0.4 and 0.1 m"));
}

TEST(Pattern, ThreadsRunAlongTheWarpOfEachPanel) {
  Pattern pattern;
  pattern.panels = {square_panel("a", 0.2, 0)};
  pattern.panels[0].warp = {0, 2};
  const MeshTriangles mesh = sew(pattern).mesh;
  for (std::size_t i = 0; i < mesh.uv.size(); ++i) {
    EXPECT_NEAR(mesh.uv[i].x(), mesh.vertices[i].y(), 1e-12);
    EXPECT_NEAR(mesh.uv[i].y(), -mesh.vertices[i].x(), 1e-12);
  }
}

}  // namespace
}  // namespace clothsim::panel_test
