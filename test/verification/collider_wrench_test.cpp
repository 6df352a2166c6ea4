// Wrenches of a cloth on colliders: weights, balances of momentum, moments of weights on arms.

#include <cmath>
#include <functional>

#include "verification/testing.h"

namespace clothsim::collider_wrench_test {
namespace {

using namespace test;

constexpr double g = 9.8;  // [m/s^2]

ColliderSpec collider(const char* name, const Shape& shape, const Vector3& position,
                      double friction = 0.5) {
  ColliderSpec spec;
  spec.name = name;
  spec.shape = shape;
  spec.pose.position = position;
  spec.friction = friction;
  return spec;
}

/// A cloth of 1 m and 5 kg, half a millimetre over z = 0.
Scene over(const std::vector<ColliderSpec>& colliders, int side = 15) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.origin = {0, 0, 5e-4};
  scene.cloth.material.density = 5;
  scene.colliders = colliders;
  return scene;
}

/// Steps for `seconds`, then measures the wrench of one more frame.
Wrench measure_wrench(Simulator& simulator, double seconds, std::size_t index = 0) {
  run(simulator, seconds);
  simulator.measure_wrenches(true);
  simulator.step();
  return simulator.collider_wrenches()[index];
}

Vector3 momentum(const Simulator& simulator) {
  return (simulator.state().velocities.transpose() * simulator.cloth().mass);
}

/// About `origin`, of all points.
Vector3 moment_of_weight(const Simulator& simulator, const Vector3& origin) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < simulator.cloth().num_points(); ++i) {
    const Vector3 arm = row(simulator.state().positions, i) - origin;
    sum += simulator.cloth().mass[i] * arm.cross(simulator.scene().simulation.gravity);
  }
  return sum;
}

TEST(ColliderWrench, APlaneBearsTheWeight) {
  // F = -m g, about the plane's origin a corner of the cloth: m g on arms of half its sides.
  Simulator simulator(over({collider("ground", Plane{}, {0, 0, 0})}));
  const Wrench wrench = measure_wrench(simulator, 2);
  EXPECT_LT((wrench.force - Vector3(0, 0, -5 * g)).norm(), 1e-6 * 5 * g);
  EXPECT_LT((wrench.torque - 5 * g * Vector3(-0.5, 0.5, 0)).norm(), 1e-6 * 5 * g);
}

TEST(ColliderWrench, TheWeightIsThatOfEveryMethodWithAndWithoutDrag) {
  for (const std::string& method : method_names()) {
    for (const double damping : {0.0, 5.4, 100.0}) {
      Scene scene = over({collider("ground", Plane{}, {0, 0, 0})}, 8);
      scene.simulation.method = method;
      scene.cloth.material.damping = damping;
      Simulator simulator(scene);
      const Wrench wrench = measure_wrench(simulator, 1);
      EXPECT_LT((wrench.force - Vector3(0, 0, -5 * g)).norm(), 1e-5 * 5 * g)
          << method << ' ' << damping;
    }
  }
}

TEST(ColliderWrench, JawsThatHoldAClothByFrictionBearItsWeight) {
  // They leave its upper edge no room, and carry half each, as their friction is the same.
  Scene scene = over({collider("left", Cuboid{{0.3, 0.02, 0.06}}, {0.1, -0.0095, 0.2}, 1),
                      collider("right", Cuboid{{0.3, 0.02, 0.06}}, {0.1, 0.0095, 0.2}, 1)},
                     10);
  scene.cloth.orientation = Orientation::vertical;
  scene.cloth.width = scene.cloth.height = 0.2;
  scene.cloth.origin = {0, 0, 0};
  scene.cloth.material.damping = 20;
  Simulator simulator(scene);
  const Wrench left = measure_wrench(simulator, 3), right = simulator.collider_wrenches()[1];
  const double weight = 5 * 0.04 * g;
  EXPECT_GT(simulator.step().pinched, 0);
  EXPECT_LT((left.force + right.force - Vector3(0, 0, -weight)).norm(), 1e-3 * weight);
  EXPECT_NEAR(left.force.z(), -weight / 2, 0.01 * weight);
}

TEST(ColliderWrench, NobodyAskedNothingIsSummed) {
  Simulator simulator(over({collider("ground", Plane{}, {0, 0, 0})}));
  run(simulator, 0.2);
  ASSERT_EQ(simulator.collider_wrenches().size(), 1u);
  EXPECT_EQ(simulator.collider_wrenches()[0].force, Vector3::Zero());
  simulator.measure_wrenches(true);
  simulator.step();
  EXPECT_LT(simulator.collider_wrenches()[0].force.z(), -1);
  simulator.measure_wrenches(false);
  EXPECT_EQ(simulator.collider_wrenches()[0].force, Vector3::Zero());
}

