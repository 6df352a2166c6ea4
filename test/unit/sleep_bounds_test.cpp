#include "clothsim/constraints/sleep_bounds.h"

#include <random>

#include "clothsim/shapes/signed_distances.h"
#include "verification/testing.h"

namespace clothsim::sleep_bounds_test {
namespace {

using namespace test;

TEST(SleepBounds, NoBlockSleepsThatHasAPointInReach) {
  // Random paths of points and of shapes that turn, a block for each point: points that SleepBounds
  // leaves out are farther away than the reach, and most far points are left out.
  constexpr int count = 60;
  constexpr double reach = 0.05;
  for (const Shape& shape : {Shape(Sphere{0.2}), Shape(Plane{}), Shape(Capsule{0.6, 0.1}),
                             Shape(Cuboid{{0.4, 0.8, 0.2}})}) {
    std::mt19937_64 engine(7);
    std::normal_distribution<double> draw(0, 0.002);
    Points x = random_points(count, 1, 3);
    Pose pose;
    MotionBound motion;
    SleepBounds bounds;
    bounds.reset(count);
    std::vector<Span> near;
    int asleep = 0, far = 0;
    for (int k = 0; k < 200; ++k) {
      const Points start = x;
      for (int i = 0; i < x.size(); ++i) x.data()[i] += draw(engine);
      pose.position += Vector3(draw(engine), draw(engine), draw(engine));
      pose.orientation =
          (Eigen::AngleAxisd(draw(engine), Vector3(0.6, 0, 0.8)) * pose.orientation).normalized();
      motion.begin(start, x);
      bounds.follow(pose, longest_row(x.rowwise() - pose.position.transpose()));
      bounds.find_near(motion.total(), reach, near);

      Scalars distance(count);
      Points normals(count, 3);
      signed_distances(shape, Frame(pose), run_from(x, 0), Frame(pose), run_from(x, 0), count, {},
                       distance.data(), run_from(normals, 0));
      std::vector<char> is_near(count, 0);
      for (const Span& span : near) {
        std::fill(is_near.begin() + span.begin, is_near.begin() + span.end, 1);
        EXPECT_LE(span.end - span.begin, Span::longest);
      }
      for (int i = 0; i < count; ++i) {
        if (is_near[static_cast<std::size_t>(i)]) {
          bounds.keep(i, distance[i], motion.total());
        } else {
          ASSERT_GT(distance[i], reach) << i << " in step " << k;
          ++asleep;
        }
        far += distance[i] > reach;
      }
      motion.end(x);
    }
    EXPECT_GT(asleep, 0.8 * far);
  }
}

TEST(SleepBounds, WhatMovedBetweenStepsCounts) {
  Points x = Points::Zero(3, 3);
  MotionBound motion;
  motion.begin(x, x);
  EXPECT_EQ(motion.between_steps(), std::numeric_limits<double>::infinity());
  motion.end(x);
  const double before = motion.total();
  x(1, 2) = 0.3;
  Points next = x;
  next(2, 0) = -0.1;
  motion.begin(x, next);
  EXPECT_EQ(motion.between_steps(), 0.3);
  EXPECT_EQ(motion.in_step(), 0.1);
  EXPECT_NEAR(motion.total() - before, 0.4, 1e-15);
  next(2, 0) = -0.25;
  motion.update(x, next);
  EXPECT_NEAR(motion.total() - before, 0.55, 1e-15) << "from the step's start";

  SleepBounds bounds;
  bounds.reset(1);
  Pose pose;
  bounds.follow(pose, 1);
  bounds.keep(0, 1, 0);
  std::vector<Span> near;
  bounds.find_near(0, 0.9, near);
  EXPECT_TRUE(near.empty());
  pose.position.x() = 0.2;
  EXPECT_EQ(bounds.follow(pose, 1), 0.2);
  bounds.find_near(0, 0.9, near);
  EXPECT_EQ(near.size(), 1u);
}

}  // namespace
}  // namespace clothsim::sleep_bounds_test
