#include "clothsim/shapes/mass_properties.h"

#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

using Result = std::optional<MassProperties>;

MassProperties with_moments(double x, double y, double z) {
  return {Vector3::Zero(), Vector3(x, y, z).asDiagonal()};
}

Result of(const Sphere& s) {
  const double moment = 2.0 / 5 * s.radius * s.radius;
  return with_moments(moment, moment, moment);
}

Result of(const Plane&) { return std::nullopt; }

Result of(const Cuboid& box) {
  const Vector3 squares = box.size.cwiseAbs2() / 12;
  return with_moments(squares.y() + squares.z(), squares.x() + squares.z(),
                      squares.x() + squares.y());
}

Result of(const Cylinder& c) {
  const double r2 = c.radius * c.radius, across = (3 * r2 + c.length * c.length) / 12;
  return with_moments(across, across, r2 / 2);
}

/// A cylinder and two half balls, each with its centre of mass 3/8 r beyond the cylinder's end.
Result of(const Capsule& c) {
  const double r = c.radius, l = c.length;
  const double cylinder = l / (l + 4.0 / 3 * r), balls = 1 - cylinder;  // shares of the mass
  const double along = cylinder * r * r / 2 + balls * 2 / 5 * r * r;
  const double across =
      cylinder * (3 * r * r + l * l) / 12 + balls * (2.0 / 5 * r * r + l * l / 4 + 3.0 / 8 * l * r);
  return with_moments(across, across, along);
}

/// Integrals of 1, x and x x^T over the tetrahedra between the origin and each triangle: the
/// integral of x_i x_j over one of volume V is V / 20 (sum_k p_k p_k^T + s s^T) with the sum s of
/// its corners p_k (Blow & Binstock 2004, "How to find the inertia tensor").
Result of(const MeshShape& mesh) {
  const Solid& solid = mesh.file->solid;
  if (solid.is_sheet()) return std::nullopt;
  const Vector3 origin = solid.box().center();
  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (const auto& [a, b, c] : solid.triangles()) {
    const auto corner = [&](int i) {
      return Vector3(solid.vertices()[static_cast<std::size_t>(i)] - origin);
    };
    const Vector3 p = corner(a), q = corner(b), r = corner(c), s = p + q + r;
    const double v = p.dot(q.cross(r)) / 6;
    volume += v;
    first += v / 4 * s;
    second +=
        v / 20 * (p * p.transpose() + q * q.transpose() + r * r.transpose() + s * s.transpose());
  }
  const Vector3 center = first / volume;
  const Matrix3 spread = second / volume - center * center.transpose();
  return MassProperties{origin + center, spread.trace() * Matrix3::Identity() - spread};
}

}  // namespace

std::optional<MassProperties> mass_properties(const Shape& shape) {
  return std::visit([](const auto& s) { return of(s); }, shape);
}

}  // namespace clothsim
