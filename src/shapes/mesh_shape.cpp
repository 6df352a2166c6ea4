#include "clothsim/shapes/mesh_shape.h"

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/mesh_file.h"
#include "shape_parts.h"

namespace clothsim {
namespace {

/// A feature of a triangle and a solid: a corner of the triangle, a ridge or a face of the solid.
/// If two are at the same distance, the first in this order counts, so that no result depends on
/// the order of the search.
struct Feature {
  enum Kind { corner, ridge, face };
  Kind kind = corner;
  int number = 0;  // of the ridge or the face

  bool is_before(const Feature& other) const {
    return std::pair(kind, number) < std::pair(other.kind, other.number);
  }
};

bool is_nearer(double distance, const Feature& feature, double other_distance,
               const Feature& other) {
  return distance != other_distance ? distance < other_distance : feature.is_before(other);
}

/// Where two features are closest, and on which side of the solid's surface. The nearest pair of a
/// triangle and a solid is a corner of the one and a face of the other, or two edges.
class ClosestFeatures {
 public:
  ClosestFeatures(const Triangle& t, double reach) : t_(t), n_(unit_normal(t)), reach_(reach) {}

  /// A corner of the triangle and its signed distance.
  void add_corner(std::size_t i, double value, const Vector3& normal) {
    const FaceDistance found{value, normal, corner(i)};
    if (value < 0) add_inside(found, {});
    if (std::abs(value) < std::abs(nearest_.value)) nearest_ = found;
  }

  void add(int number, const Solid::Ridge& ridge) {
    const Feature feature{Feature::ridge, number};
    const auto& [a, b] = ridge.ends;
    const std::array<double, 2> heights{n_.dot(a - t_[0]), n_.dot(b - t_[0])};
    if ((heights[0] > 0) != (heights[1] > 0) && passes_through(a, b, t_)) {
      add_piercing(feature, ridge);
      return;
    }
    for (const std::size_t end : {0, 1}) {
      if (std::abs(heights[end]) > Solid::beyond_rounding * most()) continue;
      const Vector3& p = ridge.ends[end];
      add_pair(feature, p, closest_on_triangle(p, t_[0], t_[1], t_[2]), ridge.end_normals[end]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t_[i], t_[(i + 1) % 3], a, b);
      const Vector3& normal = where.t <= 0   ? ridge.end_normals[0]
                              : where.t >= 1 ? ridge.end_normals[1]
                                             : ridge.normal;
      add_pair(feature, a + where.t * (b - a), on_edge(i, where.s), normal);
    }
  }

  /// The edge from corner i on passes through a face at `place`: moving its inner end out frees it.
  void add_hit(std::size_t i, const Vector3& place, int face, const Vector3& normal) {
    for (const std::size_t end : {i, (i + 1) % 3}) {
      const double depth = normal.dot(t_[end] - place);
      if (depth < 0) add_inside({depth, normal, corner(end)}, {Feature::face, face});
    }
  }

  /// No feature farther away matters [m].
  double most() const { return std::abs(nearest_.value); }

  /// For a triangle that is partly inside the solid, the shortest way that takes one of its
  /// features out; else the nearest pair.
  const FaceDistance& result() const {
    const bool is_shorter = nearest_.value < 0 && nearest_.value > inside_.value;
    return is_inside_ && !is_shorter ? inside_ : nearest_;
  }

 private:
  void add_pair(const Feature& feature, const Vector3& p, const Weights& weights,
                const Vector3& normal) {
    const Vector3 gap = at(t_, weights) - p;
    const double distance = gap.norm();
    if (distance > reach_ || !is_nearer(distance, feature, most(), nearest_feature_)) return;
    nearest_feature_ = feature;
    const double side = gap.dot(normal) < 0 ? -1 : 1;
    nearest_ = {side * distance,
                distance > 0 ? Vector3(side / distance * gap) : normal.stableNormalized(), weights};
  }

  /// A ridge passes through the triangle: the triangle leaves it over an end that points outwards,
  /// or, if neither does, over the nearer one.
  void add_piercing(const Feature& feature, const Solid::Ridge& ridge) {
    std::array<FaceDistance, 2> exits;
    bool has_tip = false;
    for (const std::size_t end : {0, 1}) {
      const Vector3& p = ridge.ends[end];
      const double height = n_.dot(p - t_[0]);
      exits[end] = {-std::abs(height), height < 0 ? Vector3(-n_) : n_,
                    closest_on_triangle(p, t_[0], t_[1], t_[2])};
      if (exits[end].normal.dot(ridge.end_normals[end]) <= 0) continue;
      has_tip = true;
      add_inside(exits[end], feature);
    }
    if (!has_tip) add_inside(exits[exits[0].value > exits[1].value ? 0 : 1], feature);
  }

  void add_inside(const FaceDistance& found, const Feature& feature) {
    is_inside_ = true;
    if (!is_nearer(-found.value, feature, -inside_.value, inside_feature_)) return;
    inside_ = found;
    inside_feature_ = feature;
  }

  const Triangle& t_;
  Vector3 n_;     // unit, zero without an area
  double reach_;  // pairs farther apart do not count [m]
  FaceDistance nearest_;
  FaceDistance inside_{-infinity, Vector3::UnitZ(), {1, 0, 0}};
  bool is_inside_ = false;
  Feature nearest_feature_, inside_feature_;
};

/// The same for a sheet, which has two sides and no inside.
class ClosestToSheet {
 public:
  ClosestToSheet(const Triangle& t, double reach) : t_(t), n_(unit_normal(t)), reach_(reach) {}

  void add_corner(std::size_t i, double value, const Vector3& normal) {
    if (value < nearest_.value) nearest_ = {value, normal, corner(i)};
  }

