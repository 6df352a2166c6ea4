#include "clothsim/render/tube.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace clothsim {
namespace {

constexpr int sides = 12;          // around
constexpr int cap_rings = 3;       // of each round end, including its tip
constexpr int stride = sides + 1;  // texture coordinates differ where the last side meets the first

/// Points that are closer than this have no direction between them [m].
constexpr double no_length = 1e-12;

/// A section of the tube: its centre, the direction along the line, and a perpendicular direction.
struct Section {
  Vector3 center, along, out;
};

/// Each section is rotated as little as possible against the one before, so that the tube is not
/// twisted.
std::vector<Section> sections(const Points& line) {
  const Eigen::Index last = line.rows() - 1;
  std::vector<Section> result;
  Section section{Vector3::Zero(), Vector3::UnitX(), Vector3::UnitZ()};
  for (Eigen::Index i = 0; i <= last; ++i) {
    const Vector3 step =
        line.row(std::min(i + 1, last)) - line.row(std::max<Eigen::Index>(i - 1, 0));
    const double length = step.norm();
    if (length > no_length) section.along = step / length;
    const Vector3 square = section.out - section.along * section.along.dot(section.out);
    const double left = square.norm();
    section.out = left > no_length ? Vector3(square / left) : section.along.unitOrthogonal();
    section.center = line.row(i);
    result.push_back(section);
  }
  return result;
}

/// Adds rings of vertices to a mesh that has room for them.
class Rings {
 public:
  Rings(Mesh& mesh, int first, TubeAlong along) : mesh_(mesh), next_(first), along_(along) {}

  /// `tilt` is the angle [rad] of the normals towards the line's end.
  void add(const Section& s, double radius, double tilt, double share) {
    const Vector3 side = s.along.cross(s.out);
    for (int k = 0; k < stride; ++k, ++next_) {
      const double around = 1.0 * k / sides, angle = 2 * M_PI * around;
      const Vector3 out = std::cos(angle) * s.out + std::sin(angle) * side;
      const Vector3 normal = std::cos(tilt) * out + std::sin(tilt) * s.along;
      const Vector3 forward = std::cos(tilt) * s.along - std::sin(tilt) * out;
      mesh_.normals.row(next_) = normal;
      mesh_.positions.row(next_) = s.center + radius * normal;
      if (along_ == TubeAlong::u) {
        mesh_.tangents.row(next_) = forward;
        mesh_.uv.row(next_) << share, 1 - around;
      } else {
        mesh_.tangents.row(next_) = s.along.cross(out);
        mesh_.uv.row(next_) << around, share;
      }
    }
  }

 private:
  Mesh& mesh_;
  int next_;
  TubeAlong along_;
};

}  // namespace

Mesh tube_mesh(const Points& line, double radius, TubeAlong along) {
  assert(line.rows() >= 2);
  const auto points = static_cast<int>(line.rows());
  const int rings = points + 2 * cap_rings;
  const int vertices = points + rings * stride;
  Mesh mesh;
  mesh.positions.resize(vertices, 3);
  mesh.normals.setZero(vertices, 3);
  mesh.tangents.setZero(vertices, 3);
  mesh.uv.setZero(vertices, 2);
  mesh.positions.topRows(points) = line;

  const std::vector<Section> middle = sections(line);
  Rings add(mesh, points, along);
  for (int i = cap_rings; i > 0; --i) add.add(middle.front(), radius, -M_PI / 2 * i / cap_rings, 0);
  for (int i = 0; i < points; ++i) {
    add.add(middle[static_cast<std::size_t>(i)], radius, 0, 1.0 * i / (points - 1));
  }
  for (int i = 1; i <= cap_rings; ++i) add.add(middle.back(), radius, M_PI / 2 * i / cap_rings, 1);

  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < sides; ++k) {
      const int i = points + ring * stride + k, next = i + stride;
      mesh.triangles.push_back({i, i + 1, next + 1});
      mesh.triangles.push_back({i, next + 1, next});
    }
  }
  return mesh;
}

}  // namespace clothsim
