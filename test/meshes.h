#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "clothsim/shapes/mesh_file.h"
#include "clothsim/shapes/shape.h"

// Closed surfaces for tests, and files of them.

namespace clothsim::test {

/// The boundary of a set of unit cells of a lattice, scaled: `is_solid(x, y, z)` for whole numbers
/// from 0 to `count` - 1 along each axis. Two triangles to a face. Cells must not meet along an
/// edge alone.
template <class IsSolid>
TriangleSoup cells_soup(int count, const Vector3& origin, const Vector3& cell, IsSolid is_solid) {
  TriangleSoup soup;
  const auto solid = [&](const Eigen::Vector3i& c) {
    return c.minCoeff() >= 0 && c.maxCoeff() < count && is_solid(c.x(), c.y(), c.z());
  };
  const auto add_face = [&](const Eigen::Vector3i& c, int axis, int side) {
    // Its corners go around +axis; the other way around on the lower side.
    const int u = (axis + 1) % 3, v = (axis + 2) % 3,
              first = static_cast<int>(soup.vertices.size());
    for (const auto& [du, dv] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      Eigen::Vector3i corner = c;
      corner[axis] += side;
      corner[u] += du;
      corner[v] += dv;
      soup.vertices.push_back(origin + corner.cast<double>().cwiseProduct(cell));
    }
    const int b = side ? 1 : 3, d = side ? 3 : 1;
    soup.triangles.push_back({first, first + b, first + 2});
    soup.triangles.push_back({first, first + 2, first + d});
  };
  for (int x = 0; x < count; ++x) {
    for (int y = 0; y < count; ++y) {
      for (int z = 0; z < count; ++z) {
        const Eigen::Vector3i c(x, y, z);
        if (!solid(c)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (const int side : {0, 1}) {
            if (!solid(c + (2 * side - 1) * Eigen::Vector3i::Unit(axis))) add_face(c, axis, side);
          }
        }
      }
    }
  }
  return soup;
}

/// All of them in one surface.
inline TriangleSoup together(const std::vector<TriangleSoup>& soups) {
  TriangleSoup all;
  for (const TriangleSoup& soup : soups) {
    const int first = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), soup.vertices.begin(), soup.vertices.end());
    for (const auto& [a, b, c] : soup.triangles) {
      all.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return all;
}

inline TriangleSoup moved(TriangleSoup soup, const Vector3& by) {
  for (Vector3& vertex : soup.vertices) vertex += by;
  return soup;
}

/// A box about the origin.
inline TriangleSoup box_soup(const Vector3& size) {
  return cells_soup(1, -size / 2, size, [](int, int, int) { return true; });
}

/// A step: of eight cells of a cube of side `size` [m] about the origin, two are missing.
inline TriangleSoup step_soup(double size) {
  return cells_soup(2, Vector3::Constant(-size / 2), Vector3::Constant(size / 2),
                    [](int x, int, int z) { return x == 0 || z == 0; });
}

/// A surface over a grid that is closed in both directions: place(u, v) for u and v in [0, 1).
template <class Place>
TriangleSoup closed_grid_soup(int columns, int rows, Place place) {
  TriangleSoup soup;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      soup.vertices.push_back(place(1.0 * c / columns, 1.0 * r / rows));
      const auto at = [&](int column, int row) { return row % rows * columns + column % columns; };
      soup.triangles.push_back({at(c, r), at(c + 1, r), at(c + 1, r + 1)});
      soup.triangles.push_back({at(c, r), at(c + 1, r + 1), at(c, r + 1)});
    }
  }
  return soup;
}

/// A ring about the z axis.
inline TriangleSoup torus_soup(double radius, double thickness, int columns, int rows) {
  return closed_grid_soup(columns, rows, [=](double u, double v) {
    const double around = 2 * M_PI * u, across = 2 * M_PI * v;
    const double out = radius + thickness * std::cos(across);
    return Vector3(out * std::cos(around), out * std::sin(around), thickness * std::sin(across));
  });
}

/// A body about the z axis, profile(v) = (radius, z) for v from 0 to 1, its ends on the axis.
template <class Profile>
TriangleSoup turned_soup(int columns, int rows, Profile profile) {
  TriangleSoup soup;
  for (int r = 0; r <= rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const double around = 2 * M_PI * c / columns;
      const auto [radius, z] = profile(1.0 * r / rows);
      const double out = r == 0 || r == rows ? 0 : radius;
      soup.vertices.push_back({out * std::cos(around), out * std::sin(around), z});
      if (r == rows) continue;
      const auto at = [&](int column, int row) { return row * columns + column % columns; };
      soup.triangles.push_back({at(c, r), at(c + 1, r), at(c + 1, r + 1)});
      soup.triangles.push_back({at(c, r), at(c + 1, r + 1), at(c, r + 1)});
    }
  }
  return soup;
}

