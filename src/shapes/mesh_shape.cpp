#include "clothsim/shapes/mesh_shape.h"

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/mesh_file.h"
#include "shape_parts.h"

namespace clothsim {
namespace {

/// Where two features are closest, and on which side of the solid's surface. The nearest pair of a
/// triangle and a solid is a corner of the one and a face of the other, or two edges.
class ClosestFeatures {
 public:
  explicit ClosestFeatures(const Triangle& t) : t_(t), n_(unit_normal(t)) {}

  /// A corner of the triangle and its signed distance.
  void add_corner(std::size_t i, double value, const Vector3& normal) {
    const FaceDistance found{value, normal, corner(i)};
    if (value < 0) add_inside(found);
    if (std::abs(value) < std::abs(nearest_.value)) nearest_ = found;
  }

  void add(const Solid::Ridge& ridge) {
    const auto& [a, b] = ridge.ends;
    if (!n_.isZero(0) && passes_through(a, b, t_)) {
      add_piercing(ridge);
      return;
    }
    for (const std::size_t end : {0, 1}) {
      const Vector3& p = ridge.ends[end];
      add_pair(p, closest_on_triangle(p, t_[0], t_[1], t_[2]), ridge.end_normals[end]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t_[i], t_[(i + 1) % 3], a, b);
      const Vector3& normal = where.t <= 0   ? ridge.end_normals[0]
                              : where.t >= 1 ? ridge.end_normals[1]
                                             : ridge.normal;
      add_pair(a + where.t * (b - a), on_edge(i, where.s), normal);
    }
  }

  /// The edge from corner i on passes through a face at `place`: moving its inner end out frees it.
  void add_hit(std::size_t i, const Vector3& place, const Vector3& normal) {
    for (const std::size_t end : {i, (i + 1) % 3}) {
      const double depth = normal.dot(t_[end] - place);
      if (depth < 0) add_inside({depth, normal, corner(end)});
    }
  }

  /// No feature farther away matters [m].
  double most() const { return std::abs(nearest_.value); }

  /// For a triangle that is partly inside the solid, the shortest way that takes one of its
  /// features out; else the nearest pair.
  const FaceDistance& result() const { return is_inside_ ? inside_ : nearest_; }

 private:
  void add_pair(const Vector3& p, const Weights& weights, const Vector3& normal) {
    const Vector3 gap = at(t_, weights) - p;
    const double distance = gap.norm();
    if (distance >= std::abs(nearest_.value)) return;
    const double side = gap.dot(normal) < 0 ? -1 : 1;
    nearest_ = {side * distance,
                distance > 0 ? Vector3(side / distance * gap) : normal.stableNormalized(), weights};
    if (side < 0) add_inside(nearest_, false);
  }

  /// A ridge passes through the triangle: the triangle leaves it over an end that points outwards,
  /// or, if neither does, over the nearer one.
  void add_piercing(const Solid::Ridge& ridge) {
    std::array<FaceDistance, 2> exits;
    bool has_tip = false;
    for (const std::size_t end : {0, 1}) {
      const Vector3& p = ridge.ends[end];
      const double height = n_.dot(p - t_[0]);
      exits[end] = {-std::abs(height), height < 0 ? Vector3(-n_) : n_,
                    closest_on_triangle(p, t_[0], t_[1], t_[2])};
      if (exits[end].normal.dot(ridge.end_normals[end]) <= 0) continue;
      has_tip = true;
      add_inside(exits[end]);
    }
    if (!has_tip) add_inside(exits[exits[0].value > exits[1].value ? 0 : 1]);
  }

  /// `surely`: inside, even if another feature is nearer.
  void add_inside(const FaceDistance& found, bool surely = true) {
    is_inside_ = is_inside_ || surely;
    if (found.value > inside_.value) inside_ = found;
  }

  const Triangle& t_;
  Vector3 n_;  // unit, zero without an area
  FaceDistance nearest_;
  FaceDistance inside_{-infinity, Vector3::UnitZ(), {1, 0, 0}};
  bool is_inside_ = false;
};

/// The same for a sheet, which has two sides and no inside.
class ClosestToSheet {
 public:
  explicit ClosestToSheet(const Triangle& t) : t_(t), n_(unit_normal(t)) {}

  void add_corner(std::size_t i, double value, const Vector3& normal) {
    if (value < nearest_.value) nearest_ = {value, normal, corner(i)};
  }

  void add(const Solid::Ridge& ridge) {
    const auto& [a, b] = ridge.ends;
    if (!n_.isZero(0) && passes_through(a, b, t_)) {
      for (const Vector3& p : ridge.ends) {
        add_exit(n_.dot(p - t_[0]), n_, closest_on_triangle(p, t_[0], t_[1], t_[2]));
      }
      return;
    }
    for (const Vector3& p : ridge.ends) add_pair(p, closest_on_triangle(p, t_[0], t_[1], t_[2]));
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t_[i], t_[(i + 1) % 3], a, b);
      add_pair(a + where.t * (b - a), on_edge(i, where.s));
    }
  }

