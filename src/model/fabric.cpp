#include "clothsim/model/fabric.h"

#include <algorithm>
#include <cmath>

namespace clothsim {
namespace {

/// The grid of a fabric: sizes of cells, and areas of points.
struct FabricGrid {
  explicit FabricGrid(const ClothSpec& s)
      : spec(s),
        fabric(*s.material.fabric),
        du(s.columns > 1 ? s.width / (s.columns - 1) : 0),
        dv(s.rows > 1 ? s.height / (s.rows - 1) : 0) {}

  bool has(SpringFamily family) const {
    return spec.material.springs[static_cast<std::size_t>(family)];
  }
  bool has_cells() const { return spec.columns > 1 && spec.rows > 1; }

  /// Width that points of a column own [m], and height that points of a row own.
  double width_of(int column) const { return owned(column, spec.columns, du, spec.width); }
  double height_of(int row) const { return owned(row, spec.rows, dv, spec.height); }

  const ClothSpec& spec;
  const Fabric& fabric;
  double du;  // [m]
  double dv;

 private:
  static double owned(int i, int count, double spacing, double whole) {
    if (count == 1) return whole;
    return i == 0 || i == count - 1 ? spacing / 2 : spacing;
  }
};

void set_masses(const FabricGrid& grid, Cloth& cloth) {
  for (int row = 0; row < cloth.rows; ++row) {
    for (int column = 0; column < cloth.columns; ++column) {
      const double mass = grid.spec.material.density * grid.width_of(column) * grid.height_of(row);
      cloth.mass[row * cloth.columns + column] = mass;
      cloth.inv_mass[row * cloth.columns + column] = 1 / mass;
    }
  }
}

/// Stiffness of the springs along the threads: the rest of it is in couple_threads() [N/m].
double along_threads(const FabricGrid& grid, std::size_t direction) {
  const double coupled = grid.has_cells() ? std::abs(grid.fabric.poisson) : 0;
  return (1 - coupled) * grid.fabric.stretch_stiffness[direction];
}

/// Rows of `count` springs each, inner ones first: springs on the border are half as stiff.
void add_threads(const FabricGrid& grid, Cloth& cloth) {
  const int columns = cloth.columns;
  const int rows = cloth.rows;
  const auto add = [&](int first, int offset, int count, double rest_length, double stiffness) {
    if (count <= 0) return;
    cloth.springs.push_back(
        {SpringFamily::structural, first, offset, count, rest_length, stiffness});
  };
  const double warp = along_threads(grid, 0);
  for (int row = 0; row < rows; ++row) {
    add(row * columns, 1, columns - 1, grid.du, warp * grid.height_of(row) / grid.du);
  }

  const double weft = along_threads(grid, 1);
  const auto weft_stiffness = [&](int column) { return weft * grid.width_of(column) / grid.dv; };
  for (int row = 0; row + 1 < rows; ++row) {
    add(row * columns + 1, columns, columns - 2, grid.dv, weft_stiffness(1));
  }
  for (int row = 0; row + 1 < rows; ++row) {  // the two edges
    add(row * columns, columns, 1, grid.dv, weft_stiffness(0));
    if (columns > 1) {
      add((row + 1) * columns - 1, columns, 1, grid.dv, weft_stiffness(columns - 1));
    }
  }
}

/// Springs without stiffness, for the strain limit.
void add_diagonals(const FabricGrid& grid, Cloth& cloth) {
  const double length = std::hypot(grid.du, grid.dv);
  for (const int to : {1, -1}) {
    for (int row = 0; row + 1 < cloth.rows; ++row) {
      const int first = row * cloth.columns + (to > 0 ? 0 : 1);
      cloth.springs.push_back(
          {SpringFamily::shear, first, cloth.columns + to, cloth.columns - 1, length, 0});
    }
  }
}

void add_cells(const CellStrain& strain, double stiffness, Cloth& cloth) {
  if (stiffness == 0) return;
  for (int row = 0; row + 1 < cloth.rows; ++row) {
    cloth.cells.push_back(
        {row * cloth.columns, 1, cloth.columns, cloth.columns - 1, strain, stiffness});
  }
}

/// m_u . m_v / (du dv), the cosine of the angle between the mean sides where these keep their
/// lengths, with the shear stiffness.
void resist_shear(const FabricGrid& grid, Cloth& cloth) {
  const double area = grid.du * grid.dv, share = 1 / (4 * area);
  add_cells({share, -share, 0, 0}, grid.fabric.shear_stiffness * area, cloth);
}

/// (sqrt(C11) e_u +- sqrt(C22) e_v) / sqrt(C11 + C22), with Green's strains e of the mean sides.
void couple_threads(const FabricGrid& grid, Cloth& cloth) {
  const auto& [warp, weft] = grid.fabric.stretch_stiffness;
  if (warp + weft == 0) return;
  const double u = std::sqrt(warp / (warp + weft));
  const double v = std::copysign(std::sqrt(weft / (warp + weft)), grid.fabric.poisson);
  const double along = u / (8 * grid.du * grid.du), across = v / (8 * grid.dv * grid.dv);
  add_cells({along + across, along + across, 2 * (across - along), (u + v) / 2},
            std::abs(grid.fabric.poisson) * (warp + weft) * grid.du * grid.dv, cloth);
}

void add_bends(const FabricGrid& grid, Cloth& cloth) {
  const int columns = cloth.columns;
  const auto add = [&](int first, int a, int b, int count, double stiffness) {
    if (count > 0 && stiffness > 0) cloth.bends.push_back({first, a, b, count, stiffness});
  };
  const auto& [warp, weft] = grid.fabric.bending_stiffness;
  for (int row = 0; row < cloth.rows; ++row) {
    add(row * columns, 1, 1, columns - 2, warp * grid.height_of(row) / std::pow(grid.du, 3));
  }
  for (int row = 0; row + 2 < cloth.rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const bool is_border = column == 0 || column == columns - 1;
      const int count = is_border ? 1 : columns - 2;
      add(row * columns + column, columns, columns, count,
          weft * grid.width_of(column) / std::pow(grid.dv, 3));
      column += count - 1;
    }
  }
  const double twist = 2 * std::sqrt(warp * weft) / (grid.du * grid.dv);
  for (int row = 0; row + 1 < cloth.rows; ++row) {
    add(row * columns, 1, columns, columns - 1, twist);
  }
}

}  // namespace

void add_fabric(const ClothSpec& spec, Cloth& cloth) {
  const FabricGrid grid(spec);
  cloth.internal_damping = grid.fabric.internal_damping;
  set_masses(grid, cloth);
  if (grid.has(SpringFamily::structural)) {
    add_threads(grid, cloth);
    if (grid.has_cells()) couple_threads(grid, cloth);
  }
  if (grid.has(SpringFamily::shear) && grid.has_cells()) {
    add_diagonals(grid, cloth);
    resist_shear(grid, cloth);
  }
  if (grid.has(SpringFamily::bending)) add_bends(grid, cloth);
  set_bands(cloth);
}

}  // namespace clothsim
