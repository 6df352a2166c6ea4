// Effects of a scene's parameters on the cloth, in numbers.

#include <cmath>
#include <map>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/run/report.h"
#include "verification/testing.h"

namespace clothsim::behaviour_test {
namespace {

using namespace test;

Scene with(const std::string& name, double ks, double density = 150) {
  Scene scene = shipped_scene(name);
  scene.cloth.material.ks = ks;
  scene.cloth.material.density = density;
  return scene;
}

/// Mean height of the points relative to the lowest pin, negative as they hang [m].
double mean_height(const State& state) { return state.positions.col(2).mean() - 1; }

/// Mean height after 5 s. By then the cloth must be at rest, except for a wrinkle of a soft cloth
/// that snaps now and then. It must keep its strain limit in every frame.
double height_at_rest(const Scene& scene) {
  Simulator simulator(scene);
  double worst = 0;
  double min_speed = 1;
  for (int frame = 0; frame < 5 * 90; ++frame) {
    worst = std::max(worst, simulator.step().worst_stretch);
    if (frame >= 4 * 90) min_speed = std::min(min_speed, rms_velocity(simulator.state()));
  }
  EXPECT_LT(worst, 0.1 + 0.0041);
  EXPECT_LT(min_speed, 0.005);
  return mean_height(simulator.state());
}

class Hanging : public ::testing::TestWithParam<const char*> {};

TEST_P(Hanging, SofterHangsLower) {
  // The strain limit bounds the sag: at ks 500 and below nearly every spring is at it.
  double last = -1;
  for (const double ks : {50.0, 500.0, 5000.0, 50000.0}) {
    const double height = height_at_rest(with(GetParam(), ks));
    RecordProperty("mean_height_ks_" + std::to_string(static_cast<int>(ks)),
                   std::to_string(height));
    EXPECT_GT(height, last + (ks > 500 ? 0.01 : 0)) << "ks " << ks;
    last = height;
  }
}

TEST_P(Hanging, HeavierHangsLower) {
  double last = 0;
  for (const double density : {10.0, 15.0, 150.0, 1500.0, 15000.0}) {
    const double height = height_at_rest(with(GetParam(), 5000, density));
    RecordProperty("mean_height_density_" + std::to_string(static_cast<int>(density)),
                   std::to_string(height));
    EXPECT_LT(height, last - (density <= 1500 ? 0.0005 : 0)) << "density " << density;
    last = height;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Hanging, ::testing::Values("pinned2", "pinned4"));

TEST_P(Hanging, SofterWrinklesMore) {
  // Along a free edge (of pinned4 between two corners, of pinned2 the hem): the excess of the
  // curve's length over its chord, by sag and wrinkles.
  const auto surplus = [](double ks) {
    const Scene scene = with(GetParam(), ks);
    Simulator simulator(scene);
    run(simulator, 3);
    const Points& x = simulator.state().positions;
    const int first = GetParam() == std::string("pinned2") ? 49 * 50 : 0;
    double length = 0;
    for (int i = first + 1; i < first + 50; ++i) length += (x.row(i) - x.row(i - 1)).norm();
    return length - (x.row(first + 49) - x.row(first)).norm();
  };
  const double soft = surplus(500);
  const double middle = surplus(5000);
  const double stiff = surplus(50000);
  RecordProperty("surplus_mm", std::to_string(soft * 1e3) + ", " + std::to_string(middle * 1e3) +
                                   ", " + std::to_string(stiff * 1e3));
  EXPECT_GT(soft, middle + 0.004);
  EXPECT_GT(middle, stiff + 1e-4);
  EXPECT_GT(stiff, 0);
}

/// Swing of a cloth that is released horizontally, pinned along y = 0.
struct Swing {
  double overshoot = 0;          // largest distance of its centre beyond the pins [m]
  double mechanical_energy = 0;  // at the end, above the start [J]
  double kinetic_late = 0;       // mean over the last second [J]
  Points rest;
};

Swing swing(double damping, double seconds, bool limited = true, int side = 50) {
  Scene scene = shipped_scene("pinned2");
  scene.cloth.columns = scene.cloth.rows = side;
  scene.cloth.pinned = {{0, 0, ""}, {side - 1, 0, ""}};
  scene.cloth.material.damping = damping;
  if (!limited) scene.cloth.material.strain_limit.reset();
  Simulator simulator(scene);
  const Cloth& cloth = simulator.cloth();
  const auto energy = [&] {
    const State& s = simulator.state();
    return kinetic_energy(cloth, s) + elastic_energy(cloth, s.positions) +
           gravitational_energy(cloth, scene.simulation.gravity, s.positions);
  };
  const double start = energy();
  Swing result;
  const int frames = static_cast<int>(std::lround(seconds * 90));
  for (int frame = 0; frame < frames; ++frame) {
    simulator.step();
    result.overshoot = std::max(result.overshoot, -simulator.state().positions.col(1).mean());
    if (frame >= frames - 90) result.kinetic_late += kinetic_energy(cloth, simulator.state()) / 90;
  }
  result.mechanical_energy = energy() - start;
  result.rest = simulator.state().positions;
  return result;
}

TEST(Damping, ZeroKeepsSwingingWithItsEnergy) {
  // Without the limit nothing takes energy: Verlet keeps it within (omega h)^2 / 8 of the energy
  // that swings, here (2 * 0.8)^2 / 8 = 0.32 at most. Most of it is kept far better.
  const Swing s = swing(0, 10, false, 20);
  const double swinging = 150 * 9.8 * 0.5;
  RecordProperty("energy_change_of_swing", std::to_string(s.mechanical_energy / swinging));
  EXPECT_LT(std::abs(s.mechanical_energy), 0.05 * swinging);
  EXPECT_GT(s.kinetic_late, 0.1 * swinging);
}

TEST(Damping, SmallSwingsLongLargeDoesNotOvershoot) {
  const Swing small = swing(0.5, 5);
  const Swing usual = swing(5.4, 5);
  const Swing large = swing(27, 12);
  RecordProperty("kinetic_late_small", std::to_string(small.kinetic_late));
  RecordProperty("kinetic_late_usual", std::to_string(usual.kinetic_late));
  EXPECT_GT(small.kinetic_late, 1) << "it still swings";
  EXPECT_LT(usual.kinetic_late, 1e-3);
  // With small drag it swings far past the plane of its rest, with large drag not at all.
  RecordProperty("overshoot_mm", std::to_string(small.overshoot * 1e3) + ", " +
                                     std::to_string(usual.overshoot * 1e3) + ", " +
                                     std::to_string(large.overshoot * 1e3));
  EXPECT_GT(small.overshoot, 0.2);
  EXPECT_GT(small.overshoot, usual.overshoot + 0.1);
  EXPECT_LT(large.overshoot, 1e-3);
}

TEST(Damping, RestShapeDoesNotDependOnIt) {
  // Each is as near to the converged shape as HangingScene requires.
  const Points light = swing(3, 12).rest;
  const Points usual = swing(5.4, 8).rest;
  const Points heavy = swing(27, 25).rest;
  RecordProperty("light_mm", std::to_string(1e3 * farthest(light, usual)));
  RecordProperty("heavy_mm", std::to_string(1e3 * farthest(heavy, usual)));
  EXPECT_LT(farthest(light, usual), 5e-4);
  EXPECT_LT(farthest(heavy, usual), 5e-4);
}

TEST(Sphere, SofterDrapesLowerAndCloser) {
  // Closer: the mean gap to the ball of the points around it, below its middle.
  double last_height = -2;
  double last_reach = 0;
  for (const double ks : {500.0, 5000.0, 50000.0}) {
    Simulator simulator(with("sphere", ks));
    double deepest = 0;
    for (int frame = 0; frame < 4 * 90; ++frame) {
      simulator.step();
      if (frame % 9 == 0) deepest = std::max(deepest, deepest_penetration(simulator));
    }
    EXPECT_LE(deepest, 0) << "ks " << ks;
    const Points& x = simulator.state().positions;
    const double height = mean_height(simulator.state());
    // Mean distance of the cloth from the ball's axis.
    const double reach =
        (x.leftCols(2).rowwise() - Eigen::RowVector2d(0.5, 0.5)).rowwise().norm().mean();
    RecordProperty("mean_height_ks_" + std::to_string(static_cast<int>(ks)),
                   std::to_string(height));
    RecordProperty("reach_ks_" + std::to_string(static_cast<int>(ks)), std::to_string(reach));
    EXPECT_GT(height, last_height + 0.001) << "ks " << ks;
    EXPECT_GT(reach, last_reach) << "ks " << ks;
    last_height = height;
    last_reach = reach;
  }
}

TEST(Wireframe, FamiliesAreWhatIsSwitchedOn) {
  // Without shear springs, with shear springs only, with all: the cloth falls and hangs in each
  // case.
  const std::map<std::string, std::pair<std::array<bool, 3>, int>> cases = {
      {"without shear", {{true, false, true}, 4900 + 4800}},
      {"shear only", {{false, true, false}, 4802}},
      {"all", {{true, true, true}, 14502}},
  };
  for (const auto& [name, expected] : cases) {
    Scene scene = shipped_scene("pinned4");
    scene.cloth.material.springs = expected.first;
    Simulator simulator(scene);
    EXPECT_EQ(simulator.cloth().num_springs(), expected.second) << name;
    for_each_spring(simulator.cloth(), [&](const SpringRun& run, int, int) {
      ASSERT_TRUE(expected.first[static_cast<std::size_t>(run.family)]) << name;
    });
    run(simulator, 0.5);
    EXPECT_TRUE(simulator.state().positions.allFinite()) << name;
    EXPECT_LT(mean_height(simulator.state()), -0.01) << name;
  }
}

TEST(Wireframe, ShearSpringsKeepTheCornersSquare) {
  // Without them a cell shears freely: the middle column and row of pinned2 lean apart.
  const auto worst_shear = [](bool shear) {
    Scene scene = shipped_scene("pinned2");
    scene.cloth.material.springs[static_cast<std::size_t>(SpringFamily::shear)] = shear;
    Simulator simulator(scene);
    run(simulator, 3);
    const Points& x = simulator.state().positions;
    double sum = 0;
    for (int row = 0; row < 49; ++row) {
      for (int column = 0; column < 49; ++column) {
        const Vector3 u =
            point(simulator.cloth(), x, column + 1, row) - point(simulator.cloth(), x, column, row);
        const Vector3 v =
            point(simulator.cloth(), x, column, row + 1) - point(simulator.cloth(), x, column, row);
        sum += std::abs(u.normalized().dot(v.normalized()));
      }
    }
    return sum / (49 * 49);
  };
  const double with_shear = worst_shear(true);
  const double without = worst_shear(false);
  RecordProperty("with", std::to_string(with_shear));
  RecordProperty("without", std::to_string(without));
  EXPECT_GT(without, 2 * with_shear);
}

}  // namespace
}  // namespace clothsim::behaviour_test
