#include "clothsim/geometry/cloth_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/geometry/closest_points.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"

namespace clothsim {
namespace {

using Corners = std::array<int, 3>;
using Flat = ClothMesh::Flat;

/// Triangles with a smaller angle have edges that are far stiffer than the fabric.
constexpr double min_angle = M_PI / 180;

/// Least length of the warp's part in a triangle's plane, by the warp's own: below it the first
/// edge takes its place.
constexpr double min_part = 1e-6;

/// Least distance of a point from a triangle that it is no corner of, of the triangle's longest
/// edge.
constexpr double min_gap = 1e-3;

std::string triangle_text(int triangle, const Points& positions, const Corners& corners) {
  const Vector3 centre =
      (row(positions, corners[0]) + row(positions, corners[1]) + row(positions, corners[2])) / 3;
  return "triangle " + std::to_string(triangle) + " at " + place_text(centre);
}

/// Points and triangles of a file, with vertices at the same place as one.
ClothMesh joined(const MeshTriangles& given) {
  std::map<std::tuple<double, double, double>, int> known;
  std::vector<int> firsts;  // vertices, by point
  ClothMesh mesh;
  for (const Corners& triangle : given.triangles) {
    Corners corners{};
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vector3& x = given.vertices[static_cast<std::size_t>(triangle[k])];
      const auto [found, is_new] =
          known.emplace(std::tuple(x.x(), x.y(), x.z()), static_cast<int>(firsts.size()));
      if (is_new) firsts.push_back(triangle[k]);
      corners[k] = found->second;
    }
    mesh.triangles.push_back(corners);
  }
  mesh.positions.resize(static_cast<Eigen::Index>(firsts.size()), 3);
  for (std::size_t i = 0; i < firsts.size(); ++i) {
    mesh.positions.row(static_cast<Eigen::Index>(i)) =
        given.vertices[static_cast<std::size_t>(firsts[i])].transpose();
  }
  return mesh;
}

/// Does a triangle have the edge from a to b, in this direction?
bool runs(const Corners& t, int a, int b) {
  return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
}

/// Turns triangles over that face the other way than their neighbours. `order`: the corner of the
/// file's triangle that each corner was.
void face_alike(const Points& positions, const std::vector<MeshEdge>& edges,
                std::vector<Corners>& triangles, std::vector<Corners>& order) {
  std::vector<std::vector<int>> edges_at(triangles.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    for (const int t : edges[e].triangles) {
      if (t >= 0) edges_at[static_cast<std::size_t>(t)].push_back(static_cast<int>(e));
    }
  }
  order.assign(triangles.size(), {0, 1, 2});
  std::vector<bool> done(triangles.size(), false);
  std::vector<int> next;
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (done[first]) continue;
    done[first] = true;
    next.push_back(static_cast<int>(first));
    while (!next.empty()) {
      const auto t = static_cast<std::size_t>(next.back());
      next.pop_back();
      for (const int e : edges_at[t]) {
        const auto& [points, both] = edges[static_cast<std::size_t>(e)];
        const int other = both[0] == static_cast<int>(t) ? both[1] : both[0];
        if (other < 0) continue;
        Corners& neighbour = triangles[static_cast<std::size_t>(other)];
        const bool alike =
            runs(triangles[t], points[0], points[1]) != runs(neighbour, points[0], points[1]);
        if (done[static_cast<std::size_t>(other)]) {
          if (alike) continue;
          throw InvalidValue({},
                             "a surface with one side: no side is the front of " +
                                 triangle_text(other, positions, neighbour),
                             "a surface with two sides");
        }
        if (!alike) {
          std::swap(neighbour[1], neighbour[2]);
          std::swap(order[static_cast<std::size_t>(other)][1],
                    order[static_cast<std::size_t>(other)][2]);
        }
        done[static_cast<std::size_t>(other)] = true;
        next.push_back(other);
      }
    }
  }
}

