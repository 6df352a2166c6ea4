#include "clothsim/constraints/body_collisions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clothsim/constraints/bullet_world.h"
#include "clothsim/model/module.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// Corners of a cylinder's end that may touch a plane, the lowest first.
enum { rim_points = 8 };

/// Bullet's places within this share of the smaller bounding radius from another one are that one.
constexpr double known_place = 0.05;

/// Most places of a hull above a plane: as many as keep it from rocking.
enum { hull_places = 8 };

std::vector<Vector3> corners_of(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back(k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(),
                         k & 4 ? half.z() : -half.z());
  }
  return corners;
}

/// Centre of a ball, in the shape's frame, that may touch a plane, and its radius [m].
using Ball = std::pair<Vector3, double>;

// Places of a shape that may touch a plane. `down`: against the plane's normal, in the shape's
// frame, unit.

std::vector<Ball> lowest(const Sphere& s, const Vector3&) { return {{Vector3::Zero(), s.radius}}; }

std::vector<Ball> lowest(const Plane&, const Vector3&) { return {}; }

std::vector<Ball> lowest(const Capsule& c, const Vector3&) {
  return {{{0, 0, -c.length / 2}, c.radius}, {{0, 0, c.length / 2}, c.radius}};
}

std::vector<Ball> lowest(const Cuboid& box, const Vector3&) {
  std::vector<Ball> balls;
  for (const Vector3& corner : corners_of(box.size / 2)) balls.emplace_back(corner, 0);
  return balls;
}

std::vector<Ball> lowest(const Cylinder& c, const Vector3& down) {
  const double first = std::atan2(down.y(), down.x());
  std::vector<Ball> balls;
  for (const double z : {-c.length / 2, c.length / 2}) {
    for (int k = 0; k < rim_points; ++k) {
      const double angle = first + 2 * M_PI * k / rim_points;
      balls.emplace_back(Vector3(c.radius * std::cos(angle), c.radius * std::sin(angle), z), 0);
    }
  }
  return balls;
}

std::vector<Ball> lowest(const MeshShape& mesh, const Vector3&) {
  std::vector<Ball> balls;
  for (const Vector3& vertex : mesh.file->solid.vertices()) {
    balls.emplace_back(vertex, mesh.padding);
  }
  return balls;
}

/// The places farthest from each other, starting with that of the smallest gap.
std::vector<BodyTouch> spread(std::vector<BodyTouch> places) {
  if (places.size() <= hull_places) return places;
  std::vector<BodyTouch> chosen;
  const auto least = std::min_element(places.begin(), places.end(),
                                      [](const auto& p, const auto& q) { return p.gap < q.gap; });
  chosen.push_back(*least);
  while (chosen.size() < hull_places) {
    const auto apart = [&](const BodyTouch& p) {
      double nearest = (p.place - chosen[0].place).squaredNorm();
      for (const BodyTouch& c : chosen) {
        nearest = std::min(nearest, (p.place - c.place).squaredNorm());
      }
      return nearest;
    };
    chosen.push_back(
        *std::max_element(places.begin(), places.end(),
                          [&](const auto& p, const auto& q) { return apart(p) < apart(q); }));
  }
  return chosen;
}

/// Places of the lowest parts of one collider above the other one, by the signed distance from that
/// one: exact for balls and for corners on faces. Normals lead to the first collider.
std::vector<BodyTouch> above(std::size_t first, std::size_t second,
                             const std::vector<MovingCollider>& colliders, double reach) {
  const MovingCollider &one = colliders[first], &other = colliders[second];
  const Vector3 middle = to_local(other.pose(), one.pose().position);
  const Vector3 up =
      other.pose().orientation * signed_distance(other.shape(), middle, middle).normal;
  const Vector3 down = one.pose().orientation.conjugate() * -up;
  std::vector<BodyTouch> places;
  for (const auto& [center, radius] :
       std::visit([&](const auto& shape) { return lowest(shape, down); }, one.shape())) {
    const Vector3 x = to_world(one.pose(), center), local = to_local(other.pose(), x);
    const Distance d = signed_distance(other.shape(), local, middle);
    const double gap = d.value - radius;
    const Vector3 normal = other.pose().orientation * d.normal;
    if (gap <= reach) {
      places.push_back({first, second, x - (radius + gap / 2) * normal, normal, gap});
    }
  }
  return spread(std::move(places));
}

