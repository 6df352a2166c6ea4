#include "clothsim/constraints/body_collisions.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// Bullet's margin, as a share of the smallest size: its search for closest points is sure and fast
/// while the cores within these margins do not overlap.
constexpr double margin_share = 0.02;

/// Bullet clips the faces of polyhedra against each other where they overlap. So they are larger on
/// all sides by this [m].
constexpr double skin = may_sink;

/// Corners of a cylinder's end that may touch a plane, the lowest first.
enum { rim_points = 8 };

/// Bullet's places within this share of the smaller bounding radius from another one are that one.
constexpr double known_place = 0.05;

/// Most places of a hull above a plane: as many as keep it from rocking.
enum { hull_places = 8 };

btScalar to_bullet(double number) { return static_cast<btScalar>(number); }

btVector3 to_bullet(const Vector3& v) {
  return {to_bullet(v.x()), to_bullet(v.y()), to_bullet(v.z())};
}

Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

btTransform to_bullet(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return btTransform(
      btQuaternion(to_bullet(q.x()), to_bullet(q.y()), to_bullet(q.z()), to_bullet(q.w())),
      to_bullet(pose.position));
}

/// A pose in the frame of another one.
Pose relative(const Pose& pose, const Pose& frame) {
  return {to_local(frame, pose.position), frame.orientation.conjugate() * pose.orientation};
}

/// A shape of Bullet.
struct BulletShape {
  std::unique_ptr<btCollisionShape> shape;                  // none for a plane
  std::unique_ptr<btStridingMeshInterface> triangles = {};  // used by `shape`
  double skin = 0;                                          // by which it is too large [m]
  double margin = 0;  // further one, except beside another polyhedron [m]
};

std::vector<Vector3> corners_of(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back(k & 1 ? half.x() : -half.x(), k & 2 ? half.y() : -half.y(),
                         k & 4 ? half.z() : -half.z());
  }
  return corners;
}

BulletShape bullet_shape(const Sphere& s, bool) {
  return {std::make_unique<btSphereShape>(to_bullet(s.radius))};
}

BulletShape bullet_shape(const Plane&, bool) { return {}; }

BulletShape bullet_shape(const Capsule& c, bool) {
  return {std::make_unique<btCapsuleShapeZ>(to_bullet(c.radius), to_bullet(c.length))};
}

BulletShape bullet_shape(const Cuboid& box, bool) {
  auto shape = std::make_unique<btBoxShape>(to_bullet((box.size.array() / 2 + skin).matrix()));
  shape->setMargin(to_bullet(margin_share * box.size.minCoeff()));
  shape->initializePolyhedralFeatures();
  return {std::move(shape), nullptr, skin};
}

BulletShape bullet_shape(const Cylinder& c, bool) {
  auto shape = std::make_unique<btCylinderShapeZ>(to_bullet({c.radius, c.radius, c.length / 2}));
  shape->setMargin(to_bullet(margin_share * std::min(c.radius, c.length)));
  return {std::move(shape)};
}

BulletShape bullet_hull(const Solid& solid) {
  auto shape = std::make_unique<btConvexHullShape>();
  const Vector3 center = solid.box().center();
  for (const Vector3& vertex : solid.vertices()) {
    const Vector3 out = skin * (vertex - center).stableNormalized();
    shape->addPoint(to_bullet(Vector3(vertex + out)), false);
  }
  const double margin = margin_share * solid.thickness();
  shape->setMargin(to_bullet(margin));
  shape->recalcLocalAabb();
  shape->initializePolyhedralFeatures();
  return {std::move(shape), nullptr, skin, margin};
}

BulletShape bullet_shape(const MeshShape& mesh, bool is_body) {
  const Solid& solid = mesh.file->solid;
  if (is_body) {
    BulletShape hull = bullet_hull(solid);
    hull.skin -= mesh.padding;
    return hull;
  }
  auto triangles = std::make_unique<btTriangleMesh>();
  for (const auto& [a, b, c] : solid.triangles()) {
    const auto corner = [&](int i) {
      return to_bullet(solid.vertices()[static_cast<std::size_t>(i)]);
    };
    triangles->addTriangle(corner(a), corner(b), corner(c));
  }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
  shape->setMargin(0);
  return {std::move(shape), std::move(triangles), -mesh.padding};
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

/// Collects the places that Bullet reports for a pair, in the frame of its body.
struct Collector : btCollisionWorld::ContactResultCallback {
  Collector(std::size_t body, std::size_t other, const Pose& of_body, double most,
            const btCollisionObject* object, std::vector<BodyTouch>& all)
      : a(body), b(other), pose(of_body), reach(most), object_a(object), places(all) {}

  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* first, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    const double gap = point.getDistance() + too_near;
    if (gap > reach) return 0;
    // Bullet's normal leads from its second object to its first one.
    const bool is_same = first->getCollisionObject() == object_a;
    const Vector3 normal = (is_same ? 1 : -1) * from_bullet(point.m_normalWorldOnB);
    const Vector3 middle = from_bullet(point.m_positionWorldOnA + point.m_positionWorldOnB) / 2;
    places.push_back({a, b, to_world(pose, middle), (pose.orientation * normal).normalized(), gap});
    return 0;
  }

  std::size_t a;
  std::size_t b;
  Pose pose;
  double reach;
  double too_near = 0;  // by margins [m]
  const btCollisionObject* object_a;
  std::vector<BodyTouch>& places;
};

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

