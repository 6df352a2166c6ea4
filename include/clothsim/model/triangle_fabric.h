#pragma once

#include <array>
#include <vector>

#include "clothsim/model/cloth_mesh.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// A stencil of bending of a triangle and its neighbours: the energy k |b - B n|^2 / 2, with b the
/// sum of c_i x_i, coefficients c of sum 0, the curvature at rest B and the triangle's normal n.
struct PatchBend {
  enum { near = 6, size = 12 };
  /// The triangle's corners, the points across its edges, and those that correct the slopes at
  /// these edges: see slope_across(). Places without a point repeat the first corner. Bends of
  /// triangles that are curved at rest have at most `near` points.
  std::array<int, size> points;
  std::array<double, size> coefficients;  // [1/m^2]; 0 for repeated points
  double stiffness;                       // [N m^3]
  double curvature = 0;                   // B [1/m]
  double softening = 0;                   // of n, see SmoothNormal [m^2]

  double coefficient(std::size_t k) const { return coefficients[k]; }
  Vector3 of(const Points& values) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < points.size(); ++k) {
      sum += coefficients[k] * values.row(points[k]).transpose();
    }
    return sum;
  }
  /// b - B n at these positions [1/m].
  Vector3 deviation(const Points& positions) const;
  /// Its derivative there, times velocities [m/s] or displacements [m].
  Vector3 rate(const Points& positions, const Points& rates) const;
};

/// A triangle that is curved at rest: the terms with n of the energy of its bends,
/// S |n|^2 / 2 - n . (sum of g_i x_i).
struct CurvedTriangle {
  std::array<int, PatchBend::near> points;      // as the first of its bends
  std::array<double, PatchBend::near> weights;  // g: sums of k B c [N]
  double stiffness;                             // S: sum of k B^2 [N m]
  double softening;                             // of n, see SmoothNormal [m^2]
  std::array<int, 15> pairs;  // of points k < l in order, in TriangleFabric::pairs; -1: one point
};

/// A fabric on a mesh: an orthotropic St. Venant-Kirchhoff membrane, and bending.
///
/// Membrane. Green's strain of a triangle is linear in the squared lengths q of its edges: an edge
/// D at rest has q - |D|^2 = 2 D^T E D. So the energy is (q - Q)^T K (q - Q) / 2 with a constant
/// K, and edge k pulls its ends together by the force 2 s_k d_k, s = K (q - Q) (Delingette 2008,
/// "Triangular springs for modeling nonlinear membranes"). The moduli are those of the fabric on a
/// grid: C11 and C22 are the stretch stiffness, C12 and the shear modulus the shear stiffness.
///
/// Bending. The curvatures of a triangle of area A are those of Gauss's theorem with one slope at
/// each edge for both of its triangles: the sum of l (s - s_T) n n^T / A over the edges, of length
/// l and normal n, with the slopes s across the edge's middle and s_T of the triangle itself. In
/// Onate & Cervera 1993, "Derivation of thin plate bending elements with one degree of freedom per
/// node", s is the mean of both triangles'; here slope_across(). As s is shared, a constant moment
/// is in equilibrium on any mesh; where s is exact for quadratic surfaces, so are curvatures. A
/// free edge has no kink, but for curvature along it and twist. The energy by area is that of the
/// grid, see add_fabric(). Where the rest shape is flat it is quadratic, as s is linear in
/// positions; triangles that are curved at rest (ClothMesh::curved) have that of the difference to
/// their curvature, see PatchBend and keep_curvature(), with the slopes of four points: on uneven
/// meshes they are too stiff, by a share that does not fall with the size of cells
/// (docs/limits.md).
struct TriangleFabric {
  struct Triangle {
    std::array<int, 3> edges;  // by number; edge k joins corners k and k + 1
    Vector3 rest2;             // Q: their squared lengths at rest [m^2]
    Eigen::Matrix3d stretch;   // K [N/m^3]
    Eigen::Matrix3d products;  // by edge: D_x^2, D_y^2, D_x D_y, x along warp [m^2]
    double area;               // at rest [m^2]
    double mass;               // of each third [kg]
  };
  /// Two points i < j that bends join: the terms w |x_i - x_j|^2 / 2 of their energy.
  struct Pair {
    int i;
    int j;
    double weight;  // [N/m], of either sign
  };
  /// Eight triangles side by side, as kernels take them. Lanes without a triangle have no
  /// stiffness.
  struct Block {
    static constexpr int size = 8;  // numbers in the widest vector
    template <typename Number>
    using Lanes = std::array<Number, size>;

