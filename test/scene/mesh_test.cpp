// Cloths of any shape in whole scenes.

#include <cmath>

#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/motion_player.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::mesh_test {
namespace {

using namespace test;

/// A cotton of 0.3 m hung by two corners, with drag to come to rest.
Scene hung(const ClothSpec& cloth) {
  Scene scene;
  scene.cloth = cloth;
  scene.cloth.material.damping = 3;
  return scene;
}

Material cotton() {
  Material m = fabric_spec(2, 2, 0.1, 0.1).material;
  m.fabric->stretch_stiffness = {300, 300};
  m.fabric->shear_stiffness = 20;
  m.fabric->bending_stiffness = {2e-4, 2e-4};
  return m;
}

Points after(Simulator& simulator, double time) {
  while (simulator.state().time < time) simulator.step();
  return simulator.state().positions;
}

TEST(Mesh, HangsAsTheGridDoes) {
  constexpr int points = 13;
  ClothSpec grid = fabric_spec(points, points, 0.025, 0.025);
  grid.material = cotton();
  grid.pinned = {{0, 0, "", {}}, {points - 1, 0, "", {}}};
  Simulator of_grid(hung(grid));

  ClothSpec mesh = mesh_spec(triangles_of({points, points, 0.3, 0.3, 0, 0.15}), cotton());
  mesh.pinned = {};
  for (int i = 0; i < mesh.columns; ++i) {
    const Vector3 x = row(mesh.mesh->positions, i);
    if (x.y() == 0 && (x.x() == 0 || x.x() == 0.3)) mesh.pinned.push_back({i, 0, "", {}});
  }
  ASSERT_EQ(mesh.pinned.size(), 2u);
  Simulator of_mesh(hung(mesh));

  const Points g = after(of_grid, 6), m = after(of_mesh, 6);
  EXPECT_LT(rms_velocity(of_mesh.state()), 2e-3);
  EXPECT_NEAR(m.col(2).minCoeff(), g.col(2).minCoeff(), 0.01 * 0.3);
  EXPECT_NEAR(m.col(2).mean(), g.col(2).mean(), 0.01 * 0.3);
}

TEST(Mesh, PinsBearItsWeight) {
  ClothSpec spec = mesh_spec(triangles_of({13, 13, 0.3, 0.3, 0, 0.15}), cotton());
  spec.pinned = {{0, 0, "", {}}};
  Scene scene = hung(spec);
  scene.cloth.material.damping = 10;
  for (const char* method : {"verlet", "xpbd", "implicit_euler"}) {
    scene.simulation.method = method;
    Simulator simulator(scene);
    after(simulator, 4);
    const double weight = simulator.cloth().mass.sum() * 9.8;
    EXPECT_NEAR(simulator.holders().front().force, weight, 0.02 * weight) << method;
  }
}

TEST(Mesh, PinsOfARestingCurvedClothBearNothing) {
  // Stiff and rolled, without gravity: the terms of its bends on the pins cancel.
  MeshTriangles triangles = triangles_of({13, 13, 0.3, 0.3, 0, 0.15});
  for (Vector3& p : triangles.vertices) {
    p = {0.1 * std::sin(10 * p.x()), p.y(), 0.1 * std::cos(10 * p.x())};
  }
  Material stiff = cotton();
  stiff.fabric->bending_stiffness = {2e-2, 2e-2};
  ClothSpec spec = curved_spec(triangles, stiff);
  for (int i = 0; i < spec.columns; i += 5) spec.pinned.push_back({i, 0, "", {}});
  Scene scene = hung(spec);
  scene.simulation.gravity.setZero();
  for (const char* method : {"verlet", "xpbd", "implicit_euler", "bdf2"}) {
    scene.simulation.method = method;
    Simulator simulator(scene);
    after(simulator, 0.1);
    for (const auto& holder : simulator.holders()) EXPECT_LT(holder.force, 1e-9) << method;
  }
}

TEST(Mesh, FallsWithItsMomenta) {
  // Free and without drag: a spinning sheet keeps both momenta.
  ClothSpec spec = mesh_spec(triangles_of({13, 9, 0.3, 0.2, 0, 0.15}), cotton());
  spec.material.fabric->internal_damping = {1e-4, 0};
  spec.material.damping = 0;
  Scene scene;
  scene.cloth = spec;
  scene.cloth.material.damping = 0;
  scene.simulation.gravity.setZero();
  scene.simulation.method = "verlet";
  Simulator simulator(scene);
  State state = simulator.state();
  const Vector3 omega(1, 2, 8);
  for (int i = 0; i < simulator.cloth().num_points(); ++i) {
    state.velocities.row(i) = omega.cross(row(state.positions, i)).transpose();
  }
  simulator.set_state(state);
  const auto momenta = [&] {
    const Cloth& cloth = simulator.cloth();
    Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();
    for (int i = 0; i < cloth.num_points(); ++i) {
      const Vector3 p = cloth.mass[i] * row(simulator.state().velocities, i);
      linear += p;
      angular += row(simulator.state().positions, i).cross(p);
    }
    return std::pair(linear, angular);
  };
  const auto before = momenta();
  after(simulator, 2);
  const auto now = momenta();
  EXPECT_LT((now.first - before.first).norm(), 1e-12 * before.first.norm());
  EXPECT_LT((now.second - before.second).norm(), 1e-11 * before.second.norm());
}

/// A sheet in four pleats, held at three points of its upper edge.
ClothSpec pleats(bool curved) {
  Sheet sheet{17, 11, 0.16, 0.2};
  MeshTriangles triangles = triangles_of(sheet);
  for (Vector3& p : triangles.vertices) {
    const double along = p.x() / 0.04, fold = std::abs(along - std::round(along));
    p = {p.x(), 0.04 * (fold - 0.25), -p.y()};
  }
  Material felt = cotton();
  felt.density = 0.25;
  felt.damping = 3;
  ClothSpec spec = curved ? curved_spec(triangles, felt) : mesh_spec(triangles, felt);
  for (int i = 0; i < spec.columns; ++i) {
    const Vector3 x = row(spec.mesh->positions, i);
    const bool is_held = x.x() == 0.01 || std::abs(x.x() - 0.07) < 1e-9 || x.x() == 0.15;
    if (x.z() == 0 && is_held) spec.pinned.push_back({i, 0, "", {}});
  }
  EXPECT_EQ(spec.pinned.size(), 3u);
  return spec;
}

TEST(Mesh, KeepsItsShapeAtRest) {
  const auto change = [](bool curved, const std::string& method) {
    Scene scene;
    scene.cloth = pleats(curved);
    scene.simulation.method = method;
    if (method == "xpbd") scene.simulation.substeps = 20;
    Simulator simulator(scene);
    const Points start = simulator.state().positions;
    const Points end = after(simulator, 3);
    if (curved) {
      EXPECT_LT(rms_velocity(simulator.state()), 2e-3) << method;
    }
    return (end - start).rowwise().norm().maxCoeff();
  };
  for (const char* method : {"verlet", "xpbd", "implicit_euler", "bdf2"}) {
    EXPECT_LT(change(true, method), 0.004) << method;
    EXPECT_GT(change(false, method), 0.012) << method;
  }
}

TEST(Mesh, HasEqualBitsFromThreadsAndAfterRestore) {
  ClothSpec spec = mesh_spec(triangles_of({30, 30, 0.3, 0.3, 0, 0.15, 0, true}), cotton());
  spec.pinned = {{0, 0, "", {}}};
  spec.self_collision = SelfCollision::surface;
  Scene scene = hung(spec);
  Simulator one(scene);
  scene.simulation.threads = 4;
  Simulator four(scene);
  after(one, 0.3);
  const auto saved = one.save();
  const Points x = after(one, 0.5);
  EXPECT_EQ(x, after(four, 0.5));
  one.restore(*saved);
  EXPECT_EQ(x, after(one, 0.5));
}

TEST(Mesh, HasEqualBitsInAnotherSimulator) {
  // bdf2 has a history, which a saved state keeps.
  ClothSpec spec = mesh_spec(triangles_of({9, 9, 0.3, 0.3, 0, 0.15}), cotton());
  spec.pinned = {{0, 0, "", {}}};
  Scene scene = hung(spec);
  scene.simulation.method = "bdf2";
  Simulator one(scene), other(scene);
  after(one, 0.2);
  other.restore(*one.save());
  LiveSpec live = live_values(scene);
  live.friction = 0.31;  // without self collision no motion depends on it
  one.set(live);
  EXPECT_EQ(after(one, 0.4), after(other, 0.4));
}

TEST(Mesh, RefusesAThicknessThatNeedsGigabytes) {
  ClothSpec spec = mesh_spec(triangles_of({40, 40, 0.1, 0.1}), cotton());
  spec.self_collision = SelfCollision::surface;
  spec.thickness = 0.0095;
  EXPECT_THROW(Simulator{hung(spec)}, InvalidValue);
  spec.thickness = 0.001;
  Simulator simulator(hung(spec));
  LiveSpec live = live_values(simulator.scene());
  live.thickness = 0.02;
  EXPECT_THROW(simulator.set(live), InvalidValue);
  simulator.step();
}

TEST(Mesh, LiveValuesChangeItsFabric) {
  ClothSpec spec = mesh_spec(triangles_of({13, 13, 0.3, 0.3, 0, 0.15}), cotton());
  spec.pinned = {{0, 0, "", {}}};
  Simulator simulator(hung(spec));
  after(simulator, 0.5);
  Material softer = simulator.scene().cloth.material;
  softer.fabric->stretch_stiffness = {30, 30};
  softer.density *= 2;
  const double mass = simulator.cloth().mass.sum();
  const double stretch = worst_stretch(simulator.cloth(), simulator.state().positions);
  simulator.set_material(softer);
  EXPECT_NEAR(simulator.cloth().mass.sum(), 2 * mass, 1e-12);
  after(simulator, 2.5);
  EXPECT_GT(worst_stretch(simulator.cloth(), simulator.state().positions), 3 * stretch);
}

TEST(Mesh, KeepsItsStrainLimit) {
  ClothSpec spec = mesh_spec(triangles_of({13, 13, 0.3, 0.3, 0, 0.15}), cotton());
  spec.material.fabric->stretch_stiffness = {5, 5};
  spec.material.fabric->shear_stiffness = 1;
  spec.material.strain_limit = 0.1;
  spec.pinned = {{0, 0, "", {}}, {12, 0, "", {}}};
  Simulator simulator(hung(spec));
  double worst = 0;
  while (simulator.state().time < 2) {
    simulator.step();
    worst = std::max(worst, worst_stretch(simulator.cloth(), simulator.state().positions));
  }
  EXPECT_LT(worst, 0.13);
  EXPECT_GT(worst, 0.099);
}

TEST(Mesh, ShirtIsFoldedOnceWithoutCrossings) {
  const Scene scene = shipped_scene("t_shirt");
  Simulator simulator(scene);
  MotionPlayer player(simulator, "");
  const double width = simulator.state().positions.col(0).maxCoeff();
  int frame = 0;
  while (simulator.state().time < 2.2) {
    player.play(simulator);
    simulator.step();
    ASSERT_TRUE(simulator.state().positions.allFinite());
    if (++frame % 6 == 0) {
      ASSERT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0) << frame;
    }
  }
  EXPECT_GT(width, 0.4);
  EXPECT_LT(simulator.state().positions.col(0).maxCoeff(), 0.18);
}