/// Corners of a triangle in its own plane, with `warp` along the first axis.
std::array<Flat, 3> laid_flat(const std::array<Vector3, 3>& x, const Vector3& warp) {
  const Vector3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
  Vector3 along = warp - warp.dot(normal) * normal;
  if (along.norm() <= min_part * warp.norm()) along = x[1] - x[0];
  along.normalize();
  const Vector3 across = normal.cross(along);
  std::array<Flat, 3> flat;
  for (std::size_t k = 0; k < 3; ++k) {
    flat[k] = {along.dot(x[k] - x[0]), across.dot(x[k] - x[0])};
  }
  return flat;
}

double smallest_angle(const std::array<Flat, 3>& x) {
  double smallest = M_PI;
  for (std::size_t k = 0; k < 3; ++k) {
    const Flat a = x[(k + 1) % 3] - x[k], b = x[(k + 2) % 3] - x[k];
    smallest = std::min(smallest, std::atan2(std::abs(a.x() * b.y() - a.y() * b.x()), a.dot(b)));
  }
  return smallest;
}

/// Throws InvalidValue for a sliver, and for edges that are not finite or out of range.
void check_shape(const std::array<Flat, 3>& flat, const std::string& where) {
  constexpr Range edge_range{1e-6, 1e4, "m"};
  for (std::size_t k = 0; k < 3; ++k) {
    const double length = (flat[(k + 1) % 3] - flat[k]).norm();
    if (length >= edge_range.min && length <= edge_range.max) continue;
    throw InvalidValue({}, where + " with an edge of " + to_text(length) + " m",
                       "edges from 1e-06 to 10000 m");
  }
  const double angle = smallest_angle(flat);
  if (angle >= min_angle) return;
  throw InvalidValue({}, where + " with an angle of " + to_text(angle * 180 / M_PI) + " degrees",
                     "angles of at least 1 degree");
}

void check_crossings(const ClothMesh& mesh) {
  Cloth cloth;
  cloth.rest_positions = mesh.positions;
  cloth.triangles = mesh.triangles;
  const std::vector<TrianglePair> pairs = find_intersections(cloth, mesh.positions);
  if (pairs.empty()) return;
  const auto text = [&](int t) {
    return triangle_text(t, mesh.positions, mesh.triangles[static_cast<std::size_t>(t)]);
  };
  throw InvalidValue({}, text(pairs.front().a) + " through " + text(pairs.front().b),
                     "triangles that do not pass through each other");
}

/// Throws InvalidValue for a point that lies on a triangle of another part of the surface: contact
/// takes them for sewn, see NearestDistances.
void check_gaps(const ClothMesh& mesh) {
  std::vector<Box> boxes;  // of triangles, then of points
  const auto corner = [&](std::size_t t, std::size_t k) -> Vector3 {
    return row(mesh.positions, mesh.triangles[t][k]);
  };
  std::vector<double> gaps;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    gaps.push_back(min_gap * std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}));
    const Vector3 around = Vector3::Constant(gaps.back());
    boxes.emplace_back(a.cwiseMin(b).cwiseMin(c) - around, a.cwiseMax(b).cwiseMax(c) + around);
  }
  const auto count = static_cast<int>(boxes.size());
  for (Eigen::Index i = 0; i < mesh.positions.rows(); ++i) {
    boxes.emplace_back(mesh.positions.row(i).transpose(), mesh.positions.row(i).transpose());
  }
  BoxTree(boxes).visit_overlaps([&](int first, int second) {
    const auto [triangle, other] = std::minmax(first, second);
    const int point = other - count;
    if (triangle >= count || point < 0) return;
    const auto t = static_cast<std::size_t>(triangle);
    const Corners& corners = mesh.triangles[t];
    if (std::find(corners.begin(), corners.end(), point) != corners.end()) return;
    const Vector3 x = row(mesh.positions, point);
    const auto shares = closest_on_triangle(x, corner(t, 0), corner(t, 1), corner(t, 2));
    const Vector3 nearest =
        shares[0] * corner(t, 0) + shares[1] * corner(t, 1) + shares[2] * corner(t, 2);
    if ((x - nearest).norm() > gaps[t]) return;
    throw InvalidValue({},
                       "point " + std::to_string(point) + " on " +
                           triangle_text(triangle, mesh.positions, corners),
                       "more than " + to_text(gaps[t]) + " m between unjoined parts");
  });
}

