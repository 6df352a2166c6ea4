// Folds of a cloth that stands on its lower edge, and the effect of its material on them.

#include <cmath>
#include <map>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/run/report.h"
#include "five_layers.h"
#include "verification/testing.h"

namespace clothsim::folds_test {
namespace {

using namespace test;

Scene pile_of(double ks, double density) {
  Scene scene = shipped_scene("self_collision");
  scene.cloth.material.ks = ks;
  scene.cloth.material.density = density;
  return scene;
}

/// Measure of folding: turns of the columns [rad], summed over the inner points of each column
/// and averaged over the columns. Zero for a flat cloth, pi for one full fold.
double folding(const Cloth& cloth, const Points& x) {
  double sum = 0;
  for (int column = 0; column < cloth.columns; ++column) {
    for (int row = 1; row + 1 < cloth.rows; ++row) {
      const Vector3 a = point(cloth, x, column, row) - point(cloth, x, column, row - 1);
      const Vector3 b = point(cloth, x, column, row + 1) - point(cloth, x, column, row);
      sum += std::atan2(a.cross(b).norm(), a.dot(b));
    }
  }
  return sum / cloth.columns;
}

/// Checks a pile after 5 s, or up to 3 s later if it stood for a while before it toppled: at rest,
/// in layers, finite. Returns its folding.
double check_pile(const Scene& scene) {
  constexpr double rest = 0.01;  // [m/s] rms
  Simulator simulator(scene);
  run(simulator, 5);
  const State& state = simulator.state();
  for (int more = 0; more < 6 && rms_velocity(state) > rest; ++more) run(simulator, 0.5);
  EXPECT_TRUE(state.positions.allFinite());
  EXPECT_LT(rms_velocity(state), rest);
  EXPECT_EQ(deepest_penetration(simulator), 0);
  EXPECT_LT(worst_stretch(simulator.cloth(), state.positions), 0.105);
  const Points& flat = simulator.cloth().rest_positions;
  const double contact = 2 * scene.cloth.thickness;
  // Surfaces let neighbours come as near as a quarter of their distance at rest, less an edge.
  const bool surface = simulator.cloth().self_collision == SelfCollision::surface;
  const double edge = (flat.row(scene.cloth.columns + 1) - flat.row(0)).norm();
  double closest = 1;  // share of the allowed distance
  for (int a = 0; a < flat.rows(); ++a) {
    for (int b = a + 1; b < flat.rows(); ++b) {
      const double d2 = (state.positions.row(a) - state.positions.row(b)).squaredNorm();
      const double apart = (flat.row(a) - flat.row(b)).norm();
      if (apart < 2 * contact) continue;
      const double nearest = surface ? std::min(contact, (apart - edge) / 4) : contact;
      closest = std::min(closest, std::sqrt(d2) / nearest);
    }
  }
  EXPECT_GT(closest, 0.9);
  if (surface) {
    EXPECT_EQ(count_intersections(simulator.cloth(), state.positions), 0);
  }
  return folding(simulator.cloth(), state.positions);
}

TEST(SelfCollision, FallsTouchesAndFoldsInThatOrder) {
  // It stands on its lower edge and buckles: taller than 0.9 m without contact between its layers,
  // then the first contact, then a pile.
  Simulator simulator(shipped_scene("self_collision"));
  const auto top = [&] { return simulator.state().positions.col(2).maxCoeff(); };
  const int on_the_plane = 50;
  int frame = 0;
  while (simulator.step().contacts <= on_the_plane) ASSERT_LT(++frame, 180) << "no layers touch";
  RecordProperty("first_contact_frame", frame);
  EXPECT_GT(frame, 5);
  EXPECT_GT(top(), 0.5) << "it folds before it falls";
  EXPECT_GT(run(simulator, 4).contacts, 500);
  EXPECT_LT(top(), 0.25);
}

/// Folds run across the cloth, so a quarter of its width shows the same, in a fifth of the time.
Scene narrow_pile(double ks, double density = 150) {
  Scene scene = pile_of(ks, density);
  const double cell = scene.cloth.width / (scene.cloth.columns - 1);
  scene.cloth.columns = 13;
  scene.cloth.width = 12 * cell;
  return scene;
}

TEST(SelfCollision, StifferFoldsLess) {
  std::map<int, double> folds;
  for (const int ks : {50, 1000, 5000, 7500, 25000, 30000, 50000, 100000}) {
    SCOPED_TRACE("ks " + std::to_string(ks));
    folds[ks] = check_pile(narrow_pile(ks));
    RecordProperty("folding_ks_" + std::to_string(ks), std::to_string(folds[ks]));
  }
  EXPECT_GT(folds[50], 1.3 * folds[5000]);
  EXPECT_GT(folds[5000], 1.3 * folds[100000]);
  EXPECT_GT(folds[100000], M_PI) << "it does not fold at all";
}

TEST(SelfCollision, HeavierFoldsMore) {
  std::map<int, double> folds;
  for (const int density : {10, 30, 150, 500, 750, 1000, 10000}) {
    SCOPED_TRACE("density " + std::to_string(density));
    folds[density] = check_pile(narrow_pile(5000, density));
    RecordProperty("folding_density_" + std::to_string(density), std::to_string(folds[density]));
  }
  EXPECT_GT(folds[1000], 1.3 * folds[10]);
  EXPECT_GT(folds[10000], folds[1000]);
}

TEST(SelfCollision, LayersLieTwiceTheThicknessApart) {
  // So soft and heavy that the folds are low and all layers touch.
  Scene scene = strip_for_layers();
  scene.cloth.material.ks = 500;
  scene.cloth.material.density = 3000;
  Simulator simulator(scene);
  simulator.set_state(five_layers(simulator));
  run(simulator, 4);
  EXPECT_LT(rms_velocity(simulator.state()), 1e-4);
  const std::vector<double> distances = distances_of_layers(simulator);
  const double apart = 2 * scene.cloth.thickness;
  EXPECT_GT(distances.front(), 0.998 * apart);
  EXPECT_NEAR(distances[distances.size() / 2], apart, 1e-3 * apart) << "the median";
}

}  // namespace
}  // namespace clothsim::folds_test
