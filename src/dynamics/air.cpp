#include "clothsim/dynamics/air.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "clothsim/model/point_run.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Waves of gusts along each axis have frequencies between these [Hz]. The ratio of one to the next
/// is the golden ratio, so that the common period is far longer than the run of a scene.
constexpr double min_frequency = 0.1;
constexpr double max_frequency = 3;
const double golden_ratio = (1 + std::sqrt(5.0)) / 2;

/// Added to squared areas [m^4] and speeds [m^2/s^2] before divisions and roots.
constexpr double tiny = std::numeric_limits<double>::min();

/// Forces on each corner of the triangles (i, i + b, i + c), i in [0, count): see AirForces.
CLOTHSIM_TARGET_CLONES
void add_forces(PointRun p, PointRun v, int b, int c, int count, double across, double along,
                double wind_x, double wind_y, double wind_z, double* __restrict fx,
                double* __restrict fy, double* __restrict fz) {
  const double third = 1.0 / 3;
  for (int i = 0; i < count; ++i) {
    const double ax = p.x[i + b] - p.x[i], ay = p.y[i + b] - p.y[i], az = p.z[i + b] - p.z[i];
    const double bx = p.x[i + c] - p.x[i], by = p.y[i + c] - p.y[i], bz = p.z[i + c] - p.z[i];
    const double nx = (ay * bz - az * by) / 2;
    const double ny = (az * bx - ax * bz) / 2;
    const double nz = (ax * by - ay * bx) / 2;
    const double area2 = nx * nx + ny * ny + nz * nz + tiny;
    const double area = std::sqrt(area2);
    const double wx = wind_x - third * (v.x[i] + v.x[i + b] + v.x[i + c]);
    const double wy = wind_y - third * (v.y[i] + v.y[i + b] + v.y[i + c]);
    const double wz = wind_z - third * (v.z[i] + v.z[i + b] + v.z[i + c]);
    const double through = (wx * nx + wy * ny + wz * nz) / area2;  // w_n = through N
    const double tx = wx - through * nx, ty = wy - through * ny, tz = wz - through * nz;
    const double slip = std::sqrt(tx * tx + ty * ty + tz * tz + tiny);
    const double normal = across * area2 * std::abs(through) * through;
    const double tangential = along * area * slip;
    fx[i] = normal * nx + tangential * tx;
    fy[i] = normal * ny + tangential * ty;
    fz[i] = normal * nz + tangential * tz;
  }
}

/// Factors of the pressure and the friction on a corner, of a third of each triangle's force.
std::array<double, 2> on_corners(const std::array<double, 2>& drag) {
  return {air_density / 2 * drag[0] / 3, air_density / 2 * drag[1] / 3};
}

/// Calls visit(drag, begin, end) for the triangles of each cloth of a mesh.
template <typename Visit>
void for_each_drag(const Cloth& cloth, const Visit& visit) {
  const std::vector<int>& first = cloth.first_triangles;
  if (first.empty()) return visit(cloth.drag, std::size_t{0}, cloth.triangles.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    const bool is_last = k + 1 == first.size();
    visit(cloth.drags.empty() ? cloth.drag : cloth.drags[k], static_cast<std::size_t>(first[k]),
          is_last ? cloth.triangles.size() : static_cast<std::size_t>(first[k + 1]));
  }
}

/// Adds the forces of a mesh's triangles, one after the other.
void add_mesh_forces(const Cloth& cloth, const Vector3& wind, const State& state, Points& forces) {
  for_each_drag(cloth, [&](const auto& drag, std::size_t begin, std::size_t end) {
    const auto [across, along] = on_corners(drag);
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c] = cloth.triangles[t];
      double fx = 0, fy = 0, fz = 0;
      add_forces(run_from(state.positions, a), run_from(state.velocities, a), b - a, c - a, 1,
                 across, along, wind.x(), wind.y(), wind.z(), &fx, &fy, &fz);
      for (const int i : {a, b, c}) forces.row(i) += Eigen::RowVector3d(fx, fy, fz);
    }
  });
}

