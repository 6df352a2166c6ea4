#include "clothsim/model/make_cloth.h"

#include <algorithm>

#include "clothsim/model/grid.h"
#include "clothsim/model/triangle_fabric.h"

namespace clothsim {

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
  if (!spec.parts.empty()) cloth.frictions.resize(cloth.num_points());
  for (const ClothPart& part : spec.parts) {
    cloth.frictions.segment(part.first_point, part.num_points()).setConstant(part.friction);
  }
  const bool is_automatic = spec.self_collision == SelfCollision::automatic;
  cloth.self_collision = is_automatic ? SelfCollision::surface : spec.self_collision;
  return cloth;
}

}  // namespace clothsim
