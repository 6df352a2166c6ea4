#include "clothsim/render/shape_drawing.h"

#include "clothsim/render/solid_mesh.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

using Kind = Primitive::Kind;

constexpr double plate_size = 4;          // [m] viewers show an unbounded plane as a square plate
constexpr double plate_thickness = 0.01;  // [m] of that plate, on the solid side

ShapeDrawing drawing(const Sphere& sphere) {
  const double radius = sphere.radius;
  return {[=](int segments, double) { return sphere_mesh(radius, segments, segments); },
          {{Kind::ball, Vector3::Constant(2 * radius)}},
          false,
          radius};
}

ShapeDrawing drawing(const Plane& plane) {
  const double middle = plane.two_sided ? 0 : -plate_thickness / 2;
  return {[](int segments, double extent) { return plane_mesh(extent, segments); },
          {{Kind::box, {plate_size, plate_size, plate_thickness}, {0, 0, middle}}},
          true};
}

ShapeDrawing drawing(const Capsule& capsule) {
  const double width = 2 * capsule.radius;
  const Vector3 end(0, 0, capsule.length / 2), ball = Vector3::Constant(width);
  return {[=](int segments, double) { return capsule_mesh(capsule, segments, segments); },
          {{Kind::cylinder, {width, width, capsule.length}},
           {Kind::ball, ball, end},
           {Kind::ball, ball, -end}}};
}

ShapeDrawing drawing(const Cuboid& box) {
  return {[=](int segments, double) { return box_mesh(box.size / 2, segments); },
          {{Kind::box, box.size}},
          true};
}

ShapeDrawing drawing(const Cylinder& cylinder) {
  const double width = 2 * cylinder.radius;
  return {[=](int segments, double) { return cylinder_mesh(cylinder, segments, segments); },
          {{Kind::cylinder, {width, width, cylinder.length}}}};
}

/// Viewers load the file themselves.
ShapeDrawing drawing(const MeshShape& mesh) {
  return {[=](int, double) { return solid_mesh(mesh.file->solid, mesh.padding); },
          {{Kind::file, mesh.file->scale, {0, 0, 0}, mesh.file->uri}}};
}

}  // namespace

ShapeDrawing drawing_of(const Shape& shape) {
  return std::visit([](const auto& s) { return drawing(s); }, shape);
}

}  // namespace clothsim
