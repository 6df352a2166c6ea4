#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/model/cloth_mesh.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// The three spring families of a grid cloth (Provot 1995).
enum class SpringFamily { structural, shear, bending };

inline constexpr std::array<const char*, 3> spring_family_names = {"structural", "shear",
                                                                   "bending"};

/// A fabric as an orthotropic sheet with its threads along the grid, warp along rows and weft along
/// columns. Values are per width of the material and do not depend on the grid.
struct Fabric {
  /// Stiffness of each thread direction with the other one held [N/m], C11 and C22. With free width
  /// it is lower by the factor 1 - poisson^2.
  std::array<double, 2> stretch_stiffness{};
  double shear_stiffness = 0;                 // [N/m] shear force by angle
  std::array<double, 2> bending_stiffness{};  // [N m] moment per width by curvature
  /// Viscosity by stiffness [s], of stretch and shear, and of bending. An oscillation at omega has
  /// the share omega tau / 2 of critical damping; rigid motion is not damped.
  std::array<double, 2> internal_damping{};
  double poisson = 0;  // C12 / sqrt(C11 C22): geometric mean of both Poisson's ratios
};

/// Parameters that may change during the simulation; applied between frames.
struct Material {
  double ks = 5000;              // [N/m] stiffness of structural and shear springs
  std::optional<Fabric> fabric;  // instead of ks
  double density = 150;          // [kg/m^2]
  double damping = 5.4;          // [1/s] drag rate c in m x'' = F - c m x'
  /// Drag coefficients in air, for wind across and along the surface: see Air. A square plate
  /// across the wind has 1.17 (Hoerner 1965, Fluid-Dynamic Drag, 3-16); both sides of one along it
  /// some 0.02.
  std::array<double, 2> drag{1.17, 0.02};
  std::optional<double> strain_limit = 0.1;       // longest spring = (1 + limit) * rest length
  std::array<bool, 3> springs{true, true, true};  // families switched on, by SpringFamily
};

/// A point held in place, or moved by a tf frame. A mesh has all points in row 0.
struct Pin {
  int column = 0;
  int row = 0;
  std::string frame;  // tf frame the pin follows with its start offset; empty: it stays
  std::optional<double> strength{};  // [N] largest force; empty: pin_strength
};

/// Points that are attached to a rigid body, by its name.
struct BodyPoints {
  std::string body;
  std::vector<std::array<int, 2>> points;  // [column, row]
  std::optional<double> tear_force{};      // [N] beyond which all let go; empty: never
};

enum class Orientation { horizontal, vertical };

/// Contact of a cloth with itself: none, between its points, or between its surfaces; `automatic`
/// takes points where they are enough.
enum class SelfCollision { off, points, surface, automatic };

inline constexpr std::array<const char*, 4> self_collision_names = {"off", "points", "surface",
                                                                    "automatic"};

/// One of several cloths that are simulated as one: its points and triangles in their mesh.
struct ClothPart {
  std::string name;
  int first_point = 0;
  int columns = 1;  // points: columns * rows, from the first on; of a mesh all in one row
  int rows = 1;
  int first_triangle = 0;
  int triangles = 0;
  Material material{};
  double friction = 0;   // as in ClothSpec
  double thickness = 0;  // the same
  bool is_grid = false;
  bool is_vertical = false;  // a grid that starts upright
  double width = 0;          // of a grid [m]
  double height = 0;
  std::size_t first_attached = 0;                  // in ClothSpec::attached
  std::shared_ptr<const PatternPoints> pattern{};  // by its own numbers of points; null: none

  int num_points() const { return columns * rows; }
};

/// A cloth as a scene describes it: a rectangular grid, or a mesh of a fabric.
struct ClothSpec {
  std::shared_ptr<const ClothMesh> mesh{};  // null: a grid. A mesh has one row of `columns` points
  double width = 1;                         // [m] along x
  double height = 1;  // [m] horizontal: along y; vertical: along z, row 0 lowest
  int columns = 50;
  int rows = 50;
  Orientation orientation = Orientation::horizontal;
  Vector3 origin{0, 0, 1};  // [m] of point (0, 0)
  std::vector<Pin> pinned;
  std::vector<BodyPoints> attached;
  std::optional<double> pin_strength;  // [N] of pins without a strength; empty: default_strength()
  Material material;
  // [m] half the distance at which two points of the cloth touch; of several cloths that of the
  // first
  double thickness = 0.0095;
  SelfCollision self_collision = SelfCollision::off;
  double friction = 0.3;           // Coulomb's, between layers; of several cloths that of the first
  bool untangle = false;           // untangles a state that is set and crosses itself
  std::vector<ClothPart> parts{};  // of `mesh`, see join_cloths(); empty: one cloth
  std::shared_ptr<const PatternPoints> pattern{};  // of a mesh from a pattern; null: none
};

/// Sets in `to` the values that `after` has changed since `before`.
void take_changes(const Material& before, const Material& after, Material& to);

/// Largest force of a pin or a grip [N].
inline constexpr Range strength_range{1e-9, 1e12, "N"};
/// Force at which points tear off a grip [N].
inline constexpr Range tear_force_range{0, 1e12, "N"};

/// Throw InvalidValue, with keys relative to the cloth ({"ks"}, {"pinned", "1"}).
void validate(const Material&);
void validate(const ClothSpec&);

/// Throws InvalidValue unless the cloth has such a point.
void check_grid_point(const ClothSpec&, int column, int row);
std::string grid_point_text(int column, int row);

/// A point in a message: 12 of a mesh, [3, 4] of a grid, with its name one of several cloths.
std::string point_text(const ClothSpec&, int column, int row);

/// The same for a thickness [m] and a friction coefficient of a cloth.
void validate_contact(double thickness, double friction);

}  // namespace clothsim
