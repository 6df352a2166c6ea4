#include "clothsim/model/grid.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "clothsim/model/fabric.h"

namespace clothsim {
namespace {

/// Largest initial offset from the plane: [m], and as a share of a cell's shorter side.
constexpr double max_unevenness = 1e-3;
constexpr double uneven_share = 0.05;

/// Stiffness of bending springs by that of structural and shear ones.
constexpr double bending_ratio = 0.2;

/// A spring from point (column, row) to (column + columns, row + rows).
struct Direction {
  SpringFamily family;
  int columns;
  int rows;
};

constexpr Direction directions[] = {
    {SpringFamily::structural, 1, 0}, {SpringFamily::structural, 0, 1},
    {SpringFamily::shear, 1, 1},      {SpringFamily::shear, -1, 1},
    {SpringFamily::bending, 2, 0},    {SpringFamily::bending, 0, 2},
};

void append_runs(const ClothSpec& spec, const Direction& d, const Eigen::Vector2d& spacing,
                 std::vector<SpringRun>& springs) {
  const double rest_length = Eigen::Vector2d(d.columns * spacing.x(), d.rows * spacing.y()).norm();
  const bool bending = d.family == SpringFamily::bending;
  const double stiffness = spec.material.ks * (bending ? bending_ratio : 1.0);

  const int begin = std::max(0, -d.columns);
  const int count = spec.columns - std::abs(d.columns);
  if (count <= 0) return;

  for (int row = 0; row + d.rows < spec.rows; ++row) {
    const int first = row * spec.columns + begin;
    // A full row goes on where the one before it ended: one long run.
    const bool continues = count == spec.columns && row > 0;
    if (continues) {
      springs.back().count += count;
    } else {
      springs.push_back(
          {d.family, first, d.rows * spec.columns + d.columns, count, rest_length, stiffness});
    }
  }
}

/// Springs of the families switched on, and equal masses.
void add_classic(const ClothSpec& spec, const Eigen::Vector2d& spacing, Cloth& cloth) {
  for (const Direction& d : directions) {
    if (spec.material.springs[static_cast<std::size_t>(d.family)]) {
      append_runs(spec, d, spacing, cloth.springs);
    }
  }
  const double point_mass =
      spec.width * spec.height * spec.material.density / (spec.columns * spec.rows);
  cloth.mass.setConstant(point_mass);
  cloth.inv_mass.setConstant(1 / point_mass);
}

/// Contacts between points at less than this many edge lengths let other points through.
constexpr double min_touch = 0.9;

/// Contacts between points at more than this many edge lengths leave out so many neighbours, see
/// NearestDistances, that folds go undetected.
constexpr double max_touch = 2;

/// Largest compression of the lowest edge of a hanging column under its weight: beyond it,
/// neighbours pass each other undetected, as neighbours have no contact.
constexpr double max_pressed = 0.5;

/// Whether points suffice, by scenes that were tried: cloths that fold under their own weight had
/// no crossing, softer and thinner ones did.
SelfCollision resolve_self_collision(const ClothSpec& spec, const Eigen::Vector2d& spacing,
                                     double gravity) {
  if (spec.self_collision != SelfCollision::automatic) return spec.self_collision;
  const double edge = spacing.maxCoeff();
  const double weight = spec.material.density * spec.height * edge * gravity;
  const double touch = 2 * spec.thickness / edge;
  const bool dense = touch >= min_touch && touch <= max_touch;
  const auto& fabric = spec.material.fabric;
  const double stiffness = fabric ? fabric->stretch_stiffness[1] : spec.material.ks;
  const bool stiff = weight <= max_pressed * stiffness * edge;
  const bool has_surface = spec.columns > 1 && spec.rows > 1;
  return (dense && stiff) || !has_surface ? SelfCollision::points : SelfCollision::surface;
}

/// Rest positions and texture coordinates.
void add_points(const ClothSpec& spec, const Eigen::Vector2d& spacing, Cloth& cloth) {
  const int n = spec.columns * spec.rows;
  const int up = spec.orientation == Orientation::horizontal ? 1 : 2;
  cloth.rest_positions = spec.origin.transpose().replicate(n, 1);
  cloth.uv.resize(n, 2);
  for (int row = 0; row < spec.rows; ++row) {
    for (int column = 0; column < spec.columns; ++column) {
      const int i = row * spec.columns + column;
      cloth.rest_positions(i, 0) += column * spacing.x();
      cloth.rest_positions(i, up) += row * spacing.y();
      cloth.uv(i, 0) = spec.columns > 1 ? double(column) / (spec.columns - 1) : 0;
      cloth.uv(i, 1) = spec.rows > 1 ? double(row) / (spec.rows - 1) : 0;
    }
  }
}

/// Two triangles a cell.
void add_triangles(const ClothSpec& spec, Cloth& cloth) {
  for (int row = 0; row + 1 < spec.rows; ++row) {
    for (int column = 0; column + 1 < spec.columns; ++column) {
      const int i = row * spec.columns + column;
      const int above = i + spec.columns;
      cloth.triangles.push_back({i, i + 1, above + 1});
      cloth.triangles.push_back({i, above + 1, above});
    }
  }
}

}  // namespace

void set_common(const ClothSpec& spec, Cloth& cloth) {
  cloth.damping = spec.material.damping;
  cloth.drag = spec.material.drag;
  cloth.strain_limit = spec.material.strain_limit;
  cloth.thickness = spec.thickness;
  if (spec.material.fabric) cloth.full_offset = std::max(surface_offset, spec.thickness);
  cloth.offset = cloth.full_offset;
  cloth.friction = spec.friction;
  // A pin is a point of infinite mass.
  for (const Pin& pin : spec.pinned) {
    cloth.pinned.push_back(pin.row * spec.columns + pin.column);
    cloth.inv_mass[cloth.pinned.back()] = 0;
  }
  std::sort(cloth.pinned.begin(), cloth.pinned.end());
}

Cloth make_grid(const ClothSpec& spec, double gravity) {
  validate(spec);
  const int n = spec.columns * spec.rows;
  const Eigen::Vector2d spacing(spec.columns > 1 ? spec.width / (spec.columns - 1) : 0,
                                spec.rows > 1 ? spec.height / (spec.rows - 1) : 0);

  Cloth cloth;
  cloth.columns = spec.columns;
  cloth.rows = spec.rows;
  cloth.self_collision = resolve_self_collision(spec, spacing, gravity);

  add_points(spec, spacing, cloth);
  add_triangles(spec, cloth);

  cloth.mass.resize(n);
  cloth.inv_mass.resize(n);
  if (spec.material.fabric) {
    add_fabric(spec, cloth);
  } else {
    add_classic(spec, spacing, cloth);
  }
  set_common(spec, cloth);
  return cloth;
}

double unevenness(const Cloth& cloth) {
  double most = max_unevenness;
  if (cloth.is_mesh()) {
    for (const SpringRun& run : cloth.springs) {
      most = std::min(most, uneven_share * run.rest_length);
    }
    return most;
  }
  for (const auto& [count, next] : {std::pair(cloth.columns, 1), {cloth.rows, cloth.columns}}) {
    if (count < 2) continue;
    const double side = (cloth.rest_positions.row(next) - cloth.rest_positions.row(0)).norm();
    most = std::min(most, uneven_share * side);
  }
  return most;
}

State start_state(const ClothSpec& spec, const Cloth& cloth, std::uint64_t seed) {
  State state;
  state.positions = cloth.rest_positions;
  state.velocities = Points::Zero(cloth.num_points(), 3);
  // The standard fixes the bits of the engine but not those of a distribution: scale them here.
  std::mt19937_64 engine(seed);
  const auto unevenly = [&](int begin, int end) {
    const double most = unevenness(cloth);
    for (int i = begin; i < end; ++i) {
      const double unit = static_cast<double>(engine() >> 11) * 0x1p-53;  // [0, 1)
      state.positions(i, 1) += most * (2 * unit - 1);
    }
  };
  if (spec.orientation == Orientation::vertical && !cloth.is_mesh()) {
    unevenly(0, cloth.num_points());
  }
  for (const ClothPart& part : spec.parts) {
    if (part.is_vertical) unevenly(part.first_point, part.first_point + part.num_points());
  }
  return state;
}

}  // namespace clothsim
