// Open surfaces as colliders with a thickness: cloth rests on both of their sides.

#include <gtest/gtest.h>

#include <random>

#include "clothsim/geometry/closest_points.h"
#include "clothsim/model/errors.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/shapes/face_distance.h"
#include "clothsim/simulation/simulator.h"
#include "meshes.h"
#include "temporary_folder.h"

namespace clothsim::sheet_test {
namespace {

using namespace test;

constexpr double thickness = 0.01;

Triangle triangle_of(const TriangleSoup& soup, std::size_t t) {
  const auto at = [&](int i) { return soup.vertices[static_cast<std::size_t>(i)]; };
  return {at(soup.triangles[t][0]), at(soup.triangles[t][1]), at(soup.triangles[t][2])};
}

/// Three squares that meet at an edge, one of them turned round; a cap; a bowl of two.
const TriangleSoup soups[] = {
    square_soup(0.2),
    together({above_z(globe_soup(0.1, 4), 0.02),
              moved(above_z(globe_soup(0.1, 4), 0.02), {0, 0, 0.05})}),
    {{{0, -0.1, 0}, {0, 0.1, 0}, {0.1, 0, 0}, {-0.1, 0, 0.02}, {0, 0, 0.1}},
     {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}},
};

TEST(Sheet, DistanceIsThatOfTheNearestTriangleOnEitherSideLessHalfTheThickness) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> draw(-0.15, 0.15);
  for (const TriangleSoup& soup : soups) {
    const Shape sheet = sheet_shape(soup, thickness);
    for (int n = 0; n < 1000; ++n) {
      const Vector3 p(draw(engine), draw(engine), draw(engine));
      double least = 1;
      Vector3 away;
      for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const Triangle t = triangle_of(soup, i);
        const auto w = closest_on_triangle(p, t[0], t[1], t[2]);
        const Vector3 gap = p - (w[0] * t[0] + w[1] * t[1] + w[2] * t[2]);
        if (gap.norm() >= least) continue;
        least = gap.norm();
        away = gap;
      }
      const Distance found = signed_distance(sheet, p, p);
      ASSERT_NEAR(found.value, least - thickness / 2, 1e-12) << n;
      if (least > 1e-6) {
        EXPECT_LT((found.normal - away / least).norm(), 1e-6) << n;
      }
    }
  }
}

TEST(Sheet, FaceDistanceIsThatOfTheTrianglesPoints) {
  std::mt19937_64 engine(2);
  std::uniform_real_distribution<double> draw(-0.12, 0.12), size(-0.03, 0.03);
  for (const TriangleSoup& soup : soups) {
    const Shape sheet = sheet_shape(soup, thickness);
    int apart = 0, through = 0;
    for (int n = 0; n < 1000; ++n) {
      const Vector3 middle(draw(engine), draw(engine), draw(engine));
      Triangle t;
      for (Vector3& p : t) p = middle + Vector3(size(engine), size(engine), size(engine));
      bool crosses = false;
      for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        crosses = crosses || triangles_cross(triangle_of(soup, i), t);
      }
      const auto found = face_distance(sheet, t, 1);
      ASSERT_TRUE(found);
      EXPECT_NEAR(found->normal.norm(), 1, 1e-9);
      if (crosses) {
        EXPECT_LT(found->value, -thickness / 2) << n;
        ++through;
        continue;
      }
      ++apart;
      double least = 1;  // over points of the triangle on a lattice
      constexpr int along = 30;
      for (int i = 0; i <= along; ++i) {
        for (int k = 0; i + k <= along; ++k) {
          const Vector3 p = t[0] + (i * (t[1] - t[0]) + k * (t[2] - t[0])) / along;
          least = std::min(least, signed_distance(sheet, p, p).value);
        }
      }
      EXPECT_LE(found->value, least + 1e-12) << n;
      EXPECT_GT(found->value, least - 0.003) << n;  // of the lattice
    }
    EXPECT_GT(apart, 500);
    EXPECT_GT(through, 10);
  }
}

TEST(Sheet, ATriangleThatPassesThroughLeavesTheShorterWay) {
  const Shape sheet = sheet_shape(square_soup(0.2), thickness);
  for (const double side : {1.0, -1.0}) {
    const Triangle t{Vector3(0, 0, -0.01 * side), Vector3(0.02, 0, 0.03 * side),
                     Vector3(0, 0.02, 0.03 * side)};
    const auto found = face_distance(sheet, t, 0);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, -0.01 - thickness / 2, 1e-12);
    EXPECT_LT((found->normal - Vector3(0, 0, side)).norm(), 1e-12);
    EXPECT_NEAR(found->weights[0], 1, 1e-12);
  }
}

std::string scene_text(const std::string& keys) {
  return "{cloth: {columns: 10, rows: 10}, colliders: [{shape: mesh, file: a.obj, " + keys + "}]}";
}

std::string refusal(const std::string& keys, const std::filesystem::path& folder) {
  try {
    read_scene(YAML::Load(scene_text(keys)), {folder});
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Sheet, IsAMeshOfASceneWithAThickness) {
  const TemporaryFolder folder("sheet");
  write_obj((folder.path() / "a.obj").string(), square_soup(0.5));
  EXPECT_NE(refusal("friction: 0.3", folder.path()).find("a thickness"), std::string::npos);
  EXPECT_NE(refusal("thickness: 0", folder.path()).find("thickness"), std::string::npos);
  EXPECT_NE(refusal("thickness: thin", folder.path()).find("thickness"), std::string::npos);

  const Scene scene =
      read_scene(YAML::Load(scene_text("thickness: 0.01, padding: 0.002")), {folder.path()});
  const Shape& shape = scene.colliders[0].shape;
  for (const double side : {1.0, -1.0}) {
    const Vector3 p(0.1, 0, 0.1 * side);
    EXPECT_NEAR(signed_distance(shape, p, p).value, 0.1 - 0.005 - 0.002, 1e-7);
  }
}

/// Rest height of a cloth that falls on a square from one of its sides [m].
double rest_on(double side) {
  Scene scene;
  scene.cloth.columns = scene.cloth.rows = 12;
  scene.cloth.width = scene.cloth.height = 0.3;
  scene.cloth.origin = {-0.15, -0.15, 0.1 * side};
  scene.simulation.gravity = {0, 0, -9.8 * side};
  ColliderSpec sheet;
  sheet.shape = sheet_shape(square_soup(0.6), thickness);
  sheet.name = "sheet";
  sheet.friction = 0.4;
  scene.colliders = {sheet};
  Simulator simulator(scene);
  for (int frame = 0; frame < 180; ++frame) simulator.step();
  EXPECT_LT(longest_row(simulator.state().velocities), 1e-3);
  EXPECT_NEAR(simulator.state().positions.col(2).maxCoeff(),
              simulator.state().positions.col(2).minCoeff(), 1e-6);
  return simulator.state().positions.col(2).mean();
}

TEST(Sheet, HoldsClothOnEitherSide) {
  EXPECT_NEAR(rest_on(1), thickness / 2 + surface_offset, 1e-5);
  EXPECT_NEAR(rest_on(-1), -thickness / 2 - surface_offset, 1e-5);
}

}  // namespace
}  // namespace clothsim::sheet_test
