#include "render_fixture.h"

#include <cmath>

#include "clothsim/model/grid.h"
#include "clothsim/model/surface.h"

namespace clothsim {

Renderer& shared_renderer() {
  static Renderer renderer({CLOTHSIM_SHADERS_DIR});
  return renderer;
}

Images draw(const Snapshot& snapshot, const Camera& camera) {
  Images images;
  shared_renderer().render(snapshot, camera, {}, images);
  return images;
}

int channel(const Images& images, int u, int v, int c) {
  return images.color[static_cast<std::size_t>(3 * (v * images.width + u) + c)];
}

bool surrounded_by(const Images& images, int u, int v, int id) {
  for (int y = v - 1; y <= v + 1; ++y)
    for (int x = u - 1; x <= u + 1; ++x)
      if (x < 0 || y < 0 || x >= images.width || y >= images.height ||
          images.mask[static_cast<std::size_t>(y * images.width + x)] != id)
        return false;
  return true;
}

Vector3 pixel_ray(const Camera& c, double u, double v) {
  return c.pose.orientation * Vector3((u - c.cx) / c.fx, (v - c.cy) / c.fy, 1);
}

double srgb_byte(double linear) {
  const double l = std::min(1.0, std::max(0.0, linear));
  return 255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
}

double linear_of_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

Snapshot flat_cloth(int columns, int rows) {
  ClothSpec spec;
  spec.columns = columns;
  spec.rows = rows;
  spec.origin = {0, 0, 0};
  const auto cloth = std::make_shared<const Cloth>(make_grid(spec));
  Snapshot snapshot;
  snapshot.cloth = cloth;
  move_cloth(snapshot, cloth->rest_positions);
  return snapshot;
}

Snapshot triangle_cloth(const Points& positions, std::vector<std::array<int, 3>> triangles) {
  const auto cloth = std::make_shared<Cloth>();
  cloth->rest_positions = positions;
  cloth->uv.setZero(positions.rows(), 2);
  cloth->triangles = std::move(triangles);
  Snapshot snapshot;
  snapshot.cloth = cloth;
  move_cloth(snapshot, positions);
  return snapshot;
}

void move_cloth(Snapshot& snapshot, const Points& positions) {
  snapshot.positions = std::make_shared<const Points>(positions);
}

Mesh cloth_mesh(const Snapshot& snapshot) {
  Mesh mesh;
  mesh.positions = *snapshot.positions;
  mesh.uv = snapshot.cloth->uv;
  mesh.triangles = snapshot.cloth->triangles;
  mesh.normals = vertex_normals(mesh.positions, mesh.triangles);
  mesh.tangents = vertex_tangents(mesh.positions, mesh.uv, mesh.triangles, mesh.normals);
  return mesh;
}

Mesh collider_mesh(const ColliderView& view) {
  Mesh mesh = drawing_of(view.shape).mesh(view.segments, view.extent);
  const Eigen::Matrix3d rotation = view.pose.orientation.toRotationMatrix();
  mesh.positions =
      (mesh.positions * rotation.transpose()).rowwise() + view.pose.position.transpose();
  mesh.normals = mesh.normals * rotation.transpose();
  mesh.tangents = mesh.tangents * rotation.transpose();
  return mesh;
}

}  // namespace clothsim
