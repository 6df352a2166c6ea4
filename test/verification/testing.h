#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <variant>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/integrator.h"
#include "clothsim/model/grid.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/simulation/simulator.h"

namespace clothsim::test {

/// The closed list of methods as the types of a typed test.
template <typename Variant>
struct TypesOf;
template <typename... Methods>
struct TypesOf<std::variant<Methods...>> {
  using List = ::testing::Types<Methods...>;
};
using EachMethod = TypesOf<Integrator>::List;

/// A method that iterates to rounding, or at least 100 times, so that only its scheme is left.
template <typename Method>
Method converged() {
  struct Tighten {
    void operator()(const std::string& key, double& value, const Range&) const {
      if (key == "tolerance") value = 1e-13;
    }
    void operator()(const std::string& key, int& value, const Range&) const {
      if (key == "iterations") value = std::is_same_v<Method, Xpbd> ? 100 : 1000;
      if (key == "max_iterations") value = 1000;
    }
    void operator()(const std::string&, VelocityVerlet::Parameters::Precision&,
                    const Range&) const {}
  };
  typename Method::Parameters parameters;
  Method::Parameters::each(parameters, Tighten());
  return Method(parameters);
}

/// Kinetic, elastic and gravitational [J].
inline double total_energy(const Cloth& cloth, const Loads& loads, const State& state) {
  return kinetic_energy(cloth, state) + elastic_energy(cloth, state.positions) +
         gravitational_energy(cloth, loads.gravity, state.positions);
}

/// A default scene of config/scenes.
inline Scene shipped_scene(const std::string& name) {
  return read_scene(load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/" + name + ".yaml"));
}

/// `points` masses of 1 kg in a row along +y (or +z) with springs of length `spacing` [m] between
/// neighbours, no other springs, no drag and no strain limit.
inline ClothSpec chain_spec(int points, double spacing, double ks,
                            Orientation orientation = Orientation::horizontal) {
  ClothSpec spec;
  spec.columns = 1;
  spec.rows = points;
  spec.width = 1;
  spec.height = spacing * (points - 1);
  spec.orientation = orientation;
  spec.origin = Vector3::Zero();
  spec.material.ks = ks;
  spec.material.density = points / spec.height;
  spec.material.damping = 0;
  spec.material.strain_limit.reset();
  spec.material.springs = {true, false, false};
  return spec;
}

/// A square cloth of 1 m with all springs, no drag and no strain limit.
inline ClothSpec square_spec(int side, double ks = 5000) {
  ClothSpec spec;
  spec.columns = spec.rows = side;
  spec.material.ks = ks;
  spec.material.damping = 0;
  spec.material.strain_limit.reset();
  return spec;
}

/// Runs a simulator for `seconds`; returns the report of the last frame.
inline StepReport run(Simulator& simulator, double seconds) {
  StepReport report;
  const int frames = static_cast<int>(seconds / simulator.frame_duration() + 0.5);
  for (int frame = 0; frame < frames; ++frame) report = simulator.step();
  return report;
}

/// Runs a method for `steps` steps of h [s].
template <typename Method>
void run(Method& method, const Cloth& cloth, const Loads& loads, double h, int steps,
         State& state) {
  for (int i = 0; i < steps; ++i) method.step(cloth, loads, h, state);
}

/// N x 3 numbers, uniform in (-size, size).
inline Points random_points(int count, double size, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> draw(-size, size);
  Points points(count, 3);
  for (int i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) points(i, axis) = draw(engine);
  }
  return points;
}

/// The cloth at rest, each point moved by up to `size` [m] in every direction.
inline Points shaken(const Cloth& cloth, double size, std::uint64_t seed) {
  return cloth.rest_positions + random_points(cloth.num_points(), size, seed);
}

/// Point (column, row) of a cloth, as a column vector.
inline Vector3 point(const Cloth& cloth, const Points& positions, int column, int row) {
  return positions.row(row * cloth.columns + column).transpose();
}

/// Largest distance between points of the same index [m].
inline double farthest(const Points& a, const Points& b) {
  return (a - b).rowwise().norm().maxCoeff();
}

inline double max_speed(const State& state) { return state.velocities.rowwise().norm().maxCoeff(); }

/// [kg m/s]
inline Vector3 momentum(const Cloth& cloth, const State& state) {
  return state.velocities.transpose() * cloth.mass;
}

/// About the origin [kg m^2/s].
inline Vector3 angular_momentum(const Cloth& cloth, const State& state) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < cloth.num_points(); ++i) {
    const Vector3 x = state.positions.row(i).transpose();
    const Vector3 v = state.velocities.row(i).transpose();
    sum += cloth.mass[i] * x.cross(v);
  }
  return sum;
}

}  // namespace clothsim::test
