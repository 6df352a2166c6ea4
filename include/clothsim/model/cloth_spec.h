#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// The three spring families of a grid cloth (Provot 1995).
enum class SpringFamily { structural, shear, bending };

inline constexpr std::array<const char*, 3> spring_family_names = {"structural", "shear",
                                                                   "bending"};

/// What may change while a cloth moves; applied between frames.
struct Material {
  double ks = 5000;                               // [N/m] stiffness of structural and shear springs
  double density = 150;                           // [kg/m^2]
  double damping = 5.4;                           // [1/s] drag rate c in m x'' = F - c m x'
  std::optional<double> strain_limit = 0.1;       // longest spring = (1 + limit) * rest length
  std::array<bool, 3> springs{true, true, true};  // families switched on, by SpringFamily
};

/// A grid point held in place, or moved by a tf frame.
struct Pin {
  int column = 0;
  int row = 0;
  std::string frame;  // tf frame the pin follows with its start offset; empty: it stays
};

enum class Orientation { horizontal, vertical };

/// What a cloth does where it meets itself: passes through, keeps its points apart, or its surface;
/// `automatic` takes points where they are enough.
enum class SelfCollision { off, points, surface, automatic };

inline constexpr std::array<const char*, 4> self_collision_names = {"off", "points", "surface",
                                                                    "automatic"};

/// A rectangular grid cloth as a scene describes it.
struct ClothSpec {
  double width = 1;   // [m] along x
  double height = 1;  // [m] horizontal: along y; vertical: along z, row 0 lowest
  int columns = 50;
  int rows = 50;
  Orientation orientation = Orientation::horizontal;
  Vector3 origin{0, 0, 1};  // [m] of point (0, 0)
  std::vector<Pin> pinned;
  Material material;
  double thickness = 0.0095;  // [m] half the distance at which two points of the cloth touch
  SelfCollision self_collision = SelfCollision::off;
  double friction = 0.3;  // Coulomb's coefficient of the cloth on itself
};

/// Throw InvalidValue, with keys relative to the cloth ({"ks"}, {"pinned", "1"}).
void validate(const Material&);
void validate(const ClothSpec&);

}  // namespace clothsim
