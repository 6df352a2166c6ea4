#include "clothsim/model/triangle_fabric.h"

#include <Eigen/LU>
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "clothsim/model/cloth.h"
#include "clothsim/model/point_colours.h"
#include "clothsim/model/rest_curvature.h"
#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

using Flat = ClothMesh::Flat;
using PointTriple = std::array<int, 3>;

double cross(const Flat& a, const Flat& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_of(const std::array<Flat, 3>& x) {
  return std::abs(cross(x[1] - x[0], x[2] - x[0])) / 2;
}

/// C of the fabric, for strains along warp, along weft and the shear angle.
Eigen::Matrix3d moduli(const Material& material) {
  const auto has = [&](SpringFamily family) {
    return material.springs[static_cast<std::size_t>(family)];
  };
  const Fabric& fabric = *material.fabric;
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  if (has(SpringFamily::structural)) {
    c(0, 0) = fabric.stretch_stiffness[0];
    c(1, 1) = fabric.stretch_stiffness[1];
    c(0, 1) = c(1, 0) = fabric.poisson * std::sqrt(c(0, 0) * c(1, 1));
  }
  if (has(SpringFamily::shear)) c(2, 2) = fabric.shear_stiffness;
  return c;
}

/// Edge k of a triangle, from corner k to corner k + 1.
Flat edge(const std::array<Flat, 3>& x, std::size_t k) { return x[(k + 1) % 3] - x[k]; }

/// K and Q: strains are R^-1 (q - Q) / 2, with the rows (D_x^2, D_y^2, D_x D_y) of R.
TriangleFabric::Triangle membrane(const std::array<Flat, 3>& flat, const Material& material) {
  TriangleFabric::Triangle triangle{};
  Eigen::Matrix3d r;
  for (std::size_t k = 0; k < 3; ++k) {
    const Flat d = edge(flat, k);
    r.row(static_cast<Eigen::Index>(k)) << d.x() * d.x(), d.y() * d.y(), d.x() * d.y();
    triangle.rest2[static_cast<Eigen::Index>(k)] = d.squaredNorm();
  }
  const double area = area_of(flat);
  const Eigen::Matrix3d inverse = r.inverse();
  const Eigen::Matrix3d stretch = area / 4 * inverse.transpose() * moduli(material) * inverse;
  triangle.stretch = (stretch + stretch.transpose()) / 2;
  triangle.products = r;
  triangle.area = area;
  triangle.mass = material.density * area / 3;
  return triangle;
}

/// The point across an edge of a triangle, laid into its plane.
struct Across {
  std::size_t edge;
  int point;       // of the cloth
  double height;   // of its place over the edge [m]
  Vector3 shares;  // barycentric coordinates of its place
  Flat foot;       // of its place on the edge's line
};

Flat outward_normal(const std::array<Flat, 3>& x, std::size_t k) {
  const Flat along = edge(x, k).normalized();
  const Flat normal(along.y(), -along.x());
  return normal.dot(x[(k + 2) % 3] - x[k]) > 0 ? Flat(-normal) : normal;
}

class Bends {
 public:
  Bends(const ClothMesh& mesh, const std::vector<MeshEdge>& edges, TriangleFabric& fabric)
      : mesh_(mesh), edges_(edges), fabric_(fabric) {}

  void add(int t, const Material& material) const {
    if (!material.springs[static_cast<std::size_t>(SpringFamily::bending)]) return;
    const auto& [warp, weft] = material.fabric->bending_stiffness;
    const std::array<double, 3> by_area{warp, weft, 2 * std::sqrt(warp * weft)};
    const std::array<Flat, 3>& flat = mesh_.flat[static_cast<std::size_t>(t)];
    const std::vector<Across> neighbours = across(t);
    if (neighbours.empty()) return;
    const Eigen::Matrix3d curvatures = by_kinks(flat, neighbours);
    const std::optional<Places> bent = mesh_.is_curved(t) ? places(t, neighbours) : std::nullopt;
    const PointTriple& corners = mesh_.triangles[static_cast<std::size_t>(t)];
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double stiffness = area_of(flat) * by_area[static_cast<std::size_t>(c)];
      if (stiffness == 0) continue;
      PatchBend bend{{}, {}, stiffness};
      bend.points.fill(corners[0]);
      std::copy(corners.begin(), corners.end(), bend.points.begin());
      for (std::size_t n = 0; n < neighbours.size(); ++n) {
        const double share = curvatures(c, static_cast<Eigen::Index>(n));
        bend.points[3 + n] = neighbours[n].point;
        bend.coefficients[3 + n] = share;
        for (std::size_t k = 0; k < 3; ++k) {
          bend.coefficients[k] -= share * neighbours[n].shares[static_cast<Eigen::Index>(k)];
        }
      }
      if (bent) keep_curvature(*bent, bend);
      fabric_.bends.push_back(bend);
    }
  }

 private:
  /// The points across the edges, each laid into the triangle's plane by the rest shape of its own
  /// triangle: both may be in different panels.
  std::vector<Across> across(int t) const {
    const PointTriple& corners = mesh_.triangles[static_cast<std::size_t>(t)];
    const std::array<Flat, 3>& flat = mesh_.flat[static_cast<std::size_t>(t)];
    std::vector<Across> all;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto e =
          static_cast<std::size_t>(fabric_.triangles[static_cast<std::size_t>(t)].edges[k]);
      const auto& both = edges_[e].triangles;
      const int other = both[0] == t ? both[1] : both[0];
      if (other < 0) continue;
      const PointTriple& others = mesh_.triangles[static_cast<std::size_t>(other)];
      const std::array<Flat, 3>& there = mesh_.flat[static_cast<std::size_t>(other)];
      const auto place_of = [&](int point) {
        return static_cast<std::size_t>(std::find(others.begin(), others.end(), point) -
                                        others.begin());
      };
      const std::size_t a = place_of(corners[k]), b = place_of(corners[(k + 1) % 3]);
      const std::size_t far = 3 - a - b;
      const Flat side = there[b] - there[a], to = there[far] - there[a];
      const double share = side.dot(to) / side.squaredNorm();
      const double height = std::abs(cross(side, to)) / side.norm();
      const Flat foot = flat[k] + share * edge(flat, k);
      Across found{k, others[far], height, {}, foot};
      const Flat place = foot + height * outward_normal(flat, k);
      const double whole = cross(flat[1] - flat[0], flat[2] - flat[0]);
      for (std::size_t i = 0; i < 3; ++i) {
        found.shares[static_cast<Eigen::Index>(i)] =
            cross(flat[(i + 1) % 3] - place, flat[(i + 2) % 3] - place) / whole;
      }
      all.push_back(found);
    }
    return all;
  }

  using Places = std::array<Vector3, PatchBend::size>;

  /// The points of a bend with the lengths of the rest shape and the angles of the start; none
  /// where it is flat.
  std::optional<Places> places(int t, const std::vector<Across>& neighbours) const {
    const PointTriple& corners = mesh_.triangles[static_cast<std::size_t>(t)];
    const std::array<Flat, 3>& flat = mesh_.flat[static_cast<std::size_t>(t)];
    const auto lifted = [](const Flat& x, double z) { return Vector3(x.x(), x.y(), z); };
    const double side = cross(flat[1] - flat[0], flat[2] - flat[0]) > 0 ? 1 : -1;  // of the normal
    Places all;
    all.fill(lifted(flat[0], 0));
    std::array<Vector3, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = row(mesh_.positions, corners[k]);
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

  /// Curvatures uu, vv and uv from the distances of the points across an edge from the triangle's
  /// plane, a column each: see TriangleFabric.
  static Eigen::Matrix3d by_kinks(const std::array<Flat, 3>& flat,
                                  const std::vector<Across>& neighbours) {
    Eigen::Matrix3d columns = Eigen::Matrix3d::Zero();
    Eigen::Index n = 0;
    for (const Across& a : neighbours) {
      const Flat normal = outward_normal(flat, a.edge);
      const double share = edge(flat, a.edge).norm() / (2 * area_of(flat) * a.height);
      columns.col(n++) << share * normal.x() * normal.x(), share * normal.y() * normal.y(),
          share * normal.x() * normal.y();
    }
    return columns;
  }

  const ClothMesh& mesh_;
  const std::vector<MeshEdge>& edges_;
  TriangleFabric& fabric_;
};