/// A ball of about 2 * columns * rows triangles.
inline TriangleSoup ball_soup(double radius, int columns, int rows) {
  return turned_soup(columns, rows, [=](double v) {
    return std::pair(radius * std::sin(M_PI * v), -radius * std::cos(M_PI * v));
  });
}

/// A ball of 12 * count^2 triangles of about one size, on the cube about it.
inline TriangleSoup globe_soup(double radius, int count) {
  TriangleSoup soup = cells_soup(1, {-1, -1, -1}, {2, 2, 2}, [](int, int, int) { return true; });
  const TriangleSoup cube = soup;
  soup = {};
  for (std::size_t face = 0; face < cube.vertices.size(); face += 4) {
    const Vector3 &a = cube.vertices[face], u = cube.vertices[face + 1] - a,
                  v = cube.vertices[face + 3] - a;
    const bool outwards = u.cross(v).dot(a) > 0;
    const int first = static_cast<int>(soup.vertices.size());
    for (int i = 0; i <= count; ++i) {
      for (int k = 0; k <= count; ++k) {
        Vector3 p = a + 1.0 * i / count * u + 1.0 * k / count * v;
        for (int axis = 0; axis < 3; ++axis) p[axis] = std::tan(M_PI / 4 * p[axis]);
        // The same bits for points on two sides of the cube.
        p = (p.array() * 1e9).round() / 1e9;
        p = radius / p.norm() * p;
        soup.vertices.push_back((p.array() * 1e12).round() / 1e12);
        if (i == count || k == count) continue;
        const int here = first + i * (count + 1) + k, next = here + count + 1;
        const std::array<int, 3> one{here, next, next + 1}, other{here, next + 1, here + 1};
        for (auto t : {one, other}) {
          if (!outwards) std::swap(t[1], t[2]);
          soup.triangles.push_back(t);
        }
      }
    }
  }
  return soup;
}

/// A finger along z, 60 mm long and 16 mm wide, with a round tip at z = 0 and a flat end.
inline TriangleSoup finger_soup(int columns = 24, int rows = 24) {
  constexpr double radius = 0.008, length = 0.06;
  return turned_soup(columns, rows, [=](double v) {
    if (v < 0.5) return std::pair(radius * std::sin(M_PI * v), -radius * std::cos(M_PI * v));
    return v < 0.75 ? std::pair(radius, length * (v - 0.5) / 0.25)
                    : std::pair(radius * (1 - v) / 0.25, length);
  });
}

inline TriangleSoup turned(TriangleSoup soup, const Eigen::Quaterniond& turn) {
  for (Vector3& p : soup.vertices) p = turn * p;
  return soup;
}

inline Shape mesh_shape(const TriangleSoup& soup, double padding = 0) {
  return MeshShape{std::make_shared<const MeshFile>(MeshFile{Solid(soup), "", {1, 1, 1}}), padding};
}

/// Those triangles of a surface whose corners all lie above z.
inline TriangleSoup above_z(TriangleSoup soup, double z) {
  const auto is_below = [&](int i) { return soup.vertices[static_cast<std::size_t>(i)].z() < z; };
  auto& all = soup.triangles;
  all.erase(std::remove_if(
                all.begin(), all.end(),
                [&](const auto& t) { return is_below(t[0]) || is_below(t[1]) || is_below(t[2]); }),
            all.end());
  return soup;
}

/// A square of side `size` [m] in the plane z = 0 about the origin.
inline TriangleSoup square_soup(double size) {
  const double half = size / 2;
  return {{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}},
          {{0, 1, 2}, {0, 2, 3}}};
}

inline Shape sheet_shape(const TriangleSoup& soup, double thickness) {
  return MeshShape{
      std::make_shared<const MeshFile>(MeshFile{Solid(soup, Bounds::sheet), "", {1, 1, 1}}),
      thickness / 2};
}

inline void write_obj(const std::string& path, const TriangleSoup& soup) {
  std::ofstream file(path);
  file.precision(9);
  for (const Vector3& p : soup.vertices) file << "v " << p.transpose() << '\n';
  for (const auto& [a, b, c] : soup.triangles)
    file << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
}

/// A text file, as most programs write it.
inline void write_stl(const std::string& path, const TriangleSoup& soup) {
  std::ofstream file(path);
  file.precision(9);
  file << "solid test\n";
  for (const auto& triangle : soup.triangles) {
    file << "facet normal 0 0 0\nouter loop\n";
    for (const int i : triangle)
      file << "vertex " << soup.vertices[static_cast<std::size_t>(i)].transpose() << '\n';
    file << "endloop\nendfacet\n";
  }
  file << "endsolid test\n";
}

}  // namespace clothsim::test
