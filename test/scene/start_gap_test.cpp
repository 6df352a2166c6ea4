// Fabrics that start nearer to a collider than their thickness, or get a larger one.

#include <algorithm>

#include "clothsim/constraints/least_distance.h"
#include "clothsim/dynamics/integrator.h"
#include "clothsim/scene/scene_yaml.h"
#include "verification/testing.h"

namespace clothsim::start_gap_test {
namespace {

using namespace test;

constexpr double top = 0.35;  // of the colliders [m]

/// A light stiff sheet of 0.3 m, a `gap` above a collider.
Scene sheet_above(const Shape& shape, double height, double gap, const std::string& method) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 31;
  scene.cloth.width = scene.cloth.height = 0.3;
  scene.cloth.origin = {-0.15, -0.15, top + gap};
  scene.cloth.thickness = 0.0095;
  Material& material = scene.cloth.material;
  material.fabric = Fabric{{1000, 1000}, 100, {1e-6, 1e-6}, {}};
  material.density = 0.15;
  material.damping = 0;
  material.strain_limit.reset();
  scene.colliders = {{"body", shape, {Vector3(0, 0, height)}, 0.3, ""}};
  scene.simulation.method = method;
  scene.simulation.frames_per_second = 60;
  return scene;
}

double highest_upward(const Simulator& simulator) {
  return simulator.state().velocities.col(2).maxCoeff();
}

TEST(StartGap, GrowsSlowly) {
  const Pose lying{{0, 0, 0.3}, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()))};
  for (const char* method : {"verlet", "xpbd"}) {
    for (const double gap : {0.0005, 0.002, 0.008}) {
      for (const auto& [shape, height] : {std::pair<Shape, double>{Plane{}, top},
                                          {Cuboid{{0.2, 0.2, 0.1}}, 0.3},
                                          {Sphere{0.05}, 0.3},
                                          {Cylinder{0.1, 0.1}, 0.3},
                                          {Capsule{0.2, 0.05}, 0.3}}) {
        Scene scene = sheet_above(shape, height, gap, method);
        if (std::holds_alternative<Capsule>(shape)) scene.colliders[0].pose = lying;
        Simulator simulator(scene);
        double upward = 0;
        for (int frame = 0; frame < 6; ++frame) {
          simulator.step();
          upward = std::max(upward, highest_upward(simulator));
        }
        // Flaps swing at this speed. A lift at once threw points at 13 to 37 m/s.
        EXPECT_LT(upward, 1.5) << method << ' ' << gap << ' ' << shape.index();
      }
    }
  }
}

TEST(StartGap, GrowsAtATenthOfAMetreASecondToTheThickness) {
  Simulator simulator(sheet_above(Plane{}, top, 0.002, "verlet"));
  for (int frame = 1; frame <= 12; ++frame) {
    simulator.step();
    const double expected = std::min(0.0095, 0.002 + 0.1 * frame / 60);
    EXPECT_NEAR(simulator.state().positions.col(2).minCoeff() - top, expected, 1e-4) << frame;
  }
}

TEST(StartGap, GrowsAlsoAfterALiveChangeOfTheThickness) {
  Simulator simulator(sheet_above(Sphere{0.05}, 0.3, 0.01, "verlet"));
  simulator.step();
  LiveSpec live = live_values(simulator.scene());
  live.thickness = 0.02;
  simulator.set(live);
  for (int frame = 0; frame < 6; ++frame) {
    simulator.step();
    EXPECT_LT(highest_upward(simulator), 1.5);
  }
  EXPECT_NEAR(simulator.cloth().offset, 0.0195, 1e-12);
  live.thickness = 0.005;
  simulator.set(live);
  EXPECT_EQ(simulator.cloth().offset, 0.005);
}

TEST(StartGap, IsThatOfEachClothInAnUpdate) {
  // Two cloths far apart, the second one thin and near: neither jumps, nor after it gets thicker.
  YAML::Node root = YAML::Load(R"(
colliders: [{name: floor, shape: plane}]
cloths:
- {name: thick, fabric: linen, width: 0.2, height: 0.2, columns: 9, rows: 9, thickness: 0.02, origin: [0, 0, 0.02]}
- {name: thin, fabric: linen, width: 0.2, height: 0.2, columns: 9, rows: 9, thickness: 0.005, origin: [1, 0, 0.0005]}
)");
  Simulator simulator(read_scene(root));
  const int second = simulator.cloth().first_points[1];
  const auto height = [&] { return simulator.state().positions(second, 2); };
  double last = height();
  const auto rises_slowly = [&](int frames) {
    for (int frame = 0; frame < frames; ++frame) {
      simulator.step();
      EXPECT_LT(height() - last, 0.1 / 90 + 1e-4);
      last = height();
    }
  };
  rises_slowly(30);
  EXPECT_NEAR(last, 0.005, 1e-4);
  LiveSpec live = live_values(simulator.scene());
  live.cloths[1].thickness = 0.015;
  simulator.set(live);
  rises_slowly(30);
  EXPECT_NEAR(last, 0.015, 1e-4);
  EXPECT_NEAR(simulator.state().positions(0, 2), 0.02, 1e-4);
}

TEST(StartGap, GrowsWithoutGravityInEveryMethod) {
  for (const std::string& method : method_names()) {
    Scene scene = sheet_above(Sphere{0.05}, 0.3, 0.002, method);
    scene.simulation.gravity = Vector3::Zero();
    if (method == "implicit_euler" || method == "bdf2") scene.simulation.substeps = 4;
    Simulator simulator(scene);
    for (int frame = 0; frame < 10; ++frame) simulator.step();
    EXPECT_LT(highest_upward(simulator), 0.5) << method;
    EXPECT_EQ(simulator.cloth().offset, 0.0095) << method;
  }
}

TEST(StartGap, GoesOnWithTheSameBitsInARestoredState) {
  const Scene scene = sheet_above(Sphere{0.05}, 0.3, 0.002, "verlet");
  Simulator one(scene), other(scene);
  for (int frame = 0; frame < 2; ++frame) one.step();
  other.restore(*one.save());
  EXPECT_LT(one.cloth().offset, 0.0095);
  for (int frame = 0; frame < 5; ++frame) {
    one.step();
    other.step();
    EXPECT_EQ(one.state().positions, other.state().positions);
  }
}

TEST(LeastDistance, IsThatOfTheNearestPointOrTriangle) {
  const Simulator simulator(sheet_above(Sphere{0.05}, 0.3, 0.002, "verlet"));
  std::vector<MovingCollider> colliders{MovingCollider(simulator.scene().colliders[0])};
  const Cloth& cloth = simulator.cloth();
  Points x = cloth.rest_positions;
  EXPECT_NEAR(least_distance(colliders, cloth, x), 0.002, 1e-12);  // of the middle point
  x.rowwise() += Eigen::RowVector3d(0.005, 0.0025, 0);             // now in a triangle
  EXPECT_NEAR(least_distance(colliders, cloth, x), 0.002, 1e-12);
  x.col(2).array() -= 0.01;
  EXPECT_NEAR(least_distance(colliders, cloth, x), -0.008, 1e-12);
  Cloth held = cloth;
  held.inv_mass.setZero();
  EXPECT_EQ(least_distance(colliders, held, x), cloth.offset);
  x.col(2).array() += 0.02;
  EXPECT_EQ(least_distance(colliders, cloth, x), cloth.offset);
  x.col(2).array() -= 0.02;
  colliders[0].enable(false);
  EXPECT_EQ(least_distance(colliders, cloth, x), cloth.offset);
}

}  // namespace
}  // namespace clothsim::start_gap_test
