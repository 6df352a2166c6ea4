#include "rviz/cloth_mesh.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "clothsim/model/errors.h"
#include "clothsim/model/grid.h"
#include "clothsim/model/surface.h"
#include "clothsim/ros/conversions.h"
#include "rviz/color_map.h"
#include "says.h"

namespace clothsim_rviz::cloth_mesh_test {
namespace {

using clothsim::says;

using clothsim::Vector3;

/// A cloth of 5 x 4 points with its springs, 0.4 m x 0.3 m.
clothsim::Cloth make_cloth() {
  clothsim::ClothSpec spec;
  spec.columns = 5;
  spec.rows = 4;
  spec.width = 0.4;
  spec.height = 0.3;
  return clothsim::make_grid(spec);
}

clothsim::ClothTopology make_topology(const clothsim::Cloth& cloth) {
  return clothsim_ros::to_topology_msg(cloth, {}, {}, 7);
}

clothsim::ClothState make_state(const clothsim::Points& positions) {
  clothsim::State state;
  state.positions = positions;
  state.velocities = clothsim::Points::Zero(positions.rows(), 3);
  return clothsim_ros::to_state_msg(state, {}, {}, 7, 0);
}

/// The message of the exception of `call`.
template <class Call>
std::string mistake(Call call) {
  try {
    call();
  } catch (const clothsim::InvalidValue& error) {
    return error.what();
  }
  return "";
}

TEST(ClothMesh, NormalsAreThoseOfTheCore) {
  const clothsim::Cloth cloth = make_cloth();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-0.1, 0.1);
  clothsim::Points positions = cloth.rest_positions;
  for (Eigen::Index i = 0; i < positions.size(); ++i) positions.data()[i] += anywhere(random);

  const clothsim::Points expected = clothsim::vertex_normals(positions, cloth.triangles);
  std::vector<float> normals;
  find_normals(make_state(positions).positions, make_topology(cloth).triangles, normals);
  ASSERT_EQ(normals.size(), static_cast<std::size_t>(expected.size()));
  for (int i = 0; i < expected.rows(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto index = static_cast<std::size_t>(3 * i + axis);
      EXPECT_NEAR(normals[index], expected(i, axis), 1e-4) << "point " << i;
    }
  }
}

TEST(ClothMesh, NormalsOfPointsInOnePlace) {
  std::vector<float> normals;
  find_normals(std::vector<float>(9, 1), {0, 1, 2}, normals);
  EXPECT_EQ(normals, (std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}));
}

TEST(ClothMesh, StretchOfTheMostStretchedSpring) {
  const clothsim::Cloth cloth = make_cloth();
  clothsim::Points positions = cloth.rest_positions;
  // Along x by 5 %: the same in springs along x, less in diagonal ones, none along y.
  positions.col(0) *= 1.05;
  const clothsim::ClothTopology topology = make_topology(cloth);
  for (const float stretch : values_of(Quantity::stretch, make_state(positions), topology)) {
    EXPECT_NEAR(stretch, 0.05, 1e-5);
  }
  // A point on its own is not stretched.
  clothsim::ClothTopology loose = topology;
  loose.structural.clear();
  loose.shear.clear();
  loose.bending.clear();
  for (const float stretch : values_of(Quantity::stretch, make_state(positions), loose)) {
    EXPECT_EQ(stretch, 0);
  }
}

TEST(ClothMesh, SpeedAndHeight) {
  clothsim::ClothState state;
  state.positions = {1, 2, 3, 4, 5, -6};
  state.velocities = {1, 2, 2, 0, 0, 0};
  EXPECT_EQ(values_of(Quantity::speed, state, {}), (std::vector<float>{3, 0}));
  EXPECT_EQ(values_of(Quantity::height, state, {}), (std::vector<float>{3, -6}));
}

