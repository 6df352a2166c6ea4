#include "clothsim/model/make_cloth.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "clothsim/model/grid.h"
#include "clothsim/model/triangle_fabric.h"

namespace clothsim {

namespace {

/// Sets `by_cloth` to value(part) of each part; leaves it empty where all are equal.
template <typename Value, typename Of>
void set_where_different(const std::vector<ClothPart>& parts, const Of& value,
                         std::vector<Value>& by_cloth) {
  std::vector<Value> all;
  for (const ClothPart& part : parts) all.push_back(value(part));
  const auto differs = [&](const Value& v) { return v != all.front(); };
  if (std::any_of(all.begin(), all.end(), differs)) by_cloth = std::move(all);
}

/// The values that are those of each cloth.
void set_by_cloth(const std::vector<ClothPart>& parts, Cloth& cloth) {
  if (parts.empty()) return;
  set_where_different(
      parts, [](const ClothPart& part) { return part.material.damping; }, cloth.dampings);
  set_where_different(
      parts, [](const ClothPart& part) { return part.material.drag; }, cloth.drags);
  set_where_different(
      parts, [](const ClothPart& part) { return part.material.strain_limit; }, cloth.strain_limits);
  for (const double damping : cloth.dampings) cloth.damping = std::min(cloth.damping, damping);
  for (const std::optional<double>& limit : cloth.strain_limits) {
    cloth.strain_limit = std::max(cloth.strain_limit, limit);  // none is the least
  }
  cloth.frictions.resize(cloth.num_points());
  cloth.thicknesses.resize(cloth.num_points());
  for (const ClothPart& part : parts) {
    cloth.frictions.segment(part.first_point, part.num_points()).setConstant(part.friction);
    cloth.thicknesses.segment(part.first_point, part.num_points()).setConstant(part.thickness);
  }
  cloth.thickness = cloth.thicknesses.maxCoeff();
  cloth.offset = cloth.full_offset = std::max(surface_offset, cloth.thickness);
}

}  // namespace

Cloth make_cloth(const ClothSpec& spec, double gravity) {
  if (!spec.mesh) return make_grid(spec, gravity);
  validate(spec);
  Cloth cloth;
  cloth.columns = spec.columns;
  cloth.rows = spec.rows;
  cloth.rest_positions = spec.mesh->positions;
  cloth.uv = spec.mesh->uv;
  cloth.triangles = spec.mesh->triangles;
  for (const ClothPart& part : spec.parts) {
    cloth.first_points.push_back(part.first_point);
    cloth.first_triangles.push_back(part.first_triangle);
  }
  add_triangle_fabric(spec, cloth);
  set_common(spec, cloth);
  set_by_cloth(spec.parts, cloth);
  const bool is_automatic = spec.self_collision == SelfCollision::automatic;
  cloth.self_collision = is_automatic ? SelfCollision::surface : spec.self_collision;
  return cloth;
}

}  // namespace clothsim