TEST(Mesh, OneLegOfTrousersIsFoldedOverTheOther) {
  YAML::Node root = load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/trousers.yaml");
  root["cloth"]["pattern"]["cell"] = 0.04;  // a quarter of the points
  const Scene scene = read_scene(root);
  Simulator simulator(scene);
  MotionPlayer player(simulator, ".");
  const auto leg = [&](const char* side) {  // the middle of a hem
    Vector3 sum = Vector3::Zero();
    const std::vector<int>& points = scene.cloth.pattern->sides.at(side);
    for (const int i : points) sum += row(simulator.state().positions, i);
    return Vector3(sum / double(points.size()));
  };
  const Vector3 left = leg("back.1");
  while (simulator.state().time < 4) {
    player.play(simulator);
    simulator.step();
  }
  EXPECT_EQ(count_intersections(simulator.cloth(), simulator.state().positions), 0);
  EXPECT_LT((leg("back.1") - left).norm(), 0.02);             // stays
  EXPECT_LT((leg("front.4") - left).head<2>().norm(), 0.05);  // lies on it
  EXPECT_GT(leg("back.4").z(), leg("front.1").z());
  EXPECT_LT(rms_velocity(simulator.state()), 2e-3);
}

}  // namespace
}  // namespace clothsim::mesh_test
