#include "clothsim/model/cloth_spec.h"

#include <unordered_map>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

constexpr Range ks_range{0, 1e12, "N/m"};
constexpr Range bending_stiffness_range{0, 1e9, "N m"};
constexpr Range internal_damping_range{0, 1e6, "s"};
constexpr Range poisson_range{-0.9, 0.9, ""};  // at 1 the sheet has a strain without energy
constexpr Range drag_range{0, 1e3, ""};
constexpr Range density_range{1e-6, 1e9, "kg/m^2"};
constexpr Range damping_range{0, 1e6, "1/s"};
constexpr Range strain_limit_range{0, 1000, ""};
constexpr Range length_range{1e-6, 1e4, "m"};
constexpr Range origin_range{-1e6, 1e6, "m"};
constexpr Range thickness_range{1e-6, 1e3, "m"};
constexpr Range friction_range{0, 1e6, ""};

/// More points are taken for a typing mistake.
constexpr long long max_points = 1'000'000;

/// Fewer points have no spring.
constexpr long long min_points = 2;

void check_size(const ClothSpec& spec) {
  const auto check_count = [](const char* key, int count) {
    if (count < 1) throw InvalidValue({key}, std::to_string(count), "a whole number of at least 1");
  };
  check_count("columns", spec.columns);
  check_count("rows", spec.rows);

  const long long points = static_cast<long long>(spec.columns) * spec.rows;
  if (spec.mesh && points > max_points) {
    throw InvalidValue({"mesh"}, std::to_string(points) + " points",
                       "at most " + std::to_string(max_points));
  }
  if (points < min_points || points > max_points) {
    throw InvalidValue(
        {"columns"},
        std::to_string(spec.columns) + " columns of " + std::to_string(spec.rows) + " rows",
        std::to_string(min_points) + " to " + std::to_string(max_points) + " points in all");
  }
}

void check_pins(const ClothSpec& spec) {
  std::unordered_map<long long, size_t> seen;  // items by point
  seen.reserve(spec.pinned.size());
  for (size_t i = 0; i < spec.pinned.size(); ++i) {
    const Pin& pin = spec.pinned[i];
    inside("pinned", [&] {
      inside(std::to_string(i), [&] {
        check_grid_point(spec, pin.column, pin.row);
        const long long point = static_cast<long long>(pin.row) * spec.columns + pin.column;
        const auto [first, is_new] = seen.emplace(point, i);
        if (!is_new) {
          throw InvalidValue({}, point_text(spec, pin.column, pin.row) + " again",
                             "a point other than that of item " + std::to_string(first->second));
        }
        check_frame(pin.frame);
        if (pin.strength) check_range("strength", *pin.strength, strength_range);
      });
    });
  }
}

/// A number given for both directions has the key of the pair.
void check_pair(const std::string& key, const std::array<double, 2>& pair, const Range& range) {
  if (pair[0] == pair[1]) return check_range(key, pair[0], range);
  inside(key, [&] {
    check_range("0", pair[0], range);
    check_range("1", pair[1], range);
  });
}

void validate(const Fabric& fabric) {
  check_pair("stretch_stiffness", fabric.stretch_stiffness, ks_range);
  check_range("shear_stiffness", fabric.shear_stiffness, ks_range);
  check_pair("bending_stiffness", fabric.bending_stiffness, bending_stiffness_range);
  check_pair("internal_damping", fabric.internal_damping, internal_damping_range);
  check_range("poisson", fabric.poisson, poisson_range);
}

template <typename Value>
void take(const Value& before, const Value& after, Value& to) {
  if (before != after) to = after;
}

template <typename Value, std::size_t size>
void take(const std::array<Value, size>& before, const std::array<Value, size>& after,
          std::array<Value, size>& to) {
  for (std::size_t i = 0; i < size; ++i) take(before[i], after[i], to[i]);
}

}  // namespace

