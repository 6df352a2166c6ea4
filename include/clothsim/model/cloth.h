#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "clothsim/model/cloth_spec.h"
#include "clothsim/model/triangle_fabric.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Gap between a collider and the points in contact with it [m], so that RViz shows the cloth on
/// top. A fabric has half its thickness, where that is more.
inline constexpr double surface_offset = 1e-4;

/// `count` equal springs between points first + i and first + i + offset. Springs that are
/// contiguous in memory share one entry, so that kernels vectorise.
struct SpringRun {
  SpringFamily family;
  int first;
  int offset;  // > 0
  int count;
  double rest_length;  // [m]
  double stiffness;    // [N/m]; 0 for diagonals of a fabric, which CellRun makes stiff
  int batch = 0;       // of a mesh: springs of one batch share no point
};

/// `count` equal stencils of bending, first + k for k in [0, count): stencil i has the energy k
/// |x_i - x_{i+a} - x_{i+b} + x_{i+a+b}|^2 / 2. With a = b this is a second difference along a
/// line; with a one step along a row and b one step along a column it is the twist of a cell. The
/// energy is zero for any flat cloth under uniform strain.
struct BendRun {
  int first;
  int a;
  int b;
  int count;
  double stiffness;  // [N/m]
};

/// The stencils (i, i + a, i + b, i + a + b) of all points i in [0, N - a - b), see BendRun.
struct BendBand {
  int a;
  int b;
  Scalars stiffness;  // [N/m], zero where there is none
};

/// A strain of a cell with the diagonals d_1 (to the corner across) and d_2 (from the second corner
/// to the third): c = p |d_1|^2 + q |d_2|^2 + r d_1 . d_2 - c_0. The products of the cell's mean
/// sides, and so Green's strains of the cell, have this form: the sides are (d_1 - d_2) / 2 and
/// (d_1 + d_2) / 2.
struct CellStrain {
  double p;
  double q;
  double r;
  double rest;  // c_0

  bool operator==(const CellStrain& other) const {
    return p == other.p && q == other.q && r == other.r && rest == other.rest;
  }
};

/// `count` equal cells of a fabric, with the corners i, i + a, i + b, i + a + b for i in [first,
/// first + count). Each has the energy k c^2 / 2.
struct CellRun {
  int first;
  int a;
  int b;
  int count;
  CellStrain strain;
  double stiffness;  // k
};

/// The cells of all points i in [0, N - a - b) with the same strain, see CellRun.
struct CellBand {
  int a;
  int b;
  CellStrain strain;
  Scalars stiffness;  // zero where there is none
};

/// The sum of all energies between points i and i + offset, i in [0, N - offset): a spring, and the
/// terms of bending stencils, which are quadratic in the points' difference: k (l - L0)^2 / 2 + w
/// l^2 / 2.
struct PairBand {
  int offset;          // > 0
  double rest_length;  // [m]
  Scalars spring;      // k [N/m], zero where there is none; empty: no springs
  Scalars bend;        // w [N/m], of either sign
};

