#include "clothsim/render/scene_objects.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "clothsim/model/surface.h"
#include "clothsim/render/shape_drawing.h"
#include "clothsim/render/tube.h"

namespace clothsim {
namespace {

// Largest dip: a cloth with triangles as large as the sphere below it does not cover it.
constexpr double deepest_dip = 0.1;  // of the radius

// A flat shape needs several segments only to keep the coordinates in each one small.
constexpr int flat_segments = 8;

/// Springs as lines, family by family; where lines coincide, the last one drawn is visible.
constexpr std::array<SpringFamily, 3> line_order{SpringFamily::bending, SpringFamily::shear,
                                                 SpringFamily::structural};

std::vector<std::array<int, 2>> spring_lines(const Cloth& cloth, std::vector<LineRange>& ranges) {
  std::vector<std::array<int, 2>> lines;
  ranges.clear();
  for (const SpringFamily family : line_order) {
    const int first = static_cast<int>(lines.size());
    for (const SpringRun& run : cloth.springs) {
      if (run.family == family) {
        for (int i = 0; i < run.count; ++i)
          lines.push_back({run.first + i, run.first + i + run.offset});
      }
    }
    ranges.push_back({first, static_cast<int>(lines.size()) - first, static_cast<int>(family)});
  }
  return lines;
}

bool needs_tangents(const Shading& shading) {
  return std::holds_alternative<Bump>(shading) || std::holds_alternative<Displacement>(shading);
}

}  // namespace

void ClothObject::update(const Snapshot& snapshot, bool keep_last) {
  const Cloth& cloth = *snapshot.cloth;
  assert(snapshot.positions && snapshot.positions->rows() == cloth.num_points());
  const bool new_cloth = snapshot.cloth != cloth_;
  cloth_ = snapshot.cloth;
  anchor_before_ = new_cloth ? std::nullopt : std::optional(anchor_);

  const bool tangents = needs_tangents(snapshot.cloth_shading);
  const bool same = !new_cloth && snapshot.positions == positions_ && (has_tangents_ || !tangents);
  if (keep_last && (same || new_cloth)) mesh_.stand_still();
  if (same) return;
  if (keep_last && !new_cloth) mesh_.keep_surface();
  positions_ = snapshot.positions;
  has_tangents_ = tangents;
  anchor_ = positions_->row(0);
  local_ = positions_->rowwise() - anchor_.transpose();
  if (cloth.triangles.empty()) {
    upload_tube(new_cloth);
  } else {
    upload_surface(new_cloth);
  }
}

void ClothObject::upload_tube(bool new_cloth) {
  const auto along = cloth_->rows == 1 ? TubeAlong::u : TubeAlong::v;
  tube_ = tube_mesh(local_, cloth_->thickness, along);
  if (new_cloth) mesh_.upload_topology(tube_.uv, tube_.triangles, spring_lines(*cloth_, lines_));
  mesh_.upload_surface(tube_.positions, tube_.normals, tube_.tangents);
}

void ClothObject::upload_surface(bool new_cloth) {
  tube_ = {};
  const auto& triangles = cloth_->triangles;
  if (new_cloth) mesh_.upload_topology(cloth_->uv, triangles, spring_lines(*cloth_, lines_));
  const Points normals = vertex_normals(local_, triangles);
  mesh_.upload_surface(
      local_, normals,
      has_tangents_ ? vertex_tangents(local_, cloth_->uv, triangles, normals) : Points());
}

DrawItem ClothObject::item(const Snapshot& snapshot, const Vector3& eye) const {
  DrawItem item{};
  item.mesh = &mesh_;
  const bool is_tube = cloth_->triangles.empty();
  item.positions = is_tube ? &tube_.positions : &local_;
  item.triangles = is_tube ? &tube_.triangles : &cloth_->triangles;
  item.lines = lines_;
  item.shading = &snapshot.cloth_shading;
  item.id = cloth_id;
  const std::vector<int>& firsts = cloth_->first_triangles;
  for (std::size_t i = 0; i < firsts.size(); ++i) {
    const bool last = i + 1 == firsts.size();
    const int end = last ? static_cast<int>(cloth_->triangles.size()) : firsts[i + 1];
    const std::size_t further = i == 0 ? 0 : snapshot.colliders.size() + i;
    item.ids.push_back({firsts[i], end - firsts[i], cloth_id + static_cast<int>(further)});
  }
  item.rotation.setIdentity();
  item.translation = anchor_ - eye;
  if (anchor_before_) item.before = {Eigen::Matrix3d::Identity(), *anchor_before_};
  return item;
}

double ClothObject::dip_below_sphere(const Vector3& center, double radius) const {
  // A triangle with edges up to L and its corners on the sphere lies within L / sqrt(3) of its
  // circumcentre, and so at most L^2 / 6r below the surface; less the height of its corners above
  // it.
  const double nearest = (local_.rowwise() - center.transpose()).rowwise().norm().minCoeff();
  const double edge = longest_edge(local_, cloth_->triangles);
  const double dip = edge * edge / (6 * radius) - std::max(0.0, nearest - radius);
  return std::clamp(dip, 0.0, deepest_dip * radius);
}

void ColliderObject::update(const ColliderView& view) {
  const ShapeDrawing drawing = drawing_of(view.shape);
  const bool flat = drawing.is_flat && !std::holds_alternative<Displacement>(view.shading);
  const int segments = flat ? flat_segments : view.segments;
  sphere_radius_ = drawing.sphere_radius;
  before_ = std::exchange(
      placement_,
      Placement{view.pose.orientation.normalized().toRotationMatrix(), view.pose.position});
  if (made_of_ && !(made_of_->shape == view.shape)) before_.reset();
  if (made_of_ && made_of_->shape == view.shape && made_of_->segments == segments &&
      made_of_->extent == view.extent) {
    return;
  }
  shape_mesh_ = drawing.mesh(segments, view.extent);
  mesh_.upload_topology(shape_mesh_.uv, shape_mesh_.triangles, shape_mesh_.lines);
  mesh_.upload_surface(shape_mesh_.positions, shape_mesh_.normals, shape_mesh_.tangents);
  made_of_ = {view.shape, segments, view.extent};
}

DrawItem ColliderObject::item(const ColliderView& view, int id, const Vector3& eye) const {
  DrawItem item{};
  item.mesh = &mesh_;
  item.positions = &shape_mesh_.positions;
  item.triangles = &shape_mesh_.triangles;
  item.lines = {{0, static_cast<int>(shape_mesh_.lines.size()), 0}};
  item.shading = &view.shading;
  item.id = id;
  item.rotation = placement_->rotation;
  item.translation = placement_->origin - eye;
  item.before = before_;
  item.sphere_radius = sphere_radius_;
  item.is_unbounded = std::isinf(bounding_radius(view.shape));
  return item;
}

}  // namespace clothsim
