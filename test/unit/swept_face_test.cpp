#include "clothsim/shapes/swept_face.h"

#include <gtest/gtest.h>

#include <random>

namespace clothsim::swept_face_test {
namespace {

constexpr double offset = 1e-3;

Triangle local_at(const MovingCollider& collider, const Triangle& from, const Triangle& to,
                  double share) {
  Triangle t;
  for (std::size_t i = 0; i < 3; ++i) {
    t[i] = to_local(collider.pose_at(share), from[i] + share * (to[i] - from[i]));
  }
  return t;
}

TEST(SweptFace, FindsEveryContactThatFineStepsFind) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> draw(-1, 1);
  const auto random = [&] { return Vector3(draw(engine), draw(engine), draw(engine)); };
  for (const Shape& shape : {Shape(Sphere{0.1}), Shape(Capsule{1, 0.02}),
                             Shape(Cuboid{{1, 1, 0.01}}), Shape(Cylinder{0.01, 0.5})}) {
    int hits = 0, misses = 0;
    for (int n = 0; n < 400; ++n) {
      ColliderSpec spec;
      spec.shape = shape;
      MovingCollider collider(spec);
      collider.set_target({0.2 * random(), Eigen::Quaterniond(Eigen::AngleAxisd(
                                               2.5 * draw(engine), random().normalized()))},
                          1);
      collider.advance(1);
      const Vector3 middle = random(), way = 0.6 * random() - 1.5 * middle;
      Triangle from, to;
      for (std::size_t i = 0; i < 3; ++i) {
        from[i] = middle + 0.2 * random();
        to[i] = from[i] + way + 0.1 * random();
      }
      if (face_distance(shape, local_at(collider, from, to, 0), 10)->value < offset) continue;

      double nearest = 10;
      for (int i = 0; i <= 2000; ++i) {
        const auto d = face_distance(shape, local_at(collider, from, to, i / 2000.0), 10);
        nearest = std::min(nearest, d->value);
      }
      const auto found = swept_face_distance(collider, from, to, offset);
      if (nearest < offset - 1e-9) {
        EXPECT_TRUE(found) << shape.index() << ' ' << n;
      }
      // Between samples it may come nearer by their distance, 2 mm and the effect of the turn.
      if (nearest > offset + 0.01) {
        EXPECT_FALSE(found) << shape.index() << ' ' << n;
      }
      ++(found ? hits : misses);
    }
    EXPECT_GT(hits, 20) << shape.index();
    EXPECT_GT(misses, 20) << shape.index();
  }
}

TEST(SweptFace, TellsHowFarATriangleWentThrough) {
  // Straight down through a plate, from 0.1 m above its top to 0.3 m below.
  ColliderSpec spec;
  spec.shape = Cuboid{{1, 1, 0.02}};
  MovingCollider plate(spec);
  const Triangle from{Vector3(0, 0, 0.11), Vector3(0.1, 0, 0.12), Vector3(0, 0.1, 0.12)};
  Triangle to = from;
  for (Vector3& p : to) p.z() -= 0.42;
  const auto found = swept_face_distance(plate, from, to, offset);
  ASSERT_TRUE(found);
  EXPECT_NEAR((found->normal - Vector3::UnitZ()).norm(), 0, 1e-12);
  EXPECT_NEAR(found->value, -0.32, 1e-9);
  EXPECT_EQ(found->weights, (std::array<double, 3>{1, 0, 0}));

  // The same the other way round: the plate goes up, and turns half round on its way.
  plate.set_target({Vector3(0, 0, 0.42), Eigen::Quaterniond(0, 0, 0, 1)}, 1);
  plate.advance(1);
  const auto met = swept_face_distance(plate, from, from, offset);
  ASSERT_TRUE(met);
  EXPECT_NEAR(met->value, -0.32, 1e-9);
}

}  // namespace
}  // namespace clothsim::swept_face_test