TEST(ColliderWrench, AnInclineHoldsByFriction) {
  // At rest on a slope of 20 degrees, tan < 0.5: the whole weight, straight down, though the plane
  // can push along its normal alone.
  ColliderSpec slope = collider("slope", Plane{}, {0, 0, 0});
  const double angle = 20 * M_PI / 180;
  slope.pose.orientation = Eigen::AngleAxisd(angle, Vector3::UnitX());
  Scene scene = over({slope});
  scene.simulation.gravity = g * Vector3(0, 0, -1);
  Simulator simulator(scene);
  const Wrench wrench = measure_wrench(simulator, 4);
  EXPECT_LT((wrench.force - Vector3(0, 0, -5 * g)).norm(), 1e-3 * 5 * g);
}

TEST(ColliderWrench, OnAnInclineThatItSlipsOnFrictionIsThatOfCoulomb) {
  // tan 40 degrees > 0.5: m g cos across, 0.5 m g cos along.
  Scene scene = over({collider("slope", Plane{}, {0, 0, 0})});
  const double angle = 40 * M_PI / 180;
  scene.simulation.gravity = g * Vector3(std::sin(angle), 0, -std::cos(angle));
  scene.cloth.material.damping = 0;
  Simulator simulator(scene);
  const Wrench wrench = measure_wrench(simulator, 1);
  const double press = 5 * g * std::cos(angle);
  EXPECT_LT((wrench.force - press * Vector3(0.5, 0, -1)).norm(), 1e-3 * press);
}

TEST(ColliderWrench, ASphereBearsTheWeight) {
  Simulator simulator(over({collider("sphere", Sphere{0.3}, {0.5, 0.5, -0.31}, 2)}));
  const Wrench wrench = measure_wrench(simulator, 6);
  EXPECT_LT((wrench.force - Vector3(0, 0, -5 * g)).norm(), 1e-3 * 5 * g);
  const Vector3 expected = moment_of_weight(simulator, {0.5, 0.5, -0.31});
  EXPECT_LT((wrench.torque - expected).norm(), 1e-3 * 5 * g * 0.3);
}

TEST(ColliderWrench, CollidersAndHandsShareTheWeight) {
  // Over the edge of a box, one corner held up: forces and moments about one point add up.
  Scene scene = over({collider("ground", Plane{}, {0, 0, -0.2}),
                      collider("box", Cuboid{{0.5, 2, 0.1}}, {0.5, 0.5, -0.05})});
  scene.cloth.material.damping = 20;
  Simulator simulator(scene);
  simulator.attach("hand", {Vector3(0, 0, 0.1), Eigen::Quaterniond::Identity()}, {0, 1});
  run(simulator, 6);
  simulator.measure_wrenches(true);
  simulator.step();
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
  const auto add = [&](const Wrench& wrench, const Vector3& origin) {
    force += wrench.force;
    torque += wrench.torque + origin.cross(wrench.force);
  };
  for (int i : {0, 1}) {
    const Wrench& wrench = simulator.collider_wrenches()[static_cast<std::size_t>(i)];
    EXPECT_LT(wrench.force.z(), -1) << i << " bears nothing";
    add(wrench, simulator.collider_pose(i).position);
  }
  add(simulator.grips().at("hand").wrench, simulator.grips().at("hand").pose.position);
  EXPECT_LT((force - Vector3(0, 0, -5 * g)).norm(), 2e-3 * 5 * g);
  EXPECT_LT((torque - moment_of_weight(simulator, Vector3::Zero())).norm(), 2e-3 * 5 * g);
}

TEST(ColliderWrench, TorqueIsThatOfAWeightOverAnEdge) {
  // Over a rail by friction, with 0.2 m more of it on one side: that turns the rail about y.
  Scene scene = over({collider("rail", Cuboid{{0.2, 2, 0.2}}, {0, 0.5, -0.2}, 1e3)}, 21);
  scene.cloth.origin = {-0.4, 0, -0.0999};
  scene.cloth.material.damping = 20;
  Simulator simulator(scene);
  const Wrench wrench = measure_wrench(simulator, 5);
  EXPECT_LT((wrench.force - Vector3(0, 0, -5 * g)).norm(), 1e-3 * 5 * g);
  const Vector3 expected = moment_of_weight(simulator, {0, 0.5, -0.2});
  EXPECT_GT(std::abs(expected.y()), 1) << "hangs evenly";
  EXPECT_LT((wrench.torque - expected).norm(), 1e-3 * 5 * g * 0.5);
}