/// The material of each triangle.
std::vector<const Material*> materials(const ClothSpec& spec) {
  std::vector<const Material*> all(spec.mesh->triangles.size(), &spec.material);
  for (const ClothPart& part : spec.parts) {
    std::fill_n(all.begin() + part.first_triangle, part.triangles, &part.material);
  }
  return all;
}

/// Sorts edges into batches that share no point. Returns the batch of each edge.
std::vector<int> sort_into_batches(int points, std::vector<MeshEdge>& edges) {
  PointColours colours(points);
  std::vector<std::pair<std::size_t, MeshEdge>> sorted;
  for (const MeshEdge& edge : edges) sorted.emplace_back(colours.next(edge.points), edge);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<int> batches;
  edges.clear();
  for (const auto& [batch, edge] : sorted) {
    batches.push_back(static_cast<int>(batch));
    edges.push_back(edge);
  }
  return batches;
}

/// Numbers the edges of triangles, and the pulls of edges.
void connect(const ClothMesh& mesh, const std::vector<MeshEdge>& edges, TriangleFabric& fabric) {
  for (std::size_t e = 0; e < edges.size(); ++e) {
    std::array<int, 2> pulls{fabric.no_pull(), fabric.no_pull()};
    for (std::size_t side = 0; side < 2; ++side) {
      const int t = edges[e].triangles[side];
      if (t < 0) continue;
      const PointTriple& corners = mesh.triangles[static_cast<std::size_t>(t)];
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [a, b] = std::minmax(corners[k], corners[(k + 1) % 3]);
        if (std::array<int, 2>{a, b} != edges[e].points) continue;
        fabric.triangles[static_cast<std::size_t>(t)].edges[k] = static_cast<int>(e);
        pulls[side] = TriangleFabric::pull_number(t, static_cast<int>(k));
      }
    }
    fabric.edges.push_back(edges[e].points);
    fabric.pulls_of.push_back(pulls);
  }
}

