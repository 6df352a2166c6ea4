#include "clothsim/model/mesh_bends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "clothsim/model/edge_slope.h"
#include "clothsim/model/flat_triangle.h"
#include "clothsim/model/rest_curvature.h"
#include "clothsim/model/types.h"

namespace clothsim {
namespace {

using Flat = ClothMesh::Flat;

Flat outward_normal(const FlatTriangle& x, std::size_t k) {
  const Flat along = edge(x, k).normalized();
  const Flat normal(along.y(), -along.x());
  return normal.dot(x[(k + 2) % 3] - x[k]) > 0 ? Flat(-normal) : normal;
}

/// The point across an edge of a triangle, laid into its plane.
struct Across {
  std::size_t edge;
  int point;      // of the cloth
  double height;  // of its place over the edge [m]
  Flat foot;      // of its place on the edge's line

  Flat place(const FlatTriangle& triangle) const {
    return foot + height * outward_normal(triangle, edge);
  }
};

/// Curvatures uu, vv and uv of a triangle [1/m], linear in the heights of points over its plane.
class Curvatures {
 public:
  /// Has the corners and the points across edges, of which several may be the same.
  Curvatures(const std::array<int, 3>& corners, const std::vector<Across>& neighbours) {
    for (const int corner : corners) append(corner);
    for (const Across& n : neighbours) append(n.point);
  }

  void add_to_place(std::size_t place, const Vector3& coefficients) {
    coefficients_[place] += coefficients;
  }
  void add(int point, const Vector3& coefficients) {
    const auto found = std::find(points_.begin(), points_.begin() + count_, point);
    const auto place = static_cast<std::size_t>(found - points_.begin());
    if (static_cast<int>(place) == count_) append(point);
    add_to_place(place, coefficients);
  }
  /// Changes each point's coefficients to change(coefficients).
  template <typename Change>
  void change(const Change& change) {
    for (int k = 0; k < count_; ++k) {
      Vector3& of_point = coefficients_[static_cast<std::size_t>(k)];
      of_point = change(of_point);
    }
  }
  /// Component `c` as a bend. The others of its points repeat the first one.
  PatchBend bend(Eigen::Index c, double stiffness) const {
    PatchBend bend{{}, {}, stiffness};
    bend.points.fill(points_[0]);
    for (std::size_t k = 0; k < static_cast<std::size_t>(count_); ++k) {
      bend.points[k] = points_[k];
      bend.coefficients[k] = coefficients_[k][c];
    }
    return bend;
  }

 private:
  void append(int point) {
    points_[static_cast<std::size_t>(count_)] = point;
    coefficients_[static_cast<std::size_t>(count_++)].setZero();
  }

  std::array<int, PatchBend::size> points_{};
  std::array<Vector3, PatchBend::size> coefficients_;
  int count_ = 0;
};

/// n n^T as curvatures uu, vv and uv.
Vector3 squared(const Flat& n) { return {n.x() * n.x(), n.y() * n.y(), n.x() * n.y()}; }

bool resists_bending(const Material* material) {
  const auto& [warp, weft] = material->fabric->bending_stiffness;
  return material->springs[static_cast<std::size_t>(SpringFamily::bending)] && warp + weft > 0;
}

class Bends {
 public:
  Bends(const ClothMesh& mesh, const std::vector<MeshEdge>& edges, TriangleFabric& fabric)
      : mesh_(mesh), edges_(edges), fabric_(fabric) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const bool may_be_bent = mesh.is_curved(static_cast<int>(t));
      bent_.push_back(may_be_bent ? places(t, across(t)) : std::nullopt);
    }
    for (std::size_t e = 0; e < edges.size(); ++e) slopes_.push_back(slope_of(e));
  }