/// Without drag: in each frame the change of the cloth's momentum is m g dt less the impulses on
/// the colliders, to rounding.
void expect_balance(const Scene& scene, const std::function<void(Simulator&, int)>& move) {
  Simulator simulator(scene);
  simulator.measure_wrenches(true);
  const double dt = simulator.frame_duration();
  const Vector3 weight = simulator.cloth().mass.sum() * scene.simulation.gravity;
  double hardest = 0;
  for (int frame = 0; frame < 60; ++frame) {
    move(simulator, frame);
    const Vector3 before = momentum(simulator);
    simulator.step();
    Vector3 force = Vector3::Zero();
    for (const Wrench& wrench : simulator.collider_wrenches()) force += wrench.force;
    EXPECT_LT((momentum(simulator) - before - dt * (weight - force)).norm(), 1e-10) << frame;
    hardest = std::max(hardest, force.norm());
  }
  EXPECT_GT(hardest, weight.norm());
}

TEST(ColliderWrench, MomentumBalancesOnAFallAndUnderAPush) {
  Scene scene = over({collider("ground", Plane{}, {0, 0, -0.3}),
                      collider("pusher", Sphere{0.15}, {-0.3, 0.5, 0}),
                      collider("edge", Cuboid{{0.3, 0.3, 0.3}}, {0.8, 0.8, -0.3})});
  scene.cloth.material.damping = 0;
  expect_balance(scene, [](Simulator& simulator, int frame) {
    simulator.move_collider(1,
                            {Vector3(-0.3 + 0.01 * frame, 0.5, 0), Eigen::Quaterniond::Identity()});
  });
}

TEST(ColliderWrench, MomentumBalancesBetweenJawsThatLeaveNoRoom) {
  Scene scene = over({collider("upper", Cuboid{{0.3, 0.3, 0.1}}, {0.5, 0.5, 0.2}, 0.6),
                      collider("lower", Cuboid{{0.3, 0.3, 0.1}}, {0.5, 0.5, -0.2}, 0.6)});
  scene.cloth.material.damping = 0;
  for (const bool limited : {true, false}) {
    if (!limited) scene.cloth.material.strain_limit.reset();
    expect_balance(scene, [](Simulator& simulator, int frame) {
      const double gap = std::max(-0.001, 0.3 - 0.01 * frame) / 2 + 0.05;
      simulator.move_collider(0, {Vector3(0.5, 0.5, gap), Eigen::Quaterniond::Identity()});
      simulator.move_collider(1, {Vector3(0.5, 0.5, -gap), Eigen::Quaterniond::Identity()});
    });
  }
}

TEST(ColliderWrench, IsTheSameWithTwoThreadsAndAfterComingBack) {
  Scene scene = over({collider("ground", Plane{}, {0, 0, -0.1}),
                      collider("sphere", Sphere{0.2}, {0.5, 0.5, -0.2})},
                     25);
  Scene threaded = scene;
  threaded.simulation.threads = 2;
  Simulator one(scene), two(threaded), unasked(scene);
  one.measure_wrenches(true);
  two.measure_wrenches(true);
  run(one, 0.3);
  run(two, 0.3);
  run(unasked, 0.3);
  EXPECT_EQ(one.state().positions, unasked.state().positions) << "weighing moves the cloth";
  const auto saved = one.save();
  const auto expect_same = [&](const Simulator& a, const Simulator& b) {
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(a.collider_wrenches()[i].force, b.collider_wrenches()[i].force);
      EXPECT_EQ(a.collider_wrenches()[i].torque, b.collider_wrenches()[i].torque);
    }
  };
  expect_same(one, two);
  run(one, 0.1);
  const std::vector<Wrench> later = one.collider_wrenches();
  EXPECT_GT(later[1].force.norm(), 1);
  one.restore(*saved);
  expect_same(one, two);
  run(one, 0.1);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(one.collider_wrenches()[i].force, later[i].force);
  one.reset();
  EXPECT_EQ(one.collider_wrenches()[0].force, Vector3::Zero());
}

}  // namespace
}  // namespace clothsim::collider_wrench_test