/// Topology, rest lengths and masses of a cloth, a grid or a mesh. Constant during the simulation.
struct Cloth {
  int columns = 0;  // of a mesh: all points, in one row
  int rows = 0;
  Points rest_positions;                                  // [m], N x 3
  Eigen::Matrix<double, Eigen::Dynamic, 2> uv;            // texture coordinates in [0, 1], N x 2
  std::vector<std::array<int, 3>> triangles;              // counter-clockwise seen from the front
  std::vector<int> first_points;                          // of several cloths; empty: one
  std::vector<int> first_triangles;                       // the same
  std::vector<SpringRun> springs;                         // of the families switched on
  std::vector<BendRun> bends;                             // of a fabric
  std::vector<CellRun> cells;                             // of a fabric on a grid
  std::vector<BendBand> bend_bands;                       // the same: see set_bands()
  std::vector<PairBand> pairs;                            // the same
  std::vector<CellBand> cell_bands;                       // the same
  std::shared_ptr<const TriangleFabric> triangle_fabric;  // of a mesh, null for a grid
  Scalars mass;                                           // [kg], N
  Scalars inv_mass;                                       // [1/kg], N; zero at pins
  std::vector<int> pinned;                                // point ids, ascending
  double damping = 0;                                     // [1/s] of several cloths the least
  std::vector<double> dampings;                           // the same by cloth; empty: `damping`
  std::array<double, 2> drag{};              // across and along the surface: see AirForces
  std::vector<std::array<double, 2>> drags;  // the same by cloth; empty: `drag`
  std::array<double, 2> internal_damping{};  // [s] of springs and of bends, see Fabric; of several
                                             // cloths the largest: see internal_damping_at()
  std::optional<double> strain_limit;        // of several cloths the largest
  std::vector<std::optional<double>> strain_limits;   // the same by cloth; empty: `strain_limit`
  SelfCollision self_collision = SelfCollision::off;  // never automatic
  double friction = 0;                                // between layers
  Scalars frictions;                                  // the same by point, N; empty: `friction`
  double thickness = 0;  // [m] of several cloths the largest, for bounds
  Scalars thicknesses;   // the same by point [m], N; empty: `thickness`
  /// From colliders [m], of several cloths the largest. Less than `full_offset` while it grows.
  double offset = surface_offset;
  double full_offset = surface_offset;
  std::vector<char> held;  // by point: by a pin or a grip, also one that it slips from; empty: none

  int num_points() const { return static_cast<int>(rest_positions.rows()); }
  int num_springs() const;
  /// Number of the cloth that has a point.
  std::size_t cloth_of(int point) const;
  double damping_at(int i) const { return dampings.empty() ? damping : dampings[cloth_of(i)]; }
  /// Whether springs of all cloths have a limit.
  bool is_limited() const;
  std::optional<double> strain_limit_at(int i) const {
    return strain_limits.empty() ? strain_limit : strain_limits[cloth_of(i)];
  }
  double friction_at(int i) const { return frictions.size() > 0 ? frictions[i] : friction; }
  /// Coefficient between layers with these points: the geometric mean of both.
  double friction_between(int i, int j) const;
  double thickness_at(int i) const { return thicknesses.size() > 0 ? thicknesses[i] : thickness; }
  double min_thickness() const;
  /// Distance that a point keeps from colliders [m].
  double offset_at(int i) const {
    if (thicknesses.size() == 0) return offset;
    return std::min(offset, std::max(surface_offset, thicknesses[i]));
  }
  double min_offset() const { return std::min(offset, std::max(surface_offset, min_thickness())); }
  bool is_held(int i) const {
    return inv_mass[i] == 0 || (!held.empty() && held[static_cast<std::size_t>(i)] != 0);
  }
  /// How much nearer than `offset` a point comes to colliders [m].
  double nearer_by(int i) const { return thicknesses.size() > 0 ? offset - offset_at(i) : 0; }
  int num_bends() const;
  int num_links() const;  // springs with stiffness, strains of cells, and bends
  /// Internal damping of the springs, triangles and bends at a point [s].
  const std::array<double, 2>& internal_damping_at(int i) const {
    return is_mesh() ? triangle_fabric->internal_damping_at(i) : internal_damping;
  }

  /// Whether there are forces between its points.
  bool has_forces() const { return !springs.empty() || !bends.empty() || !cells.empty(); }
  bool is_mesh() const { return triangle_fabric != nullptr; }
  /// Whether it is a fabric on a grid: its bands have all of its forces.
  bool has_bands() const { return !pairs.empty() || !cell_bands.empty(); }
};

/// Whether it has internal damping.
inline bool is_damped(const Cloth& cloth) {
  return cloth.internal_damping != std::array<double, 2>{};
}

/// Whether all points have the same thickness in both.
bool has_same_thickness(const Cloth&, const Cloth&);

/// Sets the bands of a grid by its springs, bends and cells: bends by stencil, cells by strain, and
/// springs and bends by pairs of points.
void set_bands(Cloth&);

}  // namespace clothsim