struct BodyCollisions::World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
  std::vector<BulletShape> shapes;
  std::vector<std::unique_ptr<btCollisionObject>> objects;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // a body and another collider

  std::vector<BodyTouch> by_bullet(std::size_t a, std::size_t b, const Pose& of_a, const Pose& of_b,
                                   double reach);
};

BodyCollisions::BodyCollisions(const std::vector<MovingCollider>& colliders,
                               const std::vector<char>& is_body)
    : world_(std::make_unique<World>()) {
  World& w = *world_;
  w.configuration.setConvexConvexMultipointIterations();
  // Bullet's own algorithm for two boxes finds no places before they overlap.
  const int box = BOX_SHAPE_PROXYTYPE, hull = CONVEX_HULL_SHAPE_PROXYTYPE;
  w.dispatcher.registerCollisionCreateFunc(
      box, box, w.configuration.getCollisionAlgorithmCreateFunc(hull, hull));
  w.dispatcher.registerClosestPointsCreateFunc(
      box, box, w.configuration.getClosestPointsAlgorithmCreateFunc(hull, hull));
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    w.shapes.push_back(
        std::visit([&](const auto& shape) { return bullet_shape(shape, is_body[k] != 0); },
                   colliders[k].shape()));
    w.objects.push_back(std::make_unique<btCollisionObject>());
    w.objects.back()->setCollisionShape(w.shapes.back().shape.get());
    for (std::size_t l = 0; l < k; ++l) {
      if (is_body[k]) w.pairs.emplace_back(k, l);
      if (!is_body[k] && is_body[l]) w.pairs.emplace_back(l, k);
    }
  }
}

BodyCollisions::~BodyCollisions() = default;

std::vector<BodyTouch> BodyCollisions::World::by_bullet(std::size_t a, std::size_t b,
                                                        const Pose& of_a, const Pose& of_b,
                                                        double reach) {
  // In the frame of the body, as Bullet counts in single precision.
  objects[a]->setWorldTransform(btTransform::getIdentity());
  objects[b]->setWorldTransform(to_bullet(relative(of_b, of_a)));
  std::vector<BodyTouch> places;
  Collector collector(a, b, of_a, reach, objects[a].get(), places);
  const BulletShape &one = shapes[a], &other = shapes[b];
  const bool are_clipped = one.shape->isPolyhedral() && other.shape->isPolyhedral();
  collector.too_near = one.skin + other.skin;
  if (!are_clipped) collector.too_near += one.margin + other.margin;
  collector.m_closestDistanceThreshold = to_bullet(reach - std::min(0.0, collector.too_near));
  world.contactPairTest(objects[a].get(), objects[b].get(), collector);
  return places;
}

std::vector<BodyTouch> BodyCollisions::find(
    const std::vector<MovingCollider>& colliders, double reach,
    const std::function<bool(std::size_t, std::size_t)>& may_touch) {
  World& w = *world_;
  std::vector<BodyTouch> all;
  for (const auto& [a, b] : w.pairs) {
    const MovingCollider &body = colliders[a], &other = colliders[b];
    if (!body.enabled() || !other.enabled() || !may_touch(a, b)) continue;
    const double radius = bounding_radius(body.shape());
    const Vector3& middle = body.pose().position;
    if (!other.reaches({middle, middle}, radius + reach)) continue;
    std::vector<BodyTouch> places;
    const bool is_plane = std::holds_alternative<Plane>(other.shape());
    const bool are_polyhedra =
        !is_plane && w.shapes[a].shape->isPolyhedral() && w.shapes[b].shape->isPolyhedral();
    if (!are_polyhedra) places = above_each_other(a, b, colliders, reach);
    if (!is_plane && (places.empty() || may_miss_edges(body.shape(), other.shape()))) {
      const double near = known_place * std::min(radius, bounding_radius(other.shape()));
      add_new(w.by_bullet(a, b, body.pose(), other.pose(), reach), near, places);
    }
    all.insert(all.end(), places.begin(), places.end());
  }
  return all;
}

}  // namespace clothsim
