#include "clothsim/dynamics/triangle_forces.h"

#include <array>
#include <vector>

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/model/point_run.h"
#include "clothsim/model/target_clones.h"

namespace clothsim {
namespace {

/// x, y, z of a point, and 0.
using Quad = double __attribute__((vector_size(32), aligned(8), may_alias));
/// A point's position and velocity, each as a Quad, in one cache line. Vectors of 64 bytes would be
/// as fast where registers are as wide, and six times as slow elsewhere.
struct alignas(64) MovingPoint {
  std::array<double, 8> numbers;
};

/// Numbers that one computation of forces keeps between its loops. Its threads share them; calls
/// of different threads do not.
struct Scratch {
  void fit(const TriangleFabric& fabric, bool damped) {
    const std::size_t points = fabric.first_links.size() - 1;
    grow(damped ? 0 : 4 * points, positions);
    grow(damped ? points : 0, moving);
    grow(damped ? points : 0, bends);
    grow(fabric.edges.size(), squares);
    grow(static_cast<std::size_t>(fabric.no_pull()) + 1, pulls);
    grow(fabric.edges.size(), factors);
  }
  template <typename Number>
  static void grow(std::size_t size, std::vector<Number>& numbers) {
    if (numbers.size() < size) numbers.resize(size);
  }

  /// Without damping, and with it.
  const Quad* x() const { return reinterpret_cast<const Quad*>(positions.data()); }
  const Quad* xv() const { return reinterpret_cast<const Quad*>(moving.data()); }
  QuadView x_view(bool damped) const {
    return damped ? QuadView{numbers(moving), 8} : QuadView{positions.data(), 4};
  }
  QuadView v_view() const { return {numbers(moving) + 4, 8}; }
  static const double* numbers(const std::vector<MovingPoint>& points) {
    return reinterpret_cast<const double*>(points.data());
  }