/// |sum of c_i x_i|^2 of coefficients whose sum is zero is the sum of -c_i c_j |x_i - x_j|^2.
void add_pairs(TriangleFabric& fabric) {
  std::map<std::array<int, 2>, double> weights;
  for (const PatchBend& bend : fabric.bends) {
    for (std::size_t k = 0; k < bend.points.size(); ++k) {
      for (std::size_t l = k + 1; l < bend.points.size(); ++l) {
        const double weight = -bend.stiffness * bend.coefficients[k] * bend.coefficients[l];
        const auto [i, j] = std::minmax(bend.points[k], bend.points[l]);
        if ((weight != 0 || bend.curvature != 0) && i != j) weights[{i, j}] += weight;
      }
    }
  }
  if (weights.empty()) return;
  for (const auto& ends : fabric.edges) {
    const auto found = weights.find(ends);
    fabric.pairs.push_back({ends[0], ends[1], found == weights.end() ? 0 : found->second});
    if (found != weights.end()) weights.erase(found);
  }
  for (const auto& [ends, weight] : weights) fabric.pairs.push_back({ends[0], ends[1], weight});
}

void add_pieces(const ClothMesh& mesh, int points, TriangleFabric& fabric) {
  boost::disjoint_sets_with_storage<> groups(static_cast<std::size_t>(points));
  for (const PointTriple& t : mesh.triangles) {
    for (const std::size_t k : {1, 2}) {
      groups.union_set(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[k]));
    }
  }
  std::map<std::size_t, int> numbers;
  for (int i = 0; i < points; ++i) {
    const std::size_t group = groups.find_set(static_cast<std::size_t>(i));
    const auto [found, is_new] = numbers.emplace(group, static_cast<int>(numbers.size()));
    fabric.piece_ids.push_back(found->second);
    if (is_new) fabric.pieces.push_back({i, 0, {}});
  }
  for (const TriangleFabric::Pair& pair : fabric.pairs) {
    fabric.pieces[static_cast<std::size_t>(fabric.piece_of(pair.i))].weight += pair.weight;
  }
}

