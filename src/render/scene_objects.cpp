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

/// The ranges that begin at each of `firsts`, up to `end`; one without any.
std::vector<IndexRange> ranges(const std::vector<int>& firsts, int end) {
  if (firsts.empty()) return {{0, end}};
  std::vector<IndexRange> all;
  for (std::size_t i = 0; i < firsts.size(); ++i) {
    const int next = i + 1 < firsts.size() ? firsts[i + 1] : end;
    all.push_back({firsts[i], next - firsts[i]});
  }
  return all;
}

/// Springs as lines, family by family; where lines coincide, the last one drawn is visible.
constexpr std::array<SpringFamily, 3> line_order{SpringFamily::bending, SpringFamily::shear,
                                                 SpringFamily::structural};

std::vector<std::array<int, 2>> spring_lines(const Cloth& cloth,
                                             std::vector<std::vector<LineRange>>& by_cloth) {
  std::vector<std::array<int, 2>> lines;
  by_cloth.clear();
  for (const IndexRange& points : ranges(cloth.first_points, cloth.num_points())) {
    std::vector<LineRange>& of_cloth = by_cloth.emplace_back();
    for (const SpringFamily family : line_order) {
      const int first = static_cast<int>(lines.size());
      for (const SpringRun& run : cloth.springs) {
        const bool is_own = run.first >= points.first && run.first < points.first + points.count;
        if (run.family != family || !is_own) continue;
        for (int i = 0; i < run.count; ++i)
          lines.push_back({run.first + i, run.first + i + run.offset});
      }
      of_cloth.push_back({first, static_cast<int>(lines.size()) - first, static_cast<int>(family)});
    }
  }
  return lines;
}

bool needs_tangents(const Snapshot& snapshot) {
  const auto needs = [](const Shading& shading) {
    return std::holds_alternative<Bump>(shading) || std::holds_alternative<Displacement>(shading);
  };
  const std::vector<Shading>& all = snapshot.cloth_shadings;
  return needs(snapshot.cloth_shading) || std::any_of(all.begin(), all.end(), needs);
}

}  // namespace

void ClothObject::update(const Snapshot& snapshot, bool keep_last) {
  const Cloth& cloth = *snapshot.cloth;
  assert(snapshot.positions && snapshot.positions->rows() == cloth.num_points());
  assert(snapshot.cloth_shadings.empty() ||
         snapshot.cloth_shadings.size() == cloth.first_points.size());
  const bool new_cloth = snapshot.cloth != cloth_;
  cloth_ = snapshot.cloth;
  anchor_before_ = new_cloth ? std::nullopt : std::optional(anchor_);

  const bool tangents = needs_tangents(snapshot);
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

std::vector<DrawItem> ClothObject::items(const Snapshot& snapshot, const Vector3& eye) const {
  const bool is_tube = cloth_->triangles.empty();
  DrawItem item{};
  item.mesh = &mesh_;
  item.positions = is_tube ? &tube_.positions : &local_;
  item.triangles = is_tube ? &tube_.triangles : &cloth_->triangles;
  item.is_cloth = true;
  item.rotation.setIdentity();
  item.translation = anchor_ - eye;
  if (anchor_before_) item.before = {Eigen::Matrix3d::Identity(), *anchor_before_};

  const auto points = ranges(cloth_->first_points, static_cast<int>(item.positions->rows()));
  const auto triangles = ranges(cloth_->first_triangles, static_cast<int>(item.triangles->size()));
  std::vector<DrawItem> all(points.size(), item);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].own_points = points[i];
    all[i].own_triangles = triangles[i];
    all[i].lines = lines_[i];
    all[i].shading =
        snapshot.cloth_shadings.empty() ? &snapshot.cloth_shading : &snapshot.cloth_shadings[i];
    const std::size_t further = i == 0 ? 0 : snapshot.colliders.size() + i;
    all[i].id = cloth_id + static_cast<int>(further);
  }
  return all;
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
  item.own_points = {0, static_cast<int>(shape_mesh_.positions.rows())};
  item.own_triangles = {0, static_cast<int>(shape_mesh_.triangles.size())};
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