  std::vector<double> positions;    // by point, a Quad each
  std::vector<MovingPoint> moving;  // the same with velocities
  std::vector<double> squares;      // by edge: q + tau_0 q' [m^2]
  std::vector<double> pulls;        // by pull_number(), and a 0 [N/m]
  std::vector<double> factors;      // by edge [N/m]
  std::vector<MovingPoint> bends;   // by point: sums of tau_1 weight * (x_j - x_i) [N s], and of
                                    // tau_1 weight * (v_j - v_i) [N]
};

Scratch& scratch_of(const TriangleFabric& fabric, bool damped) {
  static thread_local Scratch scratch;
  scratch.fit(fabric, damped);
  return scratch;
}

/// Writes points, `stride` numbers from one to the next, each with a 0.
CLOTHSIM_TARGET_CLONES
void interleave(int count, PointRun points, int stride, double* __restrict to) {
  for (int i = 0; i < count; ++i) {
    to[stride * i] = points.x[i];
    to[stride * i + 1] = points.y[i];
    to[stride * i + 2] = points.z[i];
    to[stride * i + 3] = 0;
  }
}

/// Writes a . b of four pairs, without a sum across one vector, which takes as long as all four.
[[gnu::always_inline]] inline void write_dots(const Quad* a, const Quad* b, double* to) {
  const Quad p = a[0] * b[0], q = a[1] * b[1], r = a[2] * b[2], s = a[3] * b[3];
  const Quad pq = Quad{p[0], q[0], p[2], q[2]} + Quad{p[1], q[1], p[3], q[3]};
  const Quad rs = Quad{r[0], s[0], r[2], s[2]} + Quad{r[1], s[1], r[3], s[3]};
  *reinterpret_cast<Quad*>(to) =
      Quad{pq[0], pq[1], rs[0], rs[1]} + Quad{pq[2], pq[3], rs[2], rs[3]};
}

/// The difference d of an edge's ends, and d + 2 tau_0 d'.
template <bool damped>
[[gnu::always_inline]] inline void set_factors(const TriangleFabric& fabric, const Scratch& scratch,
                                               int e, Quad& d, Quad& other) {
  const auto number = static_cast<std::size_t>(e);
  const auto& [a, b] = fabric.edges[number];
  if constexpr (damped) {
    const Quad* const xv = scratch.xv();
    d = xv[2 * b] - xv[2 * a];
    other = d + fabric.edge_damping[number] * (xv[2 * b + 1] - xv[2 * a + 1]);
  } else {
    d = other = scratch.x()[b] - scratch.x()[a];
  }
}

/// q + tau_0 q' of edges [begin, end).
template <bool damped>
[[gnu::always_inline]] inline void square_edges_of(const TriangleFabric& fabric, int begin, int end,
                                                   Scratch& scratch) {
  Quad d[4] = {}, others[4] = {};
  int e = begin;
  for (; e + 4 <= end; e += 4) {
    for (int k = 0; k < 4; ++k) set_factors<damped>(fabric, scratch, e + k, d[k], others[k]);
    write_dots(d, others, scratch.squares.data() + e);
  }
  for (; e < end; ++e) {
    set_factors<damped>(fabric, scratch, e, d[0], others[0]);
    const Quad product = d[0] * others[0];
    scratch.squares[static_cast<std::size_t>(e)] = product[0] + product[1] + product[2];
  }
}

CLOTHSIM_TARGET_CLONES
void square_edges(const TriangleFabric& fabric, bool damped, int begin, int end, Scratch& scratch) {
  if (damped) {
    square_edges_of<true>(fabric, begin, end, scratch);
  } else {
    square_edges_of<false>(fabric, begin, end, scratch);
  }
}

/// s = K (q - Q) of blocks [begin, end).
CLOTHSIM_TARGET_CLONES
void pull_triangles(const TriangleFabric::Block* blocks, const double* squares, int begin, int end,
                    double* __restrict pulls) {
  constexpr int size = TriangleFabric::Block::size;
  for (int b = begin; b < end; ++b) {
    const auto& [edges, rest2, stretch] = blocks[b];
    double* const pull = pulls + 3 * size * b;
#pragma GCC ivdep
    for (std::size_t i = 0; i < size; ++i) {
      const double one = squares[edges[0][i]] - rest2[0][i];
      const double two = squares[edges[1][i]] - rest2[1][i];
      const double three = squares[edges[2][i]] - rest2[2][i];
      pull[i] = stretch[0][i] * one + stretch[3][i] * two + stretch[4][i] * three;
      pull[size + i] = stretch[3][i] * one + stretch[1][i] * two + stretch[5][i] * three;
      pull[2 * size + i] = stretch[4][i] * one + stretch[5][i] * two + stretch[2][i] * three;
    }
  }
}

/// The factors of edges [begin, end): weights of bends, and pulls of both triangles.
CLOTHSIM_TARGET_CLONES
void add_pulls(const std::array<int, 2>* pulls_of, const double* weights, const double* pulls,
               int begin, int end, double* __restrict factors) {
#pragma GCC ivdep
  for (int e = begin; e < end; ++e) {
    factors[e] = weights[e] + 2 * (pulls[pulls_of[e][0]] + pulls[pulls_of[e][1]]);
  }
}

/// Adds forces factor * (x_j - x_i) to points [begin, end), over their edges and bends.
CLOTHSIM_TARGET_CLONES
void sum_links(const TriangleFabric& fabric, int begin, int end, const Scratch& scratch,
               MutablePointRun forces) {
  const auto& [others, weights, first] = fabric.bend_links;
  const double* const factors = scratch.factors.data();
  const Quad* const x = scratch.x();
  for (int i = begin; i < end; ++i) {
    const auto point = static_cast<std::size_t>(i);
    const Quad here = x[i];
    Quad sum = {}, far = {};
    for (auto l = static_cast<std::size_t>(fabric.first_links[point]);
         l < static_cast<std::size_t>(fabric.first_links[point + 1]); ++l) {
      const auto& [j, edge] = fabric.edge_links[l];
      sum += factors[edge] * (x[j] - here);
    }
    for (auto l = static_cast<std::size_t>(first[point]);
         l < static_cast<std::size_t>(first[point + 1]); ++l) {
      far += weights[l] * (x[others[l]] - here);
    }
    sum += far;
    forces.x[i] += sum[0];
    forces.y[i] += sum[1];
    forces.z[i] += sum[2];
  }
}

/// The same with damping: also sets the sums over bends.
CLOTHSIM_TARGET_CLONES
void sum_damped_links(const TriangleFabric& fabric, int begin, int end, Scratch& scratch,
                      MutablePointRun forces) {
  const auto& [others, weights, first] = fabric.bend_links;
  const double* const factors = scratch.factors.data();
  const double* const edge_weights = fabric.edge_weights.data();
  const Quad* const xv = scratch.xv();
  Quad* const bends = reinterpret_cast<Quad*>(scratch.bends.data());
  for (int i = begin; i < end; ++i) {
    const auto point = static_cast<std::size_t>(i);
    const Quad x = xv[2 * i], v = xv[2 * i + 1];
    Quad sum = {}, bend = {}, rate = {}, far = {}, far_rate = {};
    for (auto l = static_cast<std::size_t>(fabric.first_links[point]);
         l < static_cast<std::size_t>(fabric.first_links[point + 1]); ++l) {
      const auto& [j, edge] = fabric.edge_links[l];
      const Quad d = xv[2 * j] - x;
      sum += factors[edge] * d;
      bend += edge_weights[edge] * d;
      rate += edge_weights[edge] * (xv[2 * j + 1] - v);
    }
    for (auto l = static_cast<std::size_t>(first[point]);
         l < static_cast<std::size_t>(first[point + 1]); ++l) {
      const int j = others[l];
      far += weights[l] * (xv[2 * j] - x);
      far_rate += weights[l] * (xv[2 * j + 1] - v);
    }
    sum += far;
    forces.x[i] += sum[0];
    forces.y[i] += sum[1];
    forces.z[i] += sum[2];
    const double tau = fabric.internal_damping_at(i)[1];
    bends[2 * i] = tau * (bend + far);
    bends[2 * i + 1] = tau * (rate + far_rate);
  }
}

/// Subtracts the moments of the sums of points [begin, end) about point `centre`.
CLOTHSIM_TARGET_CLONES
void subtract_moments(const Scratch& scratch, int centre, int begin, int end, BendMotion& motion) {
  const Quad* const xv = scratch.xv();
  const Quad* const bends = reinterpret_cast<const Quad*>(scratch.bends.data());
  const Quad origin = xv[2 * centre];
  Quad of_bends[3] = {}, of_rates[3] = {};  // times the components of the arm
  for (int i = begin; i < end; ++i) {
    const Quad arm = xv[2 * i] - origin;
    for (int axis = 0; axis < 3; ++axis) {
      of_bends[axis] += arm[axis] * bends[2 * i];
      of_rates[axis] += arm[axis] * bends[2 * i + 1];
    }
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    for (int axis = 0; axis < 3; ++axis) motion.squares(a, axis) -= of_bends[a][axis];
    motion.moment[a] -= of_rates[b][c] - of_rates[c][b];
  }
}

/// The angular velocity of each piece. Sums over pairs are sums over points: that of w d d^T is
/// that of -x_i sum_j w (x_j - x_i)^T; that of w d x d' alike.
std::vector<Vector3> rotations_of(const TriangleFabric& fabric, const Scratch& scratch) {
  std::vector<BendMotion> motions(fabric.pieces.size());
  add_curved_motions(fabric, scratch.x_view(true), scratch.v_view(), motions);
  for (std::size_t piece = 0; piece < motions.size(); ++piece) {
    const double tau = fabric.pieces[piece].internal_damping[1];  // as in the sums over points
    motions[piece].squares *= tau;
    motions[piece].moment *= tau;
    motions[piece].stiffness = tau * fabric.pieces[piece].weight;
  }
  const auto points = static_cast<int>(fabric.piece_ids.size());
  for (int begin = 0, end = 0; begin < points; begin = end) {
    const int piece = fabric.piece_of(begin);
    while (end < points && fabric.piece_of(end) == piece) ++end;
    const int centre = fabric.pieces[static_cast<std::size_t>(piece)].first_point;
    subtract_moments(scratch, centre, begin, end, motions[static_cast<std::size_t>(piece)]);
  }
  std::vector<Vector3> rotations;
  for (const BendMotion& motion : motions) rotations.push_back(motion.rotation());
  return rotations;
}

/// Adds rates less omega x bends to the forces of points [begin, end).
CLOTHSIM_TARGET_CLONES
void add_relative_rates(const TriangleFabric& fabric, const Scratch& scratch,
                        const Vector3* rotations, int begin, int end, MutablePointRun forces) {
  const int* const pieces = fabric.piece_ids.data();
  const double* const sums = Scratch::numbers(scratch.bends);
#pragma GCC ivdep
  for (int i = begin; i < end; ++i) {
    const double* const omega = rotations[pieces[i]].data();
    const double bx = sums[8 * i], by = sums[8 * i + 1], bz = sums[8 * i + 2];
    forces.x[i] += sums[8 * i + 4] - (omega[1] * bz - omega[2] * by);
    forces.y[i] += sums[8 * i + 5] - (omega[2] * bx - omega[0] * bz);
    forces.z[i] += sums[8 * i + 6] - (omega[0] * by - omega[1] * bx);
  }
}

/// Damping of bends, relative to the rotation of their piece: see remove_rotation().
void add_damping_of_bends(const TriangleFabric& fabric, const Scratch& scratch,
                          const Workers& workers, Points& forces) {
  const std::vector<Vector3> rotations = rotations_of(fabric, scratch);
  workers.parallel_for(static_cast<int>(fabric.piece_ids.size()), [&](int begin, int end) {
    add_relative_rates(fabric, scratch, rotations.data(), begin, end, run_from(forces, 0));
  });
  add_curved_damping(fabric, 1, scratch.x_view(true), scratch.v_view(), rotations, workers, forces);
}

}  // namespace

void compute_triangle_forces(const Cloth& cloth, const Loads& loads, const Points& positions,
                             Points& forces, const Workers& workers, const Points* velocities) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  const bool damped = velocities != nullptr && is_damped(cloth);
  Scratch& scratch = scratch_of(fabric, damped);

  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    const int count = end - begin;
    if (!damped) {
      interleave(count, run_from(positions, begin), 4, scratch.positions.data() + 4 * begin);
      return;
    }
    double* const numbers = reinterpret_cast<double*>(scratch.moving.data()) + 8 * begin;
    interleave(count, run_from(positions, begin), 8, numbers);
    interleave(count, run_from(*velocities, begin), 8, numbers + 4);
  });
  workers.parallel_for(static_cast<int>(fabric.edges.size()), [&](int begin, int end) {
    square_edges(fabric, damped, begin, end, scratch);
  });
  constexpr int min_band = 1024 / TriangleFabric::Block::size;  // as long as bands of triangles
  workers.parallel_for(
      static_cast<int>(fabric.blocks.size()),
      [&](int begin, int end) {
        pull_triangles(fabric.blocks.data(), scratch.squares.data(), begin, end,
                       scratch.pulls.data());
      },
      min_band);
  scratch.pulls[static_cast<std::size_t>(fabric.no_pull())] = 0;
  workers.parallel_for(static_cast<int>(fabric.edges.size()), [&](int begin, int end) {
    add_pulls(fabric.pulls_of.data(), fabric.edge_weights.data(), scratch.pulls.data(), begin, end,
              scratch.factors.data());
  });
  workers.parallel_for(cloth.num_points(), [&](int begin, int end) {
    for (int axis = 0; axis < 3; ++axis) {
      forces.col(axis).segment(begin, end - begin) =
          loads.gravity[axis] * cloth.mass.segment(begin, end - begin);
    }
    if (damped) {
      sum_damped_links(fabric, begin, end, scratch, run_from(forces, 0));
    } else {
      sum_links(fabric, begin, end, scratch, run_from(forces, 0));
    }
  });
  add_curved_forces(fabric, scratch.x_view(damped), workers, forces);
  if (damped && has_damped_bends(cloth)) add_damping_of_bends(fabric, scratch, workers, forces);
}