void take_changes(const Material& before, const Material& after, Material& to) {
  take(before.ks, after.ks, to.ks);
  take(before.density, after.density, to.density);
  take(before.damping, after.damping, to.damping);
  take(before.drag, after.drag, to.drag);
  take(before.strain_limit, after.strain_limit, to.strain_limit);
  take(before.springs, after.springs, to.springs);
  if (!before.fabric || !after.fabric || !to.fabric) {
    if (before.fabric.has_value() != after.fabric.has_value()) to.fabric = after.fabric;
    return;
  }
  take(before.fabric->stretch_stiffness, after.fabric->stretch_stiffness,
       to.fabric->stretch_stiffness);
  take(before.fabric->shear_stiffness, after.fabric->shear_stiffness, to.fabric->shear_stiffness);
  take(before.fabric->bending_stiffness, after.fabric->bending_stiffness,
       to.fabric->bending_stiffness);
  take(before.fabric->internal_damping, after.fabric->internal_damping,
       to.fabric->internal_damping);
  take(before.fabric->poisson, after.fabric->poisson, to.fabric->poisson);
}

std::string grid_point_text(int column, int row) {
  return '[' + std::to_string(column) + ", " + std::to_string(row) + ']';
}

std::string point_text(const ClothSpec& spec, int column, int row) {
  for (const ClothPart& part : spec.parts) {
    const int own = column - part.first_point;
    if (own < 0 || own >= part.num_points()) continue;
    return part.name + ' ' +
           (part.is_grid ? grid_point_text(own % part.columns, own / part.columns)
                         : std::to_string(own));
  }
  return spec.mesh ? std::to_string(column) : grid_point_text(column, row);
}

void check_grid_point(const ClothSpec& spec, int column, int row) {
  if (column >= 0 && column < spec.columns && row >= 0 && row < spec.rows) return;
  if (spec.mesh) {
    throw InvalidValue({}, std::to_string(column),
                       "a point of the mesh, from 0 to " + std::to_string(spec.columns - 1));
  }
  throw InvalidValue({}, grid_point_text(column, row),
                     "[column, row] with column 0 to " + std::to_string(spec.columns - 1) +
                         " and row 0 to " + std::to_string(spec.rows - 1));
}

void validate(const Material& material) {
  check_range("ks", material.ks, ks_range);
  if (material.fabric) validate(*material.fabric);
  check_range("density", material.density, density_range);
  check_range("damping", material.damping, damping_range);
  check_pair("drag", material.drag, drag_range);
  if (material.strain_limit)
    check_range("strain_limit", *material.strain_limit, strain_limit_range);
}

void validate_contact(double thickness, double friction) {
  check_range("thickness", thickness, thickness_range);
  check_range("friction", friction, friction_range);
}

void validate(const ClothSpec& spec) {
  check_range("width", spec.width, length_range);
  check_range("height", spec.height, length_range);
  check_size(spec);
  check_range("origin", spec.origin, origin_range);
  check_pins(spec);
  if (spec.pin_strength) check_range("pin_strength", *spec.pin_strength, strength_range);
  validate(spec.material);
  validate_contact(spec.thickness, spec.friction);
  if (spec.mesh) {
    const ClothMesh& mesh = *spec.mesh;
    if (spec.columns != mesh.positions.rows() || spec.rows != 1) {
      throw InvalidValue({"columns"}, std::to_string(spec.columns),
                         std::to_string(mesh.positions.rows()) + " in one row, those of the mesh");
    }
    if (!spec.material.fabric) {
      throw InvalidValue({"fabric"}, "none", "a fabric, which a mesh needs");
    }
    for (const ClothPart& part : spec.parts) {
      validate(part.material);
      validate_contact(part.thickness, part.friction);
    }
    return;
  }
  if (spec.self_collision == SelfCollision::surface && (spec.columns < 2 || spec.rows < 2)) {
    throw InvalidValue({"self_collision"}, "surface",
                       "points: a cloth of one column or row has no surface");
  }
}

}  // namespace clothsim