/// air_rate() for a part of a cloth.
double rate_of(const std::array<double, 2>& drag, double mass, double area, double speed) {
  // The factor 2 is that of the derivative of the square.
  return air_density * std::max(drag[0], drag[1]) * speed * area / mass;
}

/// Sums the forces of triangles on points [0, count), of which columns of cells begin there.
CLOTHSIM_TARGET_CLONES
void gather(const double* lower, const double* upper, int columns, int count,
            double* __restrict forces) {
  for (int i = 0; i < count; ++i) {
    forces[i] = lower[i] + lower[i - 1] + lower[i - columns - 1] + upper[i] +
                upper[i - columns - 1] + upper[i - columns];
  }
}

}  // namespace

Vector3 wind_at(const Vector3& mean, const Gusts& gusts, double time) {
  if (gusts.max == 0) return mean;
  std::mt19937_64 engine(gusts.seed);
  Vector3 wind = mean;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0, amplitudes = 0;
    for (double frequency = min_frequency; frequency < max_frequency; frequency *= golden_ratio) {
      // For a power of f^-5/3 df in bands of equal relative width.
      const double amplitude = std::pow(frequency, -1.0 / 3);
      const double phase = static_cast<double>(engine() >> 11) * 0x1p-53;  // [0, 1)
      sum += amplitude * std::sin(2 * M_PI * (frequency * time + phase));
      amplitudes += amplitude;
    }
    wind[axis] += gusts.max * sum / amplitudes;
  }
  return wind;
}

const Points& AirForces::compute(const Cloth& cloth, const Vector3& wind, const State& state,
                                 const Workers& workers) {
  const int n = cloth.num_points();
  const int columns = cloth.columns;
  forces_.setZero(n, 3);
  if (cloth.triangles.empty()) return forces_;
  if (cloth.is_mesh()) {
    add_mesh_forces(cloth, wind, state, forces_);
    return forces_;
  }
  const auto [across, along] = on_corners(cloth.drag);

  // Triangles by the first point of their cell; entries before them stay zero for points without
  // one.
  const int before = columns + 1;
  for (Points* points : {&lower_, &upper_}) {
    if (points->rows() != before + n) points->setZero(before + n, 3);
  }
  const auto add_rows = [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      const int i = row * columns;
      const PointRun p = run_from(state.positions, i);
      const PointRun v = run_from(state.velocities, i);
      const auto add_all = [&](int b, int c, Points& forces) {
        double* const f = &forces(before + i, 0);
        const auto stride = forces.rows();
        add_forces(p, v, b, c, columns - 1, across, along, wind.x(), wind.y(), wind.z(), f,
                   f + stride, f + 2 * stride);
      };
      add_all(1, columns + 1, lower_);
      add_all(columns + 1, columns, upper_);
    }
  };
  workers.parallel_for(cloth.rows - 1, add_rows, std::max(1, Workers::dear / columns));
  workers.parallel_for(n, [&](int begin, int end) {
    for (int axis = 0; axis < 3; ++axis) {
      gather(&lower_(before + begin, axis), &upper_(before + begin, axis), columns, end - begin,
             &forces_(begin, axis));
    }
  });
  return forces_;
}

double air_rate(const Cloth& cloth, double speed) {
  if (cloth.triangles.empty()) return 0;
  if (cloth.is_mesh()) {
    double fastest = 0;
    for_each_drag(cloth, [&](const auto& drag, std::size_t begin, std::size_t end) {
      double mass = 0, area = 0;
      for (std::size_t t = begin; t < end; ++t) {
        const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
        mass += 3 * triangle.mass;
        area += triangle.area;
      }
      fastest = std::max(fastest, rate_of(drag, mass, area, speed));
    });
    return fastest;
  }
  const auto& [a, b, c] = cloth.triangles.front();
  const Vector3 corner = row(cloth.rest_positions, a);
  const double cell =
      (row(cloth.rest_positions, b) - corner).cross(row(cloth.rest_positions, c) - corner).norm();
  const double area = cell * (cloth.rows - 1) * (cloth.columns - 1);
  return rate_of(cloth.drag, cloth.mass.sum(), area, speed);
}

}  // namespace clothsim
