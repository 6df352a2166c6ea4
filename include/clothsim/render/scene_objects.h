#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "clothsim/render/draw_item.h"
#include "clothsim/render/mesh.h"
#include "clothsim/render/snapshot.h"

namespace clothsim {

/// The cloth on the GPU, or several cloths in one mesh. A cloth of a single row or column, which
/// has no surface, is a tube with the cloth's thickness.
class ClothObject {
 public:
  /// Uploads the differences from the last snapshot, whose surface stays on the GPU if `keep_last`.
  /// Tangents are computed only if the shading needs them.
  void update(const Snapshot&, bool keep_last);

  /// One for each cloth.
  std::vector<DrawItem> items(const Snapshot&, const Vector3& eye) const;

  /// Bound on the depth [m] below the surface of a sphere about `center` [m], from the mesh's
  /// origin, of a flat triangle of this cloth whose corners are outside. Zero where the cloth is
  /// away.
  double dip_below_sphere(const Vector3& center, double radius) const;

 private:
  GpuMesh mesh_;
  std::vector<std::vector<LineRange>> lines_;  // by cloth
  std::shared_ptr<const Cloth> cloth_;
  std::shared_ptr<const Points> positions_;
  Points local_;                          // positions relative to anchor_ [m]
  Vector3 anchor_ = Vector3::Zero();      // [m] keeps floats small anywhere
  std::optional<Vector3> anchor_before_;  // of this cloth at the last snapshot [m]
  bool has_tangents_ = false;
  Mesh tube_;  // relative to anchor_; empty: the cloth has a surface

  void upload_tube(bool new_cloth);
  void upload_surface(bool new_cloth);
};

/// A collider on the GPU. Its mesh changes only with its shape; a new pose costs nothing.
class ColliderObject {
 public:
  void update(const ColliderView&);

  /// Leaves it out of the picture.
  void hide() { placement_.reset(); }

  DrawItem item(const ColliderView&, int id, const Vector3& eye) const;

 private:
  GpuMesh mesh_;
  Mesh shape_mesh_;
  std::optional<double> sphere_radius_;
  struct Recipe {
    Shape shape;
    int segments;
    double extent;
  };
  std::optional<Recipe> made_of_;                // the mesh's recipe; empty: no mesh yet
  std::optional<Placement> placement_, before_;  // now, and at the last snapshot if drawn then
};

}  // namespace clothsim