Vector3 squared_edges(const std::array<int, 3>& corners, const Points& positions) {
  Vector3 squares;
  for (std::size_t k = 0; k < 3; ++k) {
    squares[static_cast<Eigen::Index>(k)] =
        (positions.row(corners[(k + 1) % 3]) - positions.row(corners[k])).squaredNorm();
  }
  return squares;
}

double membrane_energy(const Cloth& cloth, const Points& positions) {
  double energy = 0;
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const TriangleFabric::Triangle& triangle = cloth.triangle_fabric->triangles[t];
    const Vector3 change = squared_edges(cloth.triangles[t], positions) - triangle.rest2;
    energy += change.dot(triangle.stretch * change) / 2;
  }
  return energy;
}

Vector3 triangle_pulls(const Cloth& cloth, std::size_t triangle, const Points& positions,
                       const Points* velocities) {
  const std::array<int, 3>& corners = cloth.triangles[triangle];
  const TriangleFabric::Triangle& of = cloth.triangle_fabric->triangles[triangle];
  Vector3 change = squared_edges(corners, positions) - of.rest2;
  if (velocities == nullptr) return of.stretch * change;
  for (std::size_t k = 0; k < 3; ++k) {
    const int a = corners[k], b = corners[(k + 1) % 3];
    change[static_cast<Eigen::Index>(k)] +=
        2 * cloth.internal_damping_at(a)[0] *
        (positions.row(b) - positions.row(a)).dot(velocities->row(b) - velocities->row(a));
  }
  return of.stretch * change;
}

std::vector<double> edge_tensions(const Cloth& cloth, const Points& positions,
                                  const Points* velocities) {
  const TriangleFabric& fabric = *cloth.triangle_fabric;
  std::vector<double> tensions(fabric.edges.size(), 0.0);
  for (std::size_t t = 0; t < fabric.triangles.size(); ++t) {
    const Vector3 pulls = triangle_pulls(cloth, t, positions, velocities);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto e = static_cast<std::size_t>(fabric.triangles[t].edges[k]);
      const auto& [a, b] = fabric.edges[e];
      tensions[e] +=
          2 * pulls[static_cast<Eigen::Index>(k)] * (positions.row(b) - positions.row(a)).norm();
    }
  }
  return tensions;
}

Eigen::Matrix3d squared_derivatives(const Vector3& q, const Vector3& w) {
  Eigen::Matrix3d product;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index j = (i + 1) % 3;
    product(i, i) = q[i] * (w[i] + w[j]);
    product(i, j) = product(j, i) = -(q[3 - i - j] - q[i] - q[j]) / 2 * w[j];
  }
  return product;
}

}  // namespace clothsim