  void add(int number, const Solid::Ridge& ridge) {
    const Feature feature{Feature::ridge, number};
    const auto& [a, b] = ridge.ends;
    if (!n_.isZero(0) && passes_through(a, b, t_)) {
      for (const Vector3& p : ridge.ends) {
        add_exit(n_.dot(p - t_[0]), n_, closest_on_triangle(p, t_[0], t_[1], t_[2]), feature);
      }
      return;
    }
    for (const Vector3& p : ridge.ends) {
      add_pair(feature, p, closest_on_triangle(p, t_[0], t_[1], t_[2]));
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const SegmentParameters where = closest_on_segments(t_[i], t_[(i + 1) % 3], a, b);
      add_pair(feature, a + where.t * (b - a), on_edge(i, where.s));
    }
  }

  /// The edge from corner i on passes through a face at `place`: either end may go back.
  void add_hit(std::size_t i, const Vector3& place, int face, const Vector3& normal) {
    for (const std::size_t end : {i, (i + 1) % 3}) {
      add_exit(normal.dot(place - t_[end]), normal, corner(end), {Feature::face, face});
    }
  }

  /// No feature farther away matters [m].
  double most() const { return nearest_.value; }

  /// For a triangle that passes through the sheet, the shortest way that frees one of its features;
  /// else the nearest pair.
  const FaceDistance& result() const { return std::isinf(out_.value) ? nearest_ : out_; }

 private:
  void add_pair(const Feature& feature, const Vector3& p, const Weights& weights) {
    const Vector3 gap = at(t_, weights) - p;
    const double distance = gap.norm();
    if (distance > reach_ || distance == 0) return;
    if (!is_nearer(distance, feature, nearest_.value, nearest_feature_)) return;
    nearest_ = {distance, gap / distance, weights};
    nearest_feature_ = feature;
  }

  /// `depth` [m] along `normal`, or against it where below 0.
  void add_exit(double depth, const Vector3& normal, const Weights& weights,
                const Feature& feature) {
    const double value = -std::abs(depth);
    if (!is_nearer(-value, feature, -out_.value, out_feature_)) return;
    out_ = {value, depth < 0 ? Vector3(-normal) : normal, weights};
    out_feature_ = feature;
  }

  const Triangle& t_;
  Vector3 n_;     // unit, zero without an area
  double reach_;  // pairs farther apart do not count [m]
  FaceDistance nearest_;
  FaceDistance out_{-infinity, Vector3::UnitZ(), {1, 0, 0}};
  Feature nearest_feature_, out_feature_;
};

bool is_near(const Solid& solid, const Box& box, double most) {
  return squared_distance(solid.box(), box) <= most * std::abs(most);
}

/// Where a triangle and the features within `reach` [m] of it are closest.
template <class Closest>
FaceDistance closest_features(const Solid& solid, const Triangle& t, double reach,
                              const FaceQuery& query) {
  const double at_most = std::max(reach, 0.0);
  Closest closest(t, at_most);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [value, normal] = query.neighbourhoods[i]
                                     ? solid.distance(t[i], *query.neighbourhoods[i])
                                     : solid.distance(t[i]);
    closest.add_corner(i, value, normal);
  }
  double most = std::min(closest.most(), at_most);
  // Surroundings for a reach of 0 would be of no use to the next query.
  Solid::Surroundings* around = query.surroundings;
  if (around && most == 0 && !around->cover(t, 0)) around = nullptr;
  if (around) solid.look_around(t, most, *around);
  solid.visit_ridges(t, around, most, [&](int i, const Solid::Ridge& ridge) {
    closest.add(i, ridge);
    most = std::min(most, closest.most());
  });
  solid.visit_hits(t, around,
                   [&](std::size_t i, const Vector3& place, int face, const Vector3& normal) {
                     closest.add_hit(i, place, face, normal);
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
  return face_distance(t, reach, {});
}

std::optional<FaceDistance> MeshShape::face_distance(const Triangle& t, double reach,
                                                     const FaceQuery& query) const {
  const Solid& solid = file->solid;
  if (!is_near(solid, box_of(t), reach + padding)) return std::nullopt;
  const FaceDistance found =
      solid.is_sheet() ? closest_features<ClosestToSheet>(solid, t, reach + padding, query)
                       : closest_features<ClosestFeatures>(solid, t, reach + padding, query);
  return within(reach, found, padding);
}

void MeshShape::visit_lines(const Triangle& t, const Vector3& normal, double reach,
                            const VisitLine& visit) const {
  constexpr double square = 0.1;  // largest sine between a ridge and the plane normal to `normal`
  constexpr double sharp = 0.35;  // ridges that bend less do not support a triangle [rad]
  if (file->solid.sharpest() < sharp) return;
  double most = reach + padding;
  file->solid.visit_ridges(t, nullptr, most, [&](int, const Solid::Ridge& ridge) {
    if (ridge.angle < sharp) return;
    const Vector3 along = ridge.ends[1] - ridge.ends[0];
    if (std::abs(normal.dot(along)) > square * along.norm()) return;
    if (!file->solid.is_sheet() && normal.dot(ridge.normal) <= 0) return;
    visit(ridge.ends[0], ridge.ends[1], padding);
  });
}

bool MeshShape::may_touch(const Box& box, const Triangle* t, double reach) const {
  return may_touch(box, t, reach, {});
}

bool MeshShape::may_touch(const Box& box, const Triangle* t, double reach,
                          const FaceQuery& query) const {
  if (!is_near(file->solid, box, reach + padding)) return false;
  return !t || file->solid.is_ridge_within(*t, reach + padding, query.surroundings);
}

}  // namespace clothsim
