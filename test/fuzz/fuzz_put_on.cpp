// Random colliders that are turned on in random cloths: most leave in one piece, slowly. Rates, as
// a few have no gentle way out: see docs/limits.md.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "clothsim/run/report.h"
#include "fuzz/draw.h"
#include "fuzz/fuzz.h"
#include "verification/testing.h"

namespace clothsim {

const int test::usual_count = 10;

namespace {

using namespace test;

constexpr double before = 0.5, after = 1.3;  // [s]

/// Gentle and wild speeds of the fastest point, beyond that before [m/s].
constexpr double gentle = 4, wild = 30;

Shape shape(Draw& draw) {
  switch (draw.whole(0, 3)) {
    case 0:
      return Sphere{draw.even(0.03, 0.2)};
    case 1:
      return Cuboid{draw.in_box(Vector3::Constant(0.02), Vector3::Constant(0.3))};
    case 2:
      return Cylinder{draw.even(0.05, 0.4), draw.even(0.02, 0.15)};
    default:
      return Capsule{draw.even(0.05, 0.4), draw.even(0.02, 0.1)};
  }
}

/// A cloth that hangs by two or four corners, or lies on a floor, with a collider that is off.
Scene scene(Draw& draw) {
  Scene scene;
  const int n = draw.whole(12, 44);
  scene.cloth.columns = scene.cloth.rows = n;
  scene.cloth.self_collision = SelfCollision::surface;
  scene.cloth.material.ks = draw.decades(1000, 50000);
  scene.cloth.material.density = draw.decades(0.2, draw.happens(0.3) ? 100 : 1);
  const int held = draw.whole(0, 2);
  const double height = held == 0 ? 0 : 0.5;
  scene.cloth.origin = {0, 0, height + 0.01};
  if (held == 0) scene.colliders.push_back({"floor", Plane{}, {}, 0.5, ""});
  if (held > 0) scene.cloth.pinned = {{0, 0, ""}, {n - 1, 0, ""}};
  if (held > 1)
    scene.cloth.pinned.insert(scene.cloth.pinned.end(), {{0, n - 1, ""}, {n - 1, n - 1, ""}});
  const Vector3 place = draw.in_box({0.2, 0.2, height - 0.05}, {0.8, 0.8, height + 0.1});
  ColliderSpec put{"put", shape(draw), {place, draw.orientation()}, 0.3, ""};
  put.enabled = false;
  scene.colliders.push_back(put);
  return scene;
}

TEST(FuzzPutOn, MostClothLeavesInOnePiece) {
  int count = 0, inside = 0, gently = 0, wildly = 0, never = 0;
  for_each_seed([&](std::uint64_t seed) {
    Draw draw(seed);
    Simulator simulator(scene(draw));
    run(simulator, before);
    const double start = longest_row(simulator.state().velocities);
    simulator.enable_collider(static_cast<int>(simulator.scene().colliders.size()) - 1, true);
    double fastest = 0;
    std::optional<double> out_at;
    bool was_inside = false;
    for (double t = 0; t < after; t += simulator.frame_duration()) {
      simulator.step();
      ASSERT_TRUE(simulator.state().positions.allFinite());
      fastest = std::max(fastest, longest_row(simulator.state().velocities) - start);
      if (deepest_penetration(simulator) > 0) {
        was_inside = true;
        out_at.reset();
      } else if (!out_at) {
        out_at = t;
      }
    }
    ++count;
    inside += was_inside;
    gently += was_inside && fastest < gentle && out_at;
    wildly += fastest > wild;
    never += !out_at;
    std::cout << "fastest " << fastest << " m/s, " << (was_inside ? "inside, " : "")
              << (out_at ? "out after " + std::to_string(*out_at) + " s" : "never out");
  });
  std::cout << "of " << inside << " inside " << gently << " left at less than " << gentle
            << " m/s, " << never << " never; " << wildly << " of " << count << " faster than "
            << wild << " m/s" << std::endl;
  EXPECT_GE(gently, inside / 2);
  EXPECT_LE(never, 1 + count / 50);
  EXPECT_LE(wildly, 1 + count / 100);
}

}  // namespace
}  // namespace clothsim