TEST(ClothMesh, RefusesTopologies) {
  const clothsim::ClothTopology good = make_topology(make_cloth());
  EXPECT_EQ(mistake([&] { check_topology(good); }), "");
  const auto refused = [&good](auto spoil) {
    clothsim::ClothTopology bad = good;
    spoil(bad);
    return mistake([&] { check_topology(bad); });
  };
  EXPECT_TRUE(says(mistake([] { check_topology({}); }), "columns: got no ... one"));
  EXPECT_TRUE(says(refused([](auto& t) { t.columns = t.rows = 1u << 31; }), "rest_positions"));
  EXPECT_TRUE(says(refused([](auto& t) { t.uv.pop_back(); }), "uv: got 39 ... 40"));
  EXPECT_TRUE(says(refused([](auto& t) { t.triangles.pop_back(); }), "triangles: got 71 ... 3"));
  EXPECT_TRUE(says(refused([](auto& t) { t.shear[1] = 20; }), "shear: got point 20 ... below 20"));
  EXPECT_TRUE(says(refused([](auto& t) { t.pinned = {4000000000u}; }),
                   "pinned: got point 4000000000 ... below 20"));
  EXPECT_TRUE(says(refused([](auto& t) {
                     t.first_points = {0, 20};
                   }),
                   "first_points: got point 20 ... below 20"));
  EXPECT_NE(refused([](auto& t) { t.uv[3] = std::nanf(""); }), "");
}

TEST(ClothMesh, RefusesStates) {
  const clothsim::Cloth cloth = make_cloth();
  const clothsim::ClothTopology topology = make_topology(cloth);
  const clothsim::ClothState good = make_state(cloth.rest_positions);
  EXPECT_EQ(mistake([&] { check_state(good, topology); }), "");
  const auto refused = [&](auto spoil) {
    clothsim::ClothState bad = good;
    spoil(bad);
    return mistake([&] { check_state(bad, topology); });
  };
  EXPECT_TRUE(says(refused([](auto& s) { s.topology_seq = 8; }), "topology_seq: got 8 ... 7"));
  EXPECT_TRUE(says(refused([](auto& s) { s.positions.clear(); }), "positions: got 0 ... 60"));
  EXPECT_TRUE(says(refused([](auto& s) { s.velocities.resize(61); }), "velocities: got 61 ... 60"));
  EXPECT_TRUE(says(refused([](auto& s) { s.held = {20}; }), "held: got point 20 ... below 20"));
  EXPECT_TRUE(says(refused([](auto& s) { s.positions[5] = std::nanf(""); }), "positions.5"));
  EXPECT_NE(refused([](auto& s) { s.positions[5] = std::numeric_limits<float>::infinity(); }), "");
  EXPECT_NE(refused([](auto& s) { s.velocities[0] = 2e6f; }), "");
}

TEST(ClothMesh, RayMeetsTheFirstOfTwoLayers) {
  // Two unit squares, at z = 0 and z = 1.
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                        0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
  const std::vector<std::uint32_t> triangles = {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6};
  const Vector3 down(0, 0, -2);
  const auto above = first_hit({0.8, 0.3, 3}, down, positions, triangles);
  ASSERT_TRUE(above);
  EXPECT_DOUBLE_EQ(above->distance, 1);
  EXPECT_LT((above->place - Vector3(0.8, 0.3, 1)).norm(), 1e-12);
  EXPECT_EQ(above->point, 5u);
  // From the other side, and from between.
  EXPECT_EQ(first_hit({0.1, 0.7, -1}, -down, positions, triangles)->point, 2u);
  EXPECT_EQ(first_hit({0.1, 0.7, 0.5}, down, positions, triangles)->point, 2u);
  // Beside, away from it, and along it.
  EXPECT_FALSE(first_hit({1.1, 0.5, 3}, down, positions, triangles));
  EXPECT_FALSE(first_hit({0.8, 0.3, 3}, -down, positions, triangles));
  EXPECT_FALSE(first_hit({-1, 0.5, 0.5}, {1, 0, 0}, positions, triangles));
}

TEST(ClothMesh, RayMeetsARopeNearIt) {
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  const auto hit = first_hit({1.004, 0.004, 1}, {0, 0, -1}, positions, {});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->point, 1u);
  EXPECT_FALSE(first_hit({1.02, 0, 1}, {0, 0, -1}, positions, {}));
  EXPECT_FALSE(first_hit({1, 0, 1}, {0, 0, 1}, positions, {}));
}

/// Table of colours in Moreland's paper.
TEST(ColorMap, IsThePapers) {
  using Color = std::array<std::uint8_t, 3>;
  EXPECT_EQ(color_at(0), (Color{59, 76, 192}));
  EXPECT_EQ(color_at(0.5), (Color{221, 221, 221}));
  EXPECT_EQ(color_at(1), (Color{180, 4, 38}));
  const ColorMap map = color_map();
  EXPECT_EQ((Color{map[0], map[1], map[2]}), color_at(0));
  EXPECT_EQ((Color{map[765], map[766], map[767]}), color_at(1));
}

}  // namespace
}  // namespace clothsim_rviz::cloth_mesh_test
