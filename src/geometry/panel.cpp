#include "clothsim/geometry/panel.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "clothsim/geometry/delaunay.h"
#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Least distance of inner points from the outline, in cells.
constexpr double margin = 0.75;

/// Times that inner points are moved to the middle of their neighbours.
constexpr int smoothings = 10;

/// Smallest area of a triangle, of its longest edge squared: points along a straight side are not
/// exactly on a line.
constexpr double least_area = 0.01;

double area_of(const std::vector<PlanePoint>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return twice / 2;
}

/// Is the area of a triangle of three of the points positive, and not that of a sliver?
bool has_area(const std::vector<PlanePoint>& points, const std::array<int, 3>& corners) {
  const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(corners[k])]; };
  const PlanePoint one = at(1) - at(0), other = at(2) - at(0);
  const double longest2 =
      std::max({one.squaredNorm(), other.squaredNorm(), (other - one).squaredNorm()});
  return cross(one, other) / 2 > least_area * longest2;
}

/// Is a point inside a polygon, by the crossings of a ray along x?
bool is_inside(const std::vector<PlanePoint>& polygon, const PlanePoint& p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlanePoint &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const double x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > p.x()) inside = !inside;
  }
  return inside;
}

double distance_to(const std::vector<PlanePoint>& polygon, const PlanePoint& p) {
  double nearest = (polygon.front() - p).norm();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlanePoint &a = polygon[i], side = polygon[(i + 1) % polygon.size()] - a;
    const double share = std::clamp(side.dot(p - a) / side.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + share * side - p).norm());
  }
  return nearest;
}

/// The lattice's points inside an outline.
std::vector<PlanePoint> lattice(const std::vector<PlanePoint>& outline, double cell) {
  PlanePoint low = outline.front(), high = low;
  for (const PlanePoint& p : outline) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double rise = cell * std::sqrt(3) / 2;
  std::vector<PlanePoint> points;
  for (int row = 0; low.y() + rise * row <= high.y(); ++row) {
    for (int column = 0; low.x() + cell * (column + row % 2 / 2.0) <= high.x(); ++column) {
      const PlanePoint p(low.x() + cell * (column + row % 2 / 2.0), low.y() + rise * row);
      if (is_inside(outline, p) && distance_to(outline, p) > margin * cell) points.push_back(p);
    }
  }
  return points;
}

/// Delaunay's triangles inside the outline, which are the first of `points`.
std::vector<std::array<int, 3>> inner_triangles(const std::vector<PlanePoint>& outline,
                                                const std::vector<PlanePoint>& points) {
  std::vector<std::array<int, 3>> triangles = delaunay_triangles(points);
  const auto is_outside = [&](const std::array<int, 3>& corners) {
    const auto at = [&](std::size_t k) { return points[static_cast<std::size_t>(corners[k])]; };
    return !has_area(points, corners) || !is_inside(outline, (at(0) + at(1) + at(2)) / 3);
  };
  triangles.erase(std::remove_if(triangles.begin(), triangles.end(), is_outside), triangles.end());
  return triangles;
}

/// Moves the points after the first `fixed` to the middle of their neighbours.
void smooth(const std::vector<std::array<int, 3>>& triangles, std::size_t fixed,
            std::vector<PlanePoint>& points) {
  std::vector<PlanePoint> sums(points.size(), PlanePoint::Zero());
  std::vector<int> counts(points.size(), 0);
  for (const std::array<int, 3>& corners : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(corners[k]);
      for (const std::size_t next : {(k + 1) % 3, (k + 2) % 3}) {
        sums[i] += points[static_cast<std::size_t>(corners[next])];
        ++counts[i];
      }
    }
  }
  for (std::size_t i = fixed; i < points.size(); ++i) {
    if (counts[i] > 0) points[i] = sums[i] / counts[i];
  }
}

/// Splits inner edges between two sewn points of the outline at their middle.
void split_chords(const std::vector<bool>& sewn, PanelMesh& mesh) {
  const auto is_sewn = [&](int i) {
    return static_cast<std::size_t>(i) < sewn.size() && sewn[static_cast<std::size_t>(i)];
  };
  std::map<std::array<int, 2>, std::size_t> triangle_at;  // by directed edge
  const auto add = [&](std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) {
      triangle_at[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = t;
    }
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(t);
  std::vector<std::array<int, 2>> chords;
  for (const auto& [edge, t] : triangle_at) {
    const auto& [a, b] = edge;
    if (a < b && is_sewn(a) && is_sewn(b) && triangle_at.count({b, a}) > 0) chords.push_back(edge);
  }
  for (const auto& [a, b] : chords) {
    const std::size_t one = triangle_at[{a, b}], other = triangle_at[{b, a}];
    const auto across = [&](std::size_t t) {
      const std::array<int, 3>& corners = mesh.triangles[t];
      return corners[0] + corners[1] + corners[2] - a - b;
    };
    const int c = across(one), d = across(other), m = static_cast<int>(mesh.points.size());
    mesh.points.push_back(
        (mesh.points[static_cast<std::size_t>(a)] + mesh.points[static_cast<std::size_t>(b)]) / 2);
    mesh.triangles[one] = {a, m, c};
    mesh.triangles[other] = {b, m, d};
    mesh.triangles.push_back({m, b, c});
    mesh.triangles.push_back({m, a, d});
    for (const std::size_t t : {one, other, mesh.triangles.size() - 2, mesh.triangles.size() - 1}) {
      add(t);
    }
  }
}

/// Throws InvalidValue unless each side of the outline is an edge of a triangle.
void check_sides(const std::vector<PlanePoint>& outline,
                 const std::vector<std::array<int, 3>>& triangles) {
  std::set<std::array<int, 2>> edges;
  for (const auto& [a, b, c] : triangles) {
    edges.insert({a, b});
    edges.insert({b, c});
    edges.insert({c, a});
  }
  const auto count = static_cast<int>(outline.size());
  for (int i = 0; i < count; ++i) {
    if (edges.count({i, (i + 1) % count}) > 0) continue;
    throw InvalidValue(
        {},
        "an outline that crosses itself, or has sides far shorter than a cell, near " +
            place_text(outline[static_cast<std::size_t>(i)]),
        "an outline that triangles of the cell can fill");
  }
}

}  // namespace

PanelMesh fill_panel(std::vector<PlanePoint> outline, double cell, std::vector<bool> sewn) {
  const bool is_clockwise = area_of(outline) < 0;
  // Delaunay's triangles are anticlockwise: the check of sides needs the outline so, too.
  if (is_clockwise) {
    std::reverse(outline.begin(), outline.end());
    std::reverse(sewn.begin(), sewn.end());
  }
  PanelMesh mesh{outline, {}};
  for (const PlanePoint& p : lattice(outline, cell)) mesh.points.push_back(p);
  mesh.triangles = inner_triangles(outline, mesh.points);
  for (int i = 0; i < smoothings; ++i) {
    smooth(mesh.triangles, outline.size(), mesh.points);
    mesh.triangles = inner_triangles(outline, mesh.points);
  }
  check_sides(outline, mesh.triangles);
  split_chords(sewn, mesh);
  if (!is_clockwise) return mesh;
  const auto count = static_cast<int>(outline.size());
  std::reverse(mesh.points.begin(), mesh.points.begin() + count);
  for (std::array<int, 3>& corners : mesh.triangles) {
    for (int& i : corners) i = i < count ? count - 1 - i : i;
  }
  return mesh;
}

}  // namespace clothsim
