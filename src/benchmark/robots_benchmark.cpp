// Cost of robots: shapes out of the cloth's reach, fine meshes under it, and loading them.

#include <benchmark/benchmark.h>

#include <cmath>

#include "clothsim/shapes/mesh_file.h"
#include "cpu_time.h"
#include "settled.h"

namespace clothsim {
namespace {

/// A ball of 4 rings (rings - 1) triangles.
TriangleSoup ball(int rings, double radius) {
  TriangleSoup soup;
  const int around = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    const double polar = M_PI * ring / rings;
    const double wide = ring == 0 || ring == rings ? 0 : radius * std::sin(polar);
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * M_PI * i / around;
      soup.vertices.emplace_back(wide * std::cos(angle), wide * std::sin(angle),
                                 radius * std::cos(polar));
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < around; ++i) {
      const int a = ring * around + i, b = ring * around + (i + 1) % around;
      if (ring > 0) soup.triangles.push_back({a, a + around, b});
      if (ring + 1 < rings) soup.triangles.push_back({b, a + around, b + around});
    }
  }
  return soup;
}

Shape ball_mesh(int rings, double radius) {
  return MeshShape{std::make_shared<const MeshFile>(MeshFile{Solid(ball(rings, radius)), "", {}}),
                   0};
}

/// CPU time of `seconds` of one scene over that of another, a tenth of a second of each in turn.
double ratio(const Scene& scene, const Scene& other, double seconds) {
  Simulator first(scene), second(other);
  const int frames = static_cast<int>(0.1 / first.frame_duration());
  double spent = 0, other_spent = 0;
  for (int turn = 0; turn < static_cast<int>(10 * seconds); ++turn) {
    const double start = cpu_seconds();
    for (int frame = 0; frame < frames; ++frame) first.step();
    const double middle = cpu_seconds();
    for (int frame = 0; frame < frames; ++frame) second.step();
    spent += middle - start;
    other_spent += cpu_seconds() - middle;
  }
  return spent / other_spent;
}

/// pinned2 with run.range(0) shapes 2 m beside it, over pinned2.
void out_of_reach(benchmark::State& run) {
  const Scene alone = load("pinned2");
  Scene scene = alone;
  const Shape shapes[] = {Sphere{0.1}, Cuboid{{0.1, 0.2, 0.3}}, Cylinder{0.3, 0.05},
                          Capsule{0.3, 0.05}, ball_mesh(16, 0.1)};
  for (int i = 0; i < run.range(0); ++i) {
    ColliderSpec collider;
    collider.name = std::to_string(i);
    collider.shape = shapes[static_cast<std::size_t>(i) % std::size(shapes)];
    collider.pose.position = {3 + 0.3 * (i % 6), 0.3 * (i / 6) - 1, 0.5};
    scene.colliders.push_back(collider);
  }
  for (auto _ : run) run.counters["of pinned2"] = ratio(scene, alone, 10);
}

/// A cloth on a ball of triangles, over the same on a sphere.
void on_a_mesh(benchmark::State& run) {
  const Scene sphere = load("sphere");
  Scene scene = sphere;
  scene.colliders[0].shape =
      ball_mesh(static_cast<int>(run.range(0)), std::get<Sphere>(sphere.colliders[0].shape).radius);
  for (auto _ : run) run.counters["of a sphere"] = ratio(scene, sphere, 5);
}

/// A fabric that falls on a ball of triangles with bumps, over the same on a smooth one.
void on_bumps(benchmark::State& run) {
  constexpr const char* fabric = R"(
cloth: {width: 1.6, height: 0.8, columns: 65, rows: 33, density: 0.3, stretch_stiffness: 1000, shear_stiffness: 50,
        bending_stiffness: 2.0e-5, internal_damping: [2.0e-5, 5.0e-3], thickness: 0.004, origin: [-0.8, -0.4, 0.65]}
colliders:
  - {name: ball, shape: sphere, radius: 0.25, center: [0, 0, 0.3], friction: 0.4}
  - {name: floor, shape: plane, friction: 0.5}
)";
  const int rings = 18;
  const double radius = 0.25, height = static_cast<double>(run.range(0)) / 100;
  TriangleSoup soup = ball(rings, radius);
  for (Vector3& p : soup.vertices) {
    p *= 1 + height * std::sin(5 * p.x() / radius) * std::cos(4 * p.y() / radius);
  }
  Scene smooth = read_scene(YAML::Load(fabric)), bumpy = smooth;
  smooth.colliders[0].shape = ball_mesh(rings, radius);
  bumpy.colliders[0].shape =
      MeshShape{std::make_shared<const MeshFile>(MeshFile{Solid(soup), "", {}}), 0};
  for (auto _ : run) run.counters["of a smooth one"] = ratio(bumpy, smooth, 3);
}

/// Building a solid from its triangles.
void make_solid(benchmark::State& run) {
  const TriangleSoup soup = ball(static_cast<int>(run.range(0)), 0.1);
  run.counters["triangles"] = static_cast<double>(soup.triangles.size());
  for (auto _ : run) benchmark::DoNotOptimize(Solid(soup));
}

BENCHMARK(out_of_reach)->Arg(1)->Arg(60)->Iterations(1);
BENCHMARK(on_a_mesh)->Arg(22)->Arg(158)->Iterations(1);
BENCHMARK(on_bumps)->Arg(1)->Arg(3)->Arg(6)->Iterations(1);
BENCHMARK(make_solid)->Arg(22)->Arg(158)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace clothsim
