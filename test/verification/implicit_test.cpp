// Methods of implicit Euler's family on cloths: energy, and one solution for all its solvers.

#include "verification/testing.h"

namespace clothsim::implicit_test {
namespace {

using namespace test;

/// A cloth hung by two corners with some speed at its start.
struct Hung {
  explicit Hung(int side, double ks) {
    ClothSpec spec = square_spec(side, ks);
    spec.pinned = {{0, 0, ""}, {side - 1, 0, ""}};
    cloth = make_grid(spec);
    state.positions = shaken(cloth, 0.01, 1);
    state.velocities = random_points(cloth.num_points(), 0.5, 2);
    for (const int pin : cloth.pinned) {
      state.positions.row(pin) = cloth.rest_positions.row(pin);
      state.velocities.row(pin).setZero();
    }
  }
  Cloth cloth;
  State state;
};

TEST(ImplicitEulerEnergy, NeverRises) {
  // From x' minimising |x' - x - h v|^2 / 2 h^2 + E, for energies E that are convex between the
  // steps; checked from steps short against the fastest swing to 50 times longer, without drag.
  const Loads loads;
  for (const double ks : {50.0, 5000.0, 5e6}) {
    for (const double h : {1e-3, 1e-2, 5e-2}) {
      Hung hung(8, ks);
      ImplicitEuler method;
      double energy = total_energy(hung.cloth, loads, hung.state);
      const double scale = hung.cloth.mass.sum() * 9.8;
      for (int n = 0; n < 100; ++n) {
        method.step(hung.cloth, loads, h, hung.state);
        const double now = total_energy(hung.cloth, loads, hung.state);
        ASSERT_LT(now, energy + 1e-9 * scale) << "ks " << ks << ", h " << h << ", step " << n;
        energy = now;
      }
    }
  }
}

/// Positions after `steps` steps of 5 ms; h omega_max is near 2.
template <typename Method>
Points after(Method method, int steps) {
  Hung hung(8, 20000);
  run(method, hung.cloth, Loads(), 5e-3, steps, hung.state);
  return hung.state.positions;
}

TEST(ImplicitEuler, IsWhatXpbdConvergesToAsIterationsGrow) {
  const int steps = 20;
  const Points exact = after(converged<ImplicitEuler>(), steps);
  double last = std::numeric_limits<double>::infinity();
  for (const int iterations : {1, 4, 16, 64}) {
    Xpbd::Parameters parameters;
    parameters.iterations = iterations;
    const double error = farthest(after(Xpbd(parameters), steps), exact);
    RecordProperty("error_" + std::to_string(iterations), std::to_string(error));
    EXPECT_LT(error, 0.5 * last) << iterations;
    last = error;
  }
  EXPECT_LT(farthest(after(converged<Xpbd>(), steps), exact), 1e-9);
}

}  // namespace
}  // namespace clothsim::implicit_test