/// The edges as springs, each of the stiffness d(2 s l)/dl = 4 K_kk L^2 that its triangles give.
void add_springs(const TriangleFabric& fabric, const std::vector<int>& batches, Cloth& cloth) {
  Scalars stiffness = Scalars::Zero(static_cast<Eigen::Index>(fabric.edges.size()));
  Scalars rest2 = stiffness;
  for (const TriangleFabric::Triangle& triangle : fabric.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto c = static_cast<Eigen::Index>(k);
      const int e = triangle.edges[k];
      stiffness[e] += 4 * triangle.stretch(c, c) * triangle.rest2[c];
      rest2[e] = std::max(rest2[e], triangle.rest2[c]);
    }
  }
  for (std::size_t e = 0; e < fabric.edges.size(); ++e) {
    const auto& [a, b] = fabric.edges[e];
    const auto i = static_cast<Eigen::Index>(e);
    cloth.springs.push_back(
        {SpringFamily::structural, a, b - a, 1, std::sqrt(rest2[i]), stiffness[i], batches[e]});
  }
}

}  // namespace

Vector3 PatchBend::deviation(const Points& positions) const {
  const Vector3 b = of(positions);
  if (curvature == 0) return b;
  return b - curvature * SmoothNormal(*this, positions).normal();
}

Vector3 PatchBend::rate(const Points& positions, const Points& rates) const {
  const Vector3 b = of(rates);
  if (curvature == 0) return b;
  const SmoothNormal normal(*this, positions);
  return b - curvature *
                 normal.rate(row(rates, points[0]), row(rates, points[1]), row(rates, points[2]));
}

void add_triangle_fabric(const ClothSpec& spec, Cloth& cloth) {
  const ClothMesh& mesh = *spec.mesh;
  const auto n = static_cast<int>(mesh.positions.rows());
  const std::vector<const Material*> material = materials(spec);
  auto fabric = std::make_shared<TriangleFabric>();
  cloth.mass.setZero(n);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    fabric->triangles.push_back(membrane(mesh.flat[t], *material[t]));
    for (const int i : mesh.triangles[t]) cloth.mass[i] += fabric->triangles[t].mass;
  }
  std::vector<MeshEdge> edges = mesh_edges(mesh.triangles);
  const std::vector<int> batches = sort_into_batches(n, edges);
  connect(mesh, edges, *fabric);
  const Bends bends(mesh, edges, *fabric);
  for (std::size_t t = 0; t < material.size(); ++t) bends.add(static_cast<int>(t), *material[t]);
  add_pairs(*fabric);
  add_pieces(mesh, n, *fabric);
  add_curved_triangles(*fabric);
  add_springs(*fabric, batches, cloth);
  for (std::size_t t = 0; t < material.size(); ++t) {
    const auto piece = static_cast<std::size_t>(fabric->piece_of(mesh.triangles[t][0]));
    fabric->pieces[piece].internal_damping = material[t]->fabric->internal_damping;
  }
  add_kernel_arrays(n, *fabric);
  for (const TriangleFabric::Piece& piece : fabric->pieces) {
    for (std::size_t k = 0; k < 2; ++k) {
      cloth.internal_damping[k] = std::max(cloth.internal_damping[k], piece.internal_damping[k]);
    }
  }
  cloth.inv_mass = cloth.mass.cwiseInverse();
  cloth.triangle_fabric = std::move(fabric);
}

}  // namespace clothsim
