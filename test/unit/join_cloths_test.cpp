// Several cloths as one.

#include "clothsim/model/join_cloths.h"

#include <gtest/gtest.h>

#include <array>

#include "clothsim/dynamics/forces.h"
#include "clothsim/simulation/simulator.h"
#include "says.h"
#include "verification/mesh_fabric_testing.h"

namespace clothsim::join_cloths_test {
namespace {

using namespace test;

/// A grid of 4 x 3 points, and beside it a stiffer and heavier mesh of 5 x 4.
std::vector<NamedCloth> two_cloths() {
  ClothSpec grid = fabric_spec(4, 3, 0.1, 0.1);
  grid.material.fabric->internal_damping = {1e-3, 2e-2};
  grid.pinned = {{1, 2, "hand"}, {3, 0, "", 7.0}};
  grid.pin_strength = 5;
  grid.attached = {{"box", {{{2, 1}}}}};
  Material heavy = grid.material;
  heavy.density *= 3;
  heavy.fabric->stretch_stiffness = {900, 700};
  heavy.fabric->bending_stiffness = {5e-3, 2e-3};
  heavy.fabric->internal_damping = {4e-3, 1e-2};
  MeshTriangles triangles = triangles_of({5, 4, 0.4, 0.3});
  for (Vector3& vertex : triangles.vertices) vertex += Vector3(1, 0, 0);
  ClothSpec mesh = mesh_spec(triangles, heavy);
  mesh.thickness = 2 * grid.thickness;
  mesh.pinned = {{6, 0, "", {}}};
  return {{"napkin", grid}, {"flag", mesh}};
}

Points shaken_rows(const Points& x) {
  Points moved = x;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto angle = double(i);
    moved.row(i) +=
        2e-3 * Eigen::RowVector3d(std::sin(7 * angle), std::cos(5 * angle), std::sin(3 * angle));
  }
  return moved;
}

TEST(JoinCloths, HaveCellsOfAnyShape) {
  std::vector<NamedCloth> cloths = two_cloths();
  cloths[0].spec.width *= 20;
  const Cloth all = make_cloth(join_cloths(cloths));
  EXPECT_EQ(all.num_points(), cloths[0].spec.columns * cloths[0].spec.rows + 5 * 4);
}

TEST(JoinCloths, EachHasTheForcesThatItHasAlone) {
  const std::vector<NamedCloth> cloths = two_cloths();
  const ClothSpec joined = join_cloths(cloths);
  const Cloth all = make_cloth(joined);
  const Points x = shaken_rows(all.rest_positions);
  const Points v = shaken_rows(x) - x;  // with internal damping, each turns by itself
  Points together;
  compute_forces(all, Loads{Vector3(0, 0, -9.8)}, x, together, {}, &v);
  ASSERT_EQ(joined.parts.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const ClothPart& part = joined.parts[i];
    // A grid alone as a mesh: that of a list of one.
    const Cloth alone = make_cloth(join_cloths({cloths[i]}));
    Points forces;
    const Points own_v = v.middleRows(part.first_point, part.num_points());
    compute_forces(alone, Loads{Vector3(0, 0, -9.8)},
                   x.middleRows(part.first_point, part.num_points()), forces, {}, &own_v);
    const Points own = together.middleRows(part.first_point, part.num_points());
    EXPECT_GT(forces.norm(), 1e-3);
    EXPECT_LT((own - forces).norm(), 1e-12 * forces.norm()) << part.name;
    EXPECT_EQ(all.mass.segment(part.first_point, part.num_points()), alone.mass) << part.name;
  }
}

TEST(JoinCloths, AGridHasItsMassAndItsShape) {
  const std::vector<NamedCloth> cloths = two_cloths();
  const Cloth all = make_cloth(join_cloths(cloths)), grid = make_cloth(cloths[0].spec);
  EXPECT_EQ(all.rest_positions.topRows(12), grid.rest_positions);
  EXPECT_EQ(all.uv.topRows(12), grid.uv);
  const double area = 0.3 * 0.2, density = cloths[0].spec.material.density;
  EXPECT_NEAR(all.mass.head(12).sum(), area * density, 1e-12 * area * density);
}

TEST(JoinCloths, PinsAndPointsOnBodiesGoWithTheirCloth) {
  const ClothSpec joined = join_cloths(two_cloths());
  ASSERT_EQ(joined.pinned.size(), 3u);
  EXPECT_EQ(joined.pinned[0].column, 9);
  EXPECT_EQ(joined.pinned[0].frame, "hand");
  EXPECT_EQ(joined.pinned[0].strength, 5);
  EXPECT_EQ(joined.pinned[1].column, 3);
  EXPECT_EQ(joined.pinned[1].strength, 7);
  EXPECT_EQ(joined.pinned[2].column, 12 + 6);
  EXPECT_EQ(joined.pinned[2].strength, std::nullopt);
  EXPECT_EQ(joined.attached[0].points[0], (std::array<int, 2>{6, 0}));
  EXPECT_EQ(point_text(joined, 9, 0), "napkin [1, 2]");
  EXPECT_EQ(point_text(joined, 18, 0), "flag 6");
}

TEST(JoinCloths, AnUprightGridStartsUnevenly) {
  std::vector<NamedCloth> cloths = two_cloths();
  cloths[0].spec.orientation = Orientation::vertical;
  const ClothSpec joined = join_cloths(cloths);
  const Cloth cloth = make_cloth(joined);
  const Points moved = start_state(joined, cloth, 1).positions - cloth.rest_positions;
  EXPECT_GT(moved.topRows(12).col(1).cwiseAbs().minCoeff(), 0);
  EXPECT_LE(moved.cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(moved.bottomRows(20).norm(), 0);
}

std::string mistake(const std::vector<NamedCloth>& cloths) {
  try {
    join_cloths(cloths);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

TEST(JoinCloths, RefusesListsThatAreNone) {
  EXPECT_TRUE(says(mistake({}), "scene: got an empty list ... one or more"));
  std::vector<NamedCloth> cloths = two_cloths();
  cloths[1].name = "";
  EXPECT_TRUE(says(mistake(cloths), "1.name ... empty"));
  cloths[1].name = "napkin";
  EXPECT_TRUE(says(mistake(cloths), "1.name ... napkin ... again"));
  cloths = two_cloths();
  cloths[0].spec.material.fabric.reset();
  EXPECT_TRUE(says(mistake(cloths), "0.fabric ... none"));
  cloths = two_cloths();
  cloths[0].spec = fabric_spec(4, 1, 0.1, 0.1);
  EXPECT_TRUE(says(mistake(cloths), "0.rows ... at least 2"));
}

TEST(JoinCloths, RefusesValuesOfItsOwnThatCannotDiffer) {
  const auto with = [&](auto change) {
    std::vector<NamedCloth> cloths = two_cloths();
    change(cloths[1].spec);
    return mistake(cloths);
  };
  EXPECT_TRUE(says(with([](ClothSpec& c) { c.self_collision = SelfCollision::surface; }),
                   "1.self_collision ... surface ... napkin"));
  EXPECT_TRUE(says(with([](ClothSpec& c) { c.untangle = true; }), "1.untangle ... true ... false"));
}

// ---- Live values

Scene joined_scene() {
  Scene scene;
  scene.cloth = join_cloths(two_cloths());
  scene.cloth.attached.clear();
  return scene;
}

TEST(JoinCloths, AChangedValueIsThatOfAllCloths) {
  Simulator simulator(joined_scene());
  const auto part = [&](std::size_t i) { return simulator.scene().cloth.parts[i].material; };
  const double own = part(1).density;
  LiveSpec live = live_values(simulator.scene());
  live.material.fabric->shear_stiffness = 33;
  simulator.set(live);
  EXPECT_EQ(part(0).fabric->shear_stiffness, 33);
  EXPECT_EQ(part(1).fabric->shear_stiffness, 33);
  EXPECT_EQ(part(1).density, own);  // not that of the first
  EXPECT_EQ(part(1).fabric->stretch_stiffness[0], 900);

  live = live_values(simulator.scene());
  live.material.density = 0.5;
  simulator.set(live);
  EXPECT_EQ(part(1).density, 0.5);
  simulator.reset_values();
  EXPECT_EQ(part(1).density, own);
  EXPECT_EQ(part(1).fabric->shear_stiffness, two_cloths()[1].spec.material.fabric->shear_stiffness);
}

TEST(JoinCloths, EachHasItsOwnFriction) {
  std::vector<NamedCloth> cloths = two_cloths();
  cloths[0].spec.friction = 0.2;
  cloths[1].spec.friction = 0.8;
  Scene scene;
  scene.cloth = join_cloths(cloths);
  scene.cloth.attached.clear();
  Simulator simulator(scene);
  const int other = scene.cloth.parts[1].first_point;
  const auto frictions = [&] {
    const Cloth& cloth = simulator.cloth();
    return std::array<double, 3>{cloth.friction_between(0, 1), cloth.friction_between(0, other),
                                 cloth.friction_between(other + 1, other)};
  };
  const auto expect = [&](double one, double between, double second) {
    EXPECT_EQ(frictions()[0], one);
    EXPECT_NEAR(frictions()[1], between, 1e-15);
    EXPECT_EQ(frictions()[2], second);
  };
  expect(0.2, 0.4, 0.8);
  LiveSpec live = live_values(simulator.scene());
  live.cloths[1].friction = 0.05;  // of one
  simulator.set(live);
  expect(0.2, 0.1, 0.05);
  live = live_values(simulator.scene());
  live.material.density = 0.5;  // another value
  simulator.set(live);
  expect(0.2, 0.1, 0.05);
  live = live_values(simulator.scene());
  live.friction = 0.3;  // of all
  simulator.set(live);
  expect(0.3, 0.3, 0.3);
  simulator.reset_values();
  expect(0.2, 0.4, 0.8);
  live = live_values(simulator.scene());
  live.cloths[1].friction = -1;
  EXPECT_THROW(simulator.set(live), InvalidValue);
  expect(0.2, 0.4, 0.8);
}

TEST(JoinCloths, EachHasItsOwnThickness) {
  Simulator simulator(joined_scene());
  const double thin = two_cloths()[0].spec.thickness;
  const int other = simulator.scene().cloth.parts[1].first_point;
  const auto expect = [&](double one, double second) {
    const Cloth& cloth = simulator.cloth();
    EXPECT_EQ(cloth.thickness_at(other - 1), one);
    EXPECT_EQ(cloth.thickness_at(other), second);
    EXPECT_EQ(cloth.offset_at(0), one);
    EXPECT_EQ(cloth.offset_at(other), second);
    EXPECT_EQ(cloth.thickness, std::max(one, second));
    EXPECT_EQ(cloth.min_thickness(), std::min(one, second));
    EXPECT_EQ(cloth.offset, std::max(one, second));
    EXPECT_EQ(cloth.nearer_by(0), cloth.offset - one);
  };
  expect(thin, 2 * thin);
  LiveSpec live = live_values(simulator.scene());
  live.cloths[1].thickness = thin / 4;  // of one
  simulator.set(live);
  expect(thin, thin / 4);
  live = live_values(simulator.scene());
  live.thickness = 3 * thin;  // of all
  simulator.set(live);
  expect(3 * thin, 3 * thin);
  simulator.reset_values();
  expect(thin, 2 * thin);
  live = live_values(simulator.scene());
  live.cloths[1].thickness = -1;
  EXPECT_THROW(simulator.set(live), InvalidValue);
  expect(thin, 2 * thin);
}

TEST(JoinCloths, AClothMayChangeAlone) {
  Simulator simulator(joined_scene());
  LiveSpec live = live_values(simulator.scene());
  live.cloths[1].material.density = 9;
  simulator.set(live);
  const ClothPart& flag = simulator.scene().cloth.parts[1];
  EXPECT_NEAR(simulator.cloth().mass.segment(flag.first_point, 20).sum(), 9 * 0.4 * 0.3, 1e-12);
  EXPECT_EQ(simulator.scene().cloth.parts[0].material.density, live.material.density);
  live = live_values(simulator.scene());
  live.cloths[0].material.density = 4;
  simulator.set(live);
  EXPECT_EQ(simulator.scene().cloth.material.density, 4);
  EXPECT_EQ(simulator.scene().cloth.parts[1].material.density, 9);
  live.cloths.pop_back();
  EXPECT_THROW(simulator.set(live), InvalidValue);
}

}  // namespace
}  // namespace clothsim::join_cloths_test
