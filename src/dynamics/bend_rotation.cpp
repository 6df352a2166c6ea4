#include "clothsim/dynamics/bend_rotation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/model/lanes.h"
#include "clothsim/model/point_run.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// Points that are summed at once: any number of threads sums in the same order.
constexpr int points_in_sum = 1024;

/// Sums over stencils b of stiffness k and rate b': of k b b^T its xx, yy, zz, xy, yz, zx; of
/// k b x b'; and of k.
enum { num_sums = 10 };
using Sums = std::array<double, num_sums>;

/// Four numbers in registers, unlike Half without attributes that templates would drop.
using Four = double __attribute__((vector_size(32)));

template <typename Number>
[[gnu::always_inline]] inline void load(const double* from, Number& number) {
  std::memcpy(&number, from, sizeof number);
}

/// Sets `sum` to that of the stencil at numbers[i], or of all from there.
template <typename Number>
[[gnu::always_inline]] inline void sum_at(const double* numbers, int i, const BendBand& band,
                                          Number& sum) {
  const auto& [a, b, stiffness] = band;
  Number first, second, third;
  load(numbers + i, first);
  load(numbers + i + a, second);
  load(numbers + i + b, third);
  load(numbers + i + a + b, sum);
  sum = (first - second) - (third - sum);
}

template <typename Number>
[[gnu::always_inline]] inline void add_stencils(int i, const BendBand& band,
                                                const double* stiffness, PointRun p, PointRun v,
                                                Number* sums) {
  Number k, x, y, z, a, b, c;
  load(stiffness + i, k);
  sum_at(p.x, i, band, x);
  sum_at(p.y, i, band, y);
  sum_at(p.z, i, band, z);
  sum_at(v.x, i, band, a);
  sum_at(v.y, i, band, b);
  sum_at(v.z, i, band, c);
  const Number wx = k * x, wy = k * y, wz = k * z;
  sums[0] += wx * x;
  sums[1] += wy * y;
  sums[2] += wz * z;
  sums[3] += wx * y;
  sums[4] += wy * z;
  sums[5] += wz * x;
  sums[6] += wy * c - wz * b;
  sums[7] += wz * a - wx * c;
  sums[8] += wx * b - wy * a;
  sums[9] += k;
}

/// Adds the band's stencils at points [0, count) of the columns to `total`.
CLOTHSIM_TARGET_CLONES
void sum_stencils(const BendBand& band, const double* stiffness, int count, PointRun p, PointRun v,
                  Sums& total) {
  Four sums[2][num_sums] = {};
  int i = 0;
  for (; i + num_lanes <= count; i += num_lanes) {
    add_stencils(i, band, stiffness, p, v, sums[0]);
    add_stencils(i + half_size, band, stiffness, p, v, sums[1]);
  }
  for (; i < count; ++i) add_stencils(i, band, stiffness, p, v, total.data());
  for (std::size_t k = 0; k < num_sums; ++k) {
    for (int half = 0; half < 2; ++half) {
      for (int lane = 0; lane < half_size; ++lane) total[k] += sums[half][k][lane];
    }
  }
}

void add(const Sums& sums, BendMotion& motion) {
  const auto& [xx, yy, zz, xy, yz, zx, x, y, z, weight] = sums;
  motion.squares += (Eigen::Matrix3d() << xx, xy, zx, xy, yy, yz, zx, yz, zz).finished();
  motion.moment += Vector3(x, y, z);
  motion.stiffness += weight;
}