  /// The edge from corner i on passes through a face at `place`: either end may go back.
  void add_hit(std::size_t i, const Vector3& place, const Vector3& normal) {
    for (const std::size_t end : {i, (i + 1) % 3}) {
      add_exit(normal.dot(place - t_[end]), normal, corner(end));
    }
  }

  /// No feature farther away matters [m].
  double most() const { return nearest_.value; }

  /// For a triangle that passes through the sheet, the shortest way that frees one of its features;
  /// else the nearest pair.
  const FaceDistance& result() const { return std::isinf(out_.value) ? nearest_ : out_; }

 private:
  void add_pair(const Vector3& p, const Weights& weights) {
    const Vector3 gap = at(t_, weights) - p;
    const double distance = gap.norm();
    if (distance < nearest_.value && distance > 0) nearest_ = {distance, gap / distance, weights};
  }

  /// `depth` [m] along `normal`, or against it where below 0.
  void add_exit(double depth, const Vector3& normal, const Weights& weights) {
    if (-std::abs(depth) <= out_.value) return;
    out_ = {-std::abs(depth), depth < 0 ? Vector3(-normal) : normal, weights};
  }

  const Triangle& t_;
  Vector3 n_;  // unit, zero without an area
  FaceDistance nearest_;
  FaceDistance out_{-infinity, Vector3::UnitZ(), {1, 0, 0}};
};

bool is_near(const Solid& solid, const Box& box, double most) {
  return squared_distance(solid.box(), box) <= most * std::abs(most);
}

/// Where a triangle and the features within `max_value` [m] of it are closest.
template <class Closest>
FaceDistance closest_features(const Solid& solid, const Triangle& t, double max_value) {
  Closest closest(t);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [value, normal] = solid.distance(t[i]);
    closest.add_corner(i, value, normal);
  }
  double most = std::min(closest.most(), std::max(max_value, 0.0));
  solid.visit_ridges(t, most, [&](const Solid::Ridge& ridge) {
    closest.add(ridge);
    most = std::min(most, closest.most());
  });
  solid.visit_hits(t, [&](std::size_t i, const Vector3& place, const Vector3& normal) {
    closest.add_hit(i, place, normal);
  });
  return closest.result();
}

}  // namespace

double MeshShape::safe_depth() const {
  return file->solid.is_sheet() ? padding / 2 : file->solid.thickness() / 4;
}

double MeshShape::bounding_radius() const { return file->solid.radius() + padding; }

double MeshShape::corner_distance(double edge, double offset) const {
  if (file->solid.is_sheet()) return infinity;
  return offset + file->solid.dip(edge);
}

NearSurface MeshShape::near_surface(double x, double y, double z, double) const {
  const auto [value, normal] = file->solid.distance({x, y, z});
  return {value - padding, normal.x(), normal.y(), normal.z()};
}

std::optional<double> MeshShape::entry(const Vector3& from, const Vector3& displacement,
                                       double offset) const {
  constexpr double near = 1.05;  // of the offset: counts as entered
  const double length = displacement.norm();
  double share = 0;
  for (int step = 0; step < max_approaches && share <= 1; ++step) {
    const Vector3 p = from + share * displacement;
    const NearSurface here = near_surface(p.x(), p.y(), p.z(), 0);
    const bool nears =
        here.x * displacement.x() + here.y * displacement.y() + here.z * displacement.z() < 0;
    if (here.value <= near * offset && nears) return share;
    share += std::max(here.value - offset, near / 2 * offset) / length;
  }
  if (share > 1) return std::nullopt;
  return share;
}

std::optional<FaceDistance> MeshShape::face_distance(const Triangle& t, double reach) const {
  if (!is_near(file->solid, box_of(t), reach + padding)) return std::nullopt;
  const FaceDistance found =
      file->solid.is_sheet() ? closest_features<ClosestToSheet>(file->solid, t, reach + padding)
                             : closest_features<ClosestFeatures>(file->solid, t, reach + padding);
  return within(reach, found, padding);
}

void MeshShape::visit_lines(const Triangle& t, const Vector3& normal, double reach,
                            const VisitLine& visit) const {
  constexpr double square = 0.1;  // largest sine between a ridge and the plane normal to `normal`
  constexpr double sharp = 0.35;  // ridges that bend less do not support a triangle [rad]
  if (file->solid.sharpest() < sharp) return;
  double most = reach + padding;
  file->solid.visit_ridges(t, most, [&](const Solid::Ridge& ridge) {
    if (ridge.angle < sharp) return;
    const Vector3 along = ridge.ends[1] - ridge.ends[0];
    if (std::abs(normal.dot(along)) > square * along.norm()) return;
    if (!file->solid.is_sheet() && normal.dot(ridge.normal) <= 0) return;
    visit(ridge.ends[0], ridge.ends[1], padding);
  });
}

bool MeshShape::may_touch(const Box& box, const Triangle* t, double reach) const {
  double most = reach + padding;
  if (!t) return is_near(file->solid, box, most);
  bool found = false;
  file->solid.visit_ridges(*t, most, [&](const Solid::Ridge& ridge) {
    const Box line = Box(ridge.ends[0]).extend(ridge.ends[1]);
    found = found || overlap(line, box, reach + padding);
    if (found) most = -1;
  });
  return found;
}

}  // namespace clothsim
