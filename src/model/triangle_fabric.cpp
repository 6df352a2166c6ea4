#include "clothsim/model/triangle_fabric.h"

#include <Eigen/LU>
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>

#include "clothsim/model/cloth.h"
#include "clothsim/model/flat_triangle.h"
#include "clothsim/model/mesh_bends.h"
#include "clothsim/model/point_colours.h"
#include "clothsim/model/rest_curvature.h"
#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

using Flat = ClothMesh::Flat;
using PointTriple = std::array<int, 3>;

double area_of(const FlatTriangle& x) { return std::abs(cross(x[1] - x[0], x[2] - x[0])) / 2; }

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

/// K and Q: strains are R^-1 (q - Q) / 2, with the rows (D_x^2, D_y^2, D_x D_y) of R.
TriangleFabric::Triangle membrane(const FlatTriangle& flat, const Material& material) {
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
    const std::size_t count = bend.curvature != 0 ? PatchBend::near : PatchBend::size;
    for (std::size_t k = 0; k < count; ++k) {
      if (bend.coefficients[k] == 0 && bend.curvature == 0) continue;
      for (std::size_t l = k + 1; l < count; ++l) {
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
  add_mesh_bends(mesh, edges, material, *fabric);
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