/// The same of either collider above the other one.
std::vector<BodyTouch> above_each_other(std::size_t a, std::size_t b,
                                        const std::vector<MovingCollider>& colliders,
                                        double reach) {
  std::vector<BodyTouch> places = above(a, b, colliders, reach);
  if (std::holds_alternative<MeshShape>(colliders[b].shape())) return places;  // of many vertices
  for (BodyTouch& t : above(b, a, colliders, reach)) {
    places.push_back({a, b, t.place, -t.normal, t.gap});
  }
  return places;
}

/// Whether a round side of one may touch the other's edge, which above_each_other() does not see.
bool may_miss_edges(const Shape& a, const Shape& b) {
  const auto has_axis = [](const Shape& shape) {
    return std::holds_alternative<Capsule>(shape) || std::holds_alternative<Cylinder>(shape);
  };
  const bool is_ball = std::holds_alternative<Sphere>(a) || std::holds_alternative<Sphere>(b);
  return !is_ball && (has_axis(a) || has_axis(b));
}

/// Adds the `more` places that are not within `near` [m] of one.
void add_new(const std::vector<BodyTouch>& more, double near, std::vector<BodyTouch>& places) {
  for (const BodyTouch& t : more) {
    const bool is_known = std::any_of(places.begin(), places.end(), [&](const BodyTouch& p) {
      return (p.place - t.place).norm() < near;
    });
    if (!is_known) places.push_back(t);
  }
}

}  // namespace

BodyCollisions::BodyCollisions(const std::vector<MovingCollider>& colliders,
                               const std::vector<char>& is_body) {
  static const auto make_world = reinterpret_cast<decltype(&clothsim_bullet_world)>(
      load_function("clothsim_bullet", "clothsim_bullet_world"));
  world_.reset(make_world(colliders, is_body));
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    for (std::size_t l = 0; l < k; ++l) {
      if (is_body[k]) pairs_.emplace_back(k, l);
      if (!is_body[k] && is_body[l]) pairs_.emplace_back(l, k);
    }
  }
}

BodyCollisions::~BodyCollisions() = default;

std::vector<BodyTouch> BodyCollisions::find(
    const std::vector<MovingCollider>& colliders, double reach,
    const std::function<bool(std::size_t, std::size_t)>& may_touch) {
  std::vector<BodyTouch> all;
  for (const auto& [a, b] : pairs_) {
    const MovingCollider &body = colliders[a], &other = colliders[b];
    if (!body.enabled() || !other.enabled() || !may_touch(a, b)) continue;
    const double radius = bounding_radius(body.shape());
    const Vector3& middle = body.pose().position;
    if (!other.reaches({middle, middle}, radius + reach)) continue;
    std::vector<BodyTouch> places;
    const bool is_plane = std::holds_alternative<Plane>(other.shape());
    const bool are_polyhedra = !is_plane && world_->is_polyhedral(a) && world_->is_polyhedral(b);
    if (!are_polyhedra) places = above_each_other(a, b, colliders, reach);
    if (!is_plane && (places.empty() || may_miss_edges(body.shape(), other.shape()))) {
      const double near = known_place * std::min(radius, bounding_radius(other.shape()));
      add_new(world_->find(a, b, body.pose(), other.pose(), reach), near, places);
    }
    all.insert(all.end(), places.begin(), places.end());
  }
  return all;
}

}  // namespace clothsim