/// Texture coordinates by place: along `warp`, and along the longer extent across it.
void lay_texture(const Vector3& warp, ClothMesh& mesh) {
  const Vector3 along = warp.normalized();
  const Points across = mesh.positions - (mesh.positions * along) * along.transpose();
  const Eigen::RowVector3d low = across.colwise().minCoeff(), high = across.colwise().maxCoeff();
  int axis = 0;
  (high - low).maxCoeff(&axis);
  mesh.uv.resize(mesh.positions.rows(), 2);
  mesh.uv.col(0) = mesh.positions * along;
  mesh.uv.col(1) = across.col(axis);
  for (int k = 0; k < 2; ++k) {
    const double least = mesh.uv.col(k).minCoeff();
    const double range = mesh.uv.col(k).maxCoeff() - least;
    mesh.uv.col(k) = ((mesh.uv.col(k).array() - least) / (range > 0 ? range : 1)).matrix();
  }
}

void set_texture(const MeshTriangles& given, const std::vector<Corners>& order, const Vector3& warp,
                 ClothMesh& mesh) {
  const auto is_outside = [](const Eigen::Vector2d& uv) {
    return !(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1);
  };
  if (given.uv.empty() || !given.has_texture ||
      std::any_of(given.uv.begin(), given.uv.end(), is_outside)) {
    return lay_texture(warp, mesh);
  }
  mesh.uv.setConstant(mesh.positions.rows(), 2, -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int point = mesh.triangles[t][k];
      if (mesh.uv(point, 0) >= 0) continue;  // at a seam the first panel's
      const auto vertex = given.triangles[t][static_cast<std::size_t>(order[t][k])];
      mesh.uv.row(point) = given.uv[static_cast<std::size_t>(vertex)].transpose();
    }
  }
}

}  // namespace

std::string place_text(const Vector3& x) {
  return '[' + to_text(x.x()) + ", " + to_text(x.y()) + ", " + to_text(x.z()) + ']';
}

ClothMesh make_cloth_mesh(const MeshTriangles& given, const Vector3& warp, RestLengths lengths) {
  if (given.triangles.empty()) throw InvalidValue({}, "no triangles", "a surface");
  if (lengths == RestLengths::uv && given.uv.empty()) {
    throw InvalidValue({}, "no texture coordinates", "some, for lengths: uv");
  }
  ClothMesh mesh = joined(given);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners& corners = mesh.triangles[t];
    const std::array<Vector3, 3> x{row(mesh.positions, corners[0]), row(mesh.positions, corners[1]),
                                   row(mesh.positions, corners[2])};
    check_shape(laid_flat(x, x[1] - x[0]),
                triangle_text(static_cast<int>(t), mesh.positions, corners));
  }
  std::vector<Corners> order;
  face_alike(mesh.positions, mesh_edges(mesh.triangles), mesh.triangles, order);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners& corners = mesh.triangles[t];
    std::array<Flat, 3> flat;
    if (lengths == RestLengths::uv) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto vertex = given.triangles[t][static_cast<std::size_t>(order[t][k])];
        flat[k] = given.uv[static_cast<std::size_t>(vertex)];
      }
      check_shape(flat, "at rest, " + triangle_text(static_cast<int>(t), mesh.positions, corners));
    } else {
      flat = laid_flat({row(mesh.positions, corners[0]), row(mesh.positions, corners[1]),
                        row(mesh.positions, corners[2])},
                       warp);
    }
    mesh.flat.push_back(flat);
  }
  set_texture(given, order, warp, mesh);
  check_apart(mesh);
  return mesh;
}

void check_apart(const ClothMesh& mesh) {
  check_crossings(mesh);
  check_gaps(mesh);
}

}  // namespace clothsim
