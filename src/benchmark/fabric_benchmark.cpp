// Forces of a fabric: on a grid, on the same grid as triangles, and on triangles that are curved at
// rest; without and with internal damping.

#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "clothsim/dynamics/forces.h"
#include "clothsim/model/join_cloths.h"
#include "clothsim/model/make_cloth.h"
#include "clothsim/model/state.h"

namespace clothsim {
namespace {

enum class FabricShape { grid, mesh, curved };

/// A square metre of cotton, 50 x 50 points.
ClothSpec fabric(FabricShape shape, bool damped) {
  ClothSpec grid;
  grid.material.fabric = Fabric{{1000, 700}, 40, {14e-6, 8.7e-6}, {}};
  if (damped) grid.material.fabric->internal_damping = {1e-5, 4e-3};
  grid.material.density = 0.16;
  grid.material.damping = 0;
  grid.material.strain_limit.reset();
  if (shape == FabricShape::grid) return grid;
  ClothSpec spec = join_cloths({{"cloth", grid}});
  if (shape == FabricShape::mesh) return spec;
  ClothMesh mesh = *spec.mesh;
  for (auto x : mesh.positions.rowwise()) {  // rolled to an arc of two radians
    const double turn = 2 * x[0];
    x[0] = std::sin(turn) / 2;
    x[2] += (1 - std::cos(turn)) / 2;
  }
  mesh.curved.assign(mesh.triangles.size(), 1);
  spec.mesh = std::make_shared<const ClothMesh>(std::move(mesh));
  return spec;
}

void forces_of_fabric(benchmark::State& run, FabricShape shape, bool damped) {
  const Cloth cloth = make_cloth(fabric(shape, damped));
  Points positions = cloth.rest_positions, velocities = cloth.rest_positions;
  for (int i = 0; i < cloth.num_points(); ++i) {  // waves, so that damping has something to do
    const double x = positions(i, 0), y = positions(i, 1);
    positions(i, 2) += 0.02 * std::sin(20 * x) * std::cos(15 * y);
    velocities.row(i) = Vector3(std::cos(9 * y), std::sin(7 * x), std::cos(11 * x)).transpose();
  }
  Points forces;
  for (auto _ : run) {
    compute_forces(cloth, Loads(), positions, forces, {}, damped ? &velocities : nullptr);
    benchmark::ClobberMemory();
  }
}

BENCHMARK_CAPTURE(forces_of_fabric, grid, FabricShape::grid, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(forces_of_fabric, grid_damped, FabricShape::grid, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(forces_of_fabric, mesh, FabricShape::mesh, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(forces_of_fabric, mesh_damped, FabricShape::mesh, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(forces_of_fabric, curved, FabricShape::curved, false)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(forces_of_fabric, curved_damped, FabricShape::curved, true)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace clothsim
