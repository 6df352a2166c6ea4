#include "clothsim/model/make_cloth.h"

#include <algorithm>

#include "clothsim/model/grid.h"
#include "clothsim/model/triangle_fabric.h"

namespace clothsim {

namespace {

/// The values by point that are those of each cloth.
void set_by_point(const std::vector<ClothPart>& parts, Cloth& cloth) {
  if (parts.empty()) return;
  cloth.frictions.resize(cloth.num_points());
  cloth.thicknesses.resize(cloth.num_points());
  for (const ClothPart& part : parts) {
    cloth.frictions.segment(part.first_point, part.num_points()).setConstant(part.friction);
    cloth.thicknesses.segment(part.first_point, part.num_points()).setConstant(part.thickness);
  }
  cloth.thickness = cloth.thicknesses.maxCoeff();
  cloth.offset = std::max(surface_offset, cloth.thickness);
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
  set_by_point(spec.parts, cloth);
  const bool is_automatic = spec.self_collision == SelfCollision::automatic;
  cloth.self_collision = is_automatic ? SelfCollision::surface : spec.self_collision;
  return cloth;
}

}  // namespace clothsim