BendMotion motion_of_grid(const Cloth& cloth, const Points& positions, const Points& rates,
                          const Workers& workers) {
  const std::size_t num_bands = cloth.bend_bands.size();
  const int parts = (cloth.num_points() + points_in_sum - 1) / points_in_sum;
  std::vector<Sums> sums(static_cast<std::size_t>(parts) * num_bands, Sums{});
  const auto sum_part = [&](int part, std::size_t k) {
    const BendBand& band = cloth.bend_bands[k];
    const int begin = part * points_in_sum;
    const int end = std::min(begin + points_in_sum, static_cast<int>(band.stiffness.size()));
    if (begin >= end) return;
    Sums& result = sums[static_cast<std::size_t>(part) * num_bands + k];
    sum_stencils(band, &band.stiffness[begin], end - begin, run_from(positions, begin),
                 run_from(rates, begin), result);
    result[num_sums - 1] *= band.a == band.b ? 3 : 2;  // half the sum of squared coefficients
  };
  workers.parallel_for(
      parts,
      [&](int from, int to) {
        for (int part = from; part < to; ++part) {
          for (std::size_t k = 0; k < num_bands; ++k) sum_part(part, k);
        }
      },
      1);
  BendMotion motion;
  for (const Sums& part : sums) add(part, motion);
  return motion;
}

/// Writes v less the velocities of a rotation about `centre`.
CLOTHSIM_TARGET_CLONES
void subtract_rotation(int count, const double* omega, const double* centre, PointRun p, PointRun v,
                       double* __restrict rx, double* __restrict ry, double* __restrict rz) {
  const double a = omega[0], b = omega[1], c = omega[2];
  for (int i = 0; i < count; ++i) {
    const double x = p.x[i] - centre[0], y = p.y[i] - centre[1], z = p.z[i] - centre[2];
    rx[i] = v.x[i] - (b * z - c * y);
    ry[i] = v.y[i] - (c * x - a * z);
    rz[i] = v.z[i] - (a * y - b * x);
  }
}

std::vector<BendMotion> motions_of_mesh(const Cloth& cloth, const Points& positions,
                                        const Points& rates) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  std::vector<BendMotion> motions(fabric.pieces.size());
  for (const auto& [i, j, weight] : fabric.pairs) {
    const Vector3 d = row(positions, j) - row(positions, i);
    const Vector3 rate = row(rates, j) - row(rates, i);
    BendMotion& motion = motions[static_cast<std::size_t>(fabric.piece_of(i))];
    motion.squares.noalias() += weight * d * d.transpose();
    motion.moment += weight * d.cross(rate);
    motion.stiffness += weight;
  }
  add_curved_motions(fabric, PointView(positions), PointView(rates), motions);
  return motions;
}

}  // namespace

Vector3 BendMotion::rotation() const {
  const double least = stiffness * min_bend * min_bend;
  const Eigen::Matrix3d resistance =
      (squares.trace() + least) * Eigen::Matrix3d::Identity() - squares;
  return resistance.ldlt().solve(moment);
}

std::vector<Vector3> bend_rotations(const Cloth& cloth, const Points& positions,
                                    const Points& rates, const Workers& workers) {
  if (!cloth.is_mesh()) return {motion_of_grid(cloth, positions, rates, workers).rotation()};
  std::vector<Vector3> rotations;
  for (const BendMotion& motion : motions_of_mesh(cloth, positions, rates)) {
    rotations.push_back(motion.rotation());
  }
  return rotations;
}

void remove_rotation(const Cloth& cloth, const Points& positions, const Points& rates,
                     Points& relative, const Workers& workers) {
  const int n = cloth.num_points();
  relative.resize(n, 3);
  const std::vector<Vector3> rotations = bend_rotations(cloth, positions, rates, workers);
  if (cloth.is_mesh()) {
    const TriangleFabric& fabric = *cloth.triangle_fabric;
    for (int i = 0; i < n; ++i) {
      const auto piece = static_cast<std::size_t>(fabric.piece_of(i));
      const Vector3 arm = row(positions, i) - row(positions, fabric.pieces[piece].first_point);
      relative.row(i) = rates.row(i) - rotations[piece].cross(arm).transpose();
    }
    return;
  }
  const Vector3 centre = row(positions, 0);
  workers.parallel_for(n, [&](int begin, int end) {
    subtract_rotation(end - begin, rotations[0].data(), centre.data(), run_from(positions, begin),
                      run_from(rates, begin), &relative(begin, 0), &relative(begin, 1),
                      &relative(begin, 2));
  });
}

}  // namespace clothsim