  void add(std::size_t t, const Material& material) const {
    if (!material.springs[static_cast<std::size_t>(SpringFamily::bending)]) return;
    const auto& [warp, weft] = material.fabric->bending_stiffness;
    const std::array<double, 3> by_area{warp, weft, 2 * std::sqrt(warp * weft)};
    const std::vector<Across> neighbours = across(t);
    if (neighbours.empty()) return;
    const Curvatures curvatures = curvatures_of(t, neighbours);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double stiffness = fabric_.triangles[t].area * by_area[static_cast<std::size_t>(c)];
      if (stiffness == 0) continue;
      PatchBend bend = curvatures.bend(c, stiffness);
      if (bent_[t]) keep_curvature(*bent_[t], bend);
      fabric_.bends.push_back(bend);
    }
  }

 private:
  using Places = std::array<Vector3, PatchBend::near>;

  /// Place of a point in a triangle.
  std::size_t corner_of(std::size_t t, int point) const {
    const std::array<int, 3>& corners = mesh_.triangles[t];
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), point) -
                                    corners.begin());
  }
  std::size_t edge_number(std::size_t t, std::size_t k) const {
    return static_cast<std::size_t>(fabric_.triangles[t].edges[k]);
  }

  /// The points across the edges, each laid into the triangle's plane by the rest shape of its own
  /// triangle: both may be in different panels.
  std::vector<Across> across(std::size_t t) const {
    const FlatTriangle& flat = mesh_.flat[t];
    std::vector<Across> all;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& both = edges_[edge_number(t, k)].triangles;
      const int other = both[0] == static_cast<int>(t) ? both[1] : both[0];
      if (other < 0) continue;
      const auto o = static_cast<std::size_t>(other);
      const FlatTriangle& there = mesh_.flat[o];
      const std::size_t a = corner_of(o, mesh_.triangles[t][k]),
                        b = corner_of(o, mesh_.triangles[t][(k + 1) % 3]), far = 3 - a - b;
      const Flat side = there[b] - there[a], to = there[far] - there[a];
      const double share = side.dot(to) / side.squaredNorm();
      const double height = std::abs(cross(side, to)) / side.norm();
      all.push_back({k, mesh_.triangles[o][far], height, flat[k] + share * edge(flat, k)});
    }
    return all;
  }

  /// Slope across an edge towards its second triangle, by the heights of points [1/m]; none at a
  /// free edge.
  std::vector<PointShare> slope_of(std::size_t e) const {
    const auto& [a, b] = edges_[e].points;
    const auto& both = edges_[e].triangles;
    if (both[1] < 0) return {};
    // In panels that are sewn together the edge may have two lengths.
    const double length = (length_of(e, 0) + length_of(e, 1)) / 2;
    std::vector<PointAtEdge> points{{a, {-0.5, 0}}, {b, {0.5, 0}}}, farther;
    for (const int side : {0, 1}) {
      const auto t = static_cast<std::size_t>(both[static_cast<std::size_t>(side)]);
      const FlatTriangle& flat = mesh_.flat[t];
      const std::size_t from = corner_of(t, a), to = corner_of(t, b), far = 3 - from - to;
      const std::size_t k = (from + 1) % 3 == to ? from : to;
      const Flat along = flat[to] - flat[from], middle = (flat[to] + flat[from]) / 2;
      const Flat across_edge = outward_normal(flat, k) * (side == 0 ? 1 : -1);
      const auto add = [&](int point, const Flat& place, std::vector<PointAtEdge>& list) {
        const Flat at = place - middle;
        list.push_back(
            {point, {at.dot(along) / along.squaredNorm(), at.dot(across_edge) / length}});
      };
      add(mesh_.triangles[t][far], flat[far], points);
      for (const Across& n : across(t)) {
        if (n.edge != k) add(n.point, n.place(flat), farther);
      }
    }
    // Bends of a curved triangle have no points but those of its neighbours.
    const auto is_bent = [&](int t) { return bent_[static_cast<std::size_t>(t)].has_value(); };
    if (is_bent(both[0]) || is_bent(both[1])) farther.clear();
    for (const PointAtEdge& more : farther) {
      const auto is_same = [&](const PointAtEdge& p) { return p.point == more.point; };
      if (std::none_of(points.begin(), points.end(), is_same)) points.push_back(more);
    }
    std::vector<PointShare> slope = slope_across(points);
    for (PointShare& share : slope) share.share /= length;
    return slope;
  }

  /// Length of an edge in its first or second triangle [m].
  double length_of(std::size_t e, std::size_t side) const {
    const auto t = static_cast<std::size_t>(edges_[e].triangles[side]);
    const auto& [a, b] = edges_[e].points;
    return (mesh_.flat[t][corner_of(t, b)] - mesh_.flat[t][corner_of(t, a)]).norm();
  }

  Curvatures curvatures_of(std::size_t t, const std::vector<Across>& neighbours) const {
    const FlatTriangle& flat = mesh_.flat[t];
    Curvatures all(mesh_.triangles[t], neighbours);
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      const Across& n = neighbours[i];
      // The slope at the edge less that of the triangle, outwards.
      const Vector3 by_slope = edge(flat, n.edge).norm() / fabric_.triangles[t].area *
                               squared(outward_normal(flat, n.edge));
      const std::size_t e = edge_number(t, n.edge);
      const double out = edges_[e].triangles[0] == static_cast<int>(t) ? 1 : -1;
      for (const auto& [point, share] : slopes_[e]) {
        const Vector3 coefficients = out * share * by_slope;
        if (point == n.point) {
          all.add_to_place(3 + i, coefficients);
        } else {
          all.add(point, coefficients);
        }
      }
      add_own_slope(t, n.edge, -by_slope, all);
    }
    if (neighbours.size() == 2) {
      close_free_edge(t, 3 - neighbours[0].edge - neighbours[1].edge, all);
    }
    return all;
  }

  /// Adds `factor` times the slope of a triangle outwards at its edge k [1/m].
  void add_own_slope(std::size_t t, std::size_t k, const Vector3& factor, Curvatures& all) const {
    const std::array<int, 3>& corners = mesh_.triangles[t];
    const FlatTriangle& flat = mesh_.flat[t];
    const Flat side = edge(flat, k), to = flat[(k + 2) % 3] - flat[k];
    const double foot = side.dot(to) / side.squaredNorm();
    const Vector3 by_height = side.norm() / (2 * fabric_.triangles[t].area) * factor;
    all.add(corners[k], (1 - foot) * by_height);
    all.add(corners[(k + 1) % 3], foot * by_height);
    all.add(corners[(k + 2) % 3], -by_height);
  }

  /// A free edge has no kink, so that the curvature across it is free. But curvature along it and
  /// twist also change the triangle's own slope there: the kink that undoes this is added. Without
  /// a moment across the edge this is exact for equal stiffness in warp and weft. A triangle with
  /// two free edges stays as it is.
  void close_free_edge(std::size_t t, std::size_t k, Curvatures& all) const {
    const FlatTriangle& flat = mesh_.flat[t];
    const double length = edge(flat, k).norm(), height = 2 * fabric_.triangles[t].area / length;
    if (height_ratio(flat) < least_height_ratio) return;
    const Flat u = edge(flat, k) / length, n = outward_normal(flat, k);
    const double foot = (flat[(k + 2) % 3] - (flat[k] + flat[(k + 1) % 3]) / 2).dot(u);
    all.change([&](const Vector3& c) -> Vector3 {
      const double along = c[0] * u.x() * u.x() + c[1] * u.y() * u.y() + 2 * c[2] * u.x() * u.y();
      const double twist =
          c[0] * u.x() * n.x() + c[1] * u.y() * n.y() + c[2] * (u.x() * n.y() + u.y() * n.x());
      const double slope =
          along * (foot * foot - length * length / 4) / (2 * height) - twist * foot;
      return c + 2 / height * slope * squared(n);
    });
  }

  /// The points of a bend with the lengths of the rest shape and the angles of the start; none
  /// where it is flat.
  std::optional<Places> places(std::size_t t, const std::vector<Across>& neighbours) const {
    const FlatTriangle& flat = mesh_.flat[t];
    const auto lifted = [](const Flat& x, double z) { return Vector3(x.x(), x.y(), z); };
    const double side = cross(flat[1] - flat[0], flat[2] - flat[0]) > 0 ? 1 : -1;  // of the normal
    Places all;
    all.fill(lifted(flat[0], 0));
    std::array<Vector3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = row(mesh_.positions, mesh_.triangles[t][k]);
      all[k] = lifted(flat[k], 0);
    }
    bool is_flat = true;
    for (std::size_t n = 0; n < neighbours.size(); ++n) {
      const Across& a = neighbours[n];
      const double angle = angle_across(at, a.edge, row(mesh_.positions, a.point));
      const double offset = a.height * std::sin(angle);
      is_flat = is_flat && (std::abs(angle) < least_angle || std::abs(offset) < least_offset);
      const Flat out = a.height * std::cos(angle) * outward_normal(flat, a.edge);
      all[3 + n] = lifted(a.foot + out, side * offset);
    }
    if (is_flat) return std::nullopt;
    return all;
  }

  const ClothMesh& mesh_;
  const std::vector<MeshEdge>& edges_;
  TriangleFabric& fabric_;
  std::vector<std::optional<Places>> bent_;      // by triangle: see places()
  std::vector<std::vector<PointShare>> slopes_;  // by edge
};

}  // namespace

void add_mesh_bends(const ClothMesh& mesh, const std::vector<MeshEdge>& edges,
                    const std::vector<const Material*>& materials, TriangleFabric& fabric) {
  if (std::none_of(materials.begin(), materials.end(), resists_bending)) return;
  const Bends bends(mesh, edges, fabric);
  for (std::size_t t = 0; t < materials.size(); ++t) bends.add(t, *materials[t]);
}

}  // namespace clothsim
