// Collision detection by Bullet, a library of its own that links to nothing of clothsim_core: only
// scenes with rigid bodies load it and Bullet.

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/btBulletCollisionCommon.h>

#include <algorithm>
#include <utility>

#include "clothsim/constraints/bullet_world.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/shapes/mesh_file.h"

namespace clothsim {
namespace {

/// Bullet's margin, as a share of the smallest size: its search for closest points is sure and fast
/// while the cores within these margins do not overlap.
constexpr double margin_share = 0.02;

/// Bullet clips the faces of polyhedra against each other where they overlap. So they are larger on
/// all sides by this [m].
constexpr double skin = penetration_slop;

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

class World final : public BulletWorld {
 public:
  World(const std::vector<MovingCollider>& colliders, const std::vector<char>& is_body);

  bool is_polyhedral(std::size_t k) const override { return shapes_[k].shape->isPolyhedral(); }
  std::vector<BodyTouch> find(std::size_t a, std::size_t b, const Pose& of_a, const Pose& of_b,
                              double reach) override;

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::vector<BulletShape> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
};

World::World(const std::vector<MovingCollider>& colliders, const std::vector<char>& is_body) {
  configuration_.setConvexConvexMultipointIterations();
  // Bullet's own algorithm for two boxes finds no places before they overlap.
  const int box = BOX_SHAPE_PROXYTYPE, hull = CONVEX_HULL_SHAPE_PROXYTYPE;
  dispatcher_.registerCollisionCreateFunc(
      box, box, configuration_.getCollisionAlgorithmCreateFunc(hull, hull));
  dispatcher_.registerClosestPointsCreateFunc(
      box, box, configuration_.getClosestPointsAlgorithmCreateFunc(hull, hull));
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    shapes_.push_back(
        std::visit([&](const auto& shape) { return bullet_shape(shape, is_body[k] != 0); },
                   colliders[k].shape()));
    objects_.push_back(std::make_unique<btCollisionObject>());
    objects_.back()->setCollisionShape(shapes_.back().shape.get());
  }
}

std::vector<BodyTouch> World::find(std::size_t a, std::size_t b, const Pose& of_a, const Pose& of_b,
                                   double reach) {
  // In the frame of the body, as Bullet counts in single precision.
  objects_[a]->setWorldTransform(btTransform::getIdentity());
  objects_[b]->setWorldTransform(to_bullet(relative(of_b, of_a)));
  std::vector<BodyTouch> places;
  Collector collector(a, b, of_a, reach, objects_[a].get(), places);
  const BulletShape &one = shapes_[a], &other = shapes_[b];
  const bool are_clipped = one.shape->isPolyhedral() && other.shape->isPolyhedral();
  collector.too_near = one.skin + other.skin;
  if (!are_clipped) collector.too_near += one.margin + other.margin;
  collector.m_closestDistanceThreshold = to_bullet(reach - std::min(0.0, collector.too_near));
  world_.contactPairTest(objects_[a].get(), objects_[b].get(), collector);
  return places;
}

}  // namespace
}  // namespace clothsim

clothsim::BulletWorld* clothsim_bullet_world(const std::vector<clothsim::MovingCollider>& colliders,
                                             const std::vector<char>& is_body) {
  return new clothsim::World(colliders, is_body);
}