    std::array<Lanes<int>, 3> edges;
    std::array<Lanes<double>, 3> rest2;    // Q [m^2]
    std::array<Lanes<double>, 6> stretch;  // K: 00, 11, 22, 01, 02, 12 [N/m^3]
  };
  /// Edge `number` from a point to another one.
  struct EdgeLink {
    int other;
    int number;
  };
  /// Pairs of each point that are no edges: those of point i from first[i] up to first[i + 1].
  struct BendLinks {
    std::vector<int> others;
    std::vector<double> weights;  // [N/m]
    std::vector<int> first;
  };
  /// A curved triangle of a point, and its place there.
  struct CurvedLink {
    int curved;
    int place;
  };
  struct Piece {
    int first_point;                         // its lowest
    double weight;                           // sum of those of its pairs [N/m]
    std::array<double, 2> internal_damping;  // [s] of its membrane and of its bends, see Fabric
  };

  std::vector<std::array<int, 2>> edges;     // ends a < b, in the order of cloth.springs
  std::vector<std::array<int, 2>> pulls_of;  // by edge: pull_number() of both sides, or no_pull()
  std::vector<Triangle> triangles;           // as cloth.triangles
  std::vector<PatchBend> bends;
  std::vector<Pair> pairs;  // of bends; first those of edges, in their order
  std::vector<CurvedTriangle> curved;
  std::vector<CurvedLink> curved_links;  // of point 0, point 1 ..
  std::vector<int> first_curved_links;   // by point, and one past all; empty: none is curved
  std::vector<Piece> pieces;             // joined by triangles
  std::vector<int> piece_ids;            // by point

  // For kernels, see add_kernel_arrays().
  std::vector<Block> blocks;         // of `triangles`
  std::vector<double> edge_weights;  // by edge: those of bends [N/m]
  std::vector<double> edge_damping;  // by edge: twice the internal damping of the membrane [s]
  std::vector<EdgeLink> edge_links;  // of point 0, point 1 ..
  std::vector<int> first_links;      // by point, and one past all
  BendLinks bend_links;

  /// Number of the pull of edge k of a triangle, among those of all blocks.
  static int pull_number(int triangle, int k) {
    return Block::size * (3 * (triangle / Block::size) + k) + triangle % Block::size;
  }
  int num_blocks() const {
    return (static_cast<int>(triangles.size()) + Block::size - 1) / Block::size;
  }
  int no_pull() const { return 3 * Block::size * num_blocks(); }

  int piece_of(int point) const { return piece_ids[static_cast<std::size_t>(point)]; }
  const std::array<double, 2>& internal_damping_at(int point) const {
    return pieces[static_cast<std::size_t>(piece_of(point))].internal_damping;
  }
};

struct Cloth;

/// The cloth of a mesh: spec.mesh, with spec.material.fabric, or those of spec.parts. A point has a
/// third of the mass of each of its triangles. Its springs are the edges, for the strain limit:
/// `stiffness` is that of the edge while all others keep their length. Springs of one batch share
/// no point.
void add_triangle_fabric(const ClothSpec& spec, Cloth& cloth);

/// Its arrays for kernels: blocks, and all by edge and by point, from the others.
void add_kernel_arrays(int points, TriangleFabric&);

}  // namespace clothsim
