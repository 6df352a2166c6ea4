#include "clothsim/dynamics/curved_bends.h"

#include <array>
#include <vector>

#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

/// The forces of a triangle on its points [N].
using TriangleForces = std::array<Vector3, PatchBend::near>;

template <typename View>
SmoothNormal normal_of(const CurvedTriangle& curved, const View& positions) {
  const auto& [a, b, c, d, e, f] = curved.points;
  return {positions(a), positions(b), positions(c), curved.softening};
}

/// The sum of g_i times `values`.
template <typename View>
Vector3 weighted_sum(const CurvedTriangle& curved, const View& values) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < PatchBend::near; ++k) {
    sum += curved.weights[k] * values(curved.points[k]);
  }
  return sum;
}

/// The sum of g_i x_i and n, or their rates.
struct Terms {
  Vector3 sum;
  Vector3 normal;
};

template <typename View>
Terms terms_of(const CurvedTriangle& curved, const SmoothNormal& normal, const View& positions) {
  return {weighted_sum(curved, positions), normal.normal()};
}

template <typename View>
Terms rates_of(const CurvedTriangle& curved, const SmoothNormal& normal, const View& rates) {
  const auto& [a, b, c, d, e, f] = curved.points;
  return {weighted_sum(curved, rates), normal.rate(rates(a), rates(b), rates(c))};
}

/// J^T k B (b - B n) without the pairs' part, or the same of rates.
TriangleForces forces_of(const CurvedTriangle& curved, const SmoothNormal& normal,
                         const Terms& terms) {
  const Vector3 gradient = terms.sum - curved.stiffness * terms.normal;
  TriangleForces forces;
  for (std::size_t k = 0; k < PatchBend::near; ++k) forces[k] = curved.weights[k] * terms.normal;
  for (std::size_t k = 0; k < 3; ++k) forces[k] += normal.pulled_back(k, gradient);
  return forces;
}

/// Damping forces of a triangle, by its rates less those of a rotation.
template <typename View>
TriangleForces damping_of(const TriangleFabric& fabric, const CurvedTriangle& curved,
                          const View& positions, const View& velocities, const Vector3& rotation) {
  const double tau = fabric.internal_damping_at(curved.points[0])[1];
  const SmoothNormal normal = normal_of(curved, positions);
  Terms rates = rates_of(curved, normal, velocities);
  rates.sum = tau * (rates.sum - rotation.cross(weighted_sum(curved, positions)));
  rates.normal = tau * (rates.normal - rotation.cross(normal.normal()));
  return forces_of(curved, normal, rates);
}

template <typename View>
TriangleForces elastic_of(const CurvedTriangle& curved, const View& positions) {
  const SmoothNormal normal = normal_of(curved, positions);
  return forces_of(curved, normal, terms_of(curved, normal, positions));
}

/// Calls visit(triangle, place) for each curved triangle of a point.
template <typename Visitor>
void for_each_link(const TriangleFabric& fabric, int point, const Visitor& visit) {
  const auto i = static_cast<std::size_t>(point);
  for (int l = fabric.first_curved_links[i]; l < fabric.first_curved_links[i + 1]; ++l) {
    const auto& [curved, place] = fabric.curved_links[static_cast<std::size_t>(l)];
    visit(static_cast<std::size_t>(curved), static_cast<std::size_t>(place));
  }
}

/// Adds `factor` times the forces of all triangles, forces_on(curved) each.
template <typename ForcesOn>
void add_forces(const TriangleFabric& fabric, double factor, const Workers& workers,
                const ForcesOn& forces_on, Points& forces) {
  static thread_local std::vector<TriangleForces> of_triangles;
  std::vector<TriangleForces>& all = of_triangles;  // of this thread, for all workers
  all.resize(fabric.curved.size());
  workers.parallel_for(static_cast<int>(all.size()), [&](int begin, int end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      all[t] = forces_on(fabric.curved[t]);
    }
  });
  workers.parallel_for(static_cast<int>(forces.rows()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      Vector3 sum = Vector3::Zero();
      for_each_link(fabric, i, [&](std::size_t t, std::size_t place) { sum += all[t][place]; });
      forces.row(i) += factor * sum.transpose();
    }
  });
}

}  // namespace

template <typename View>
void add_curved_forces(const TriangleFabric& fabric, const View& positions, const Workers& workers,
                       Points& forces) {
  if (fabric.curved.empty()) return;
  const auto forces_on = [&](const CurvedTriangle& curved) {
    return elastic_of(curved, positions);
  };
  add_forces(fabric, 1, workers, forces_on, forces);
}

template <typename View>
void add_curved_damping(const TriangleFabric& fabric, double factor, const View& positions,
                        const View& velocities, const std::vector<Vector3>& rotations,
                        const Workers& workers, Points& forces) {
  if (fabric.curved.empty()) return;
  const auto forces_on = [&](const CurvedTriangle& curved) {
    const auto piece = static_cast<std::size_t>(fabric.piece_of(curved.points[0]));
    return damping_of(fabric, curved, positions, velocities,
                      rotations.empty() ? Vector3(Vector3::Zero()) : rotations[piece]);
  };
  add_forces(fabric, factor, workers, forces_on, forces);
}

Vector3 curved_force_on(const TriangleFabric& fabric, int point, const Points& positions,
                        const Points* velocities) {
  Vector3 sum = Vector3::Zero();
  if (fabric.curved.empty()) return sum;
  const PointView x(positions);
  for_each_link(fabric, point, [&](std::size_t t, std::size_t place) {
    const CurvedTriangle& curved = fabric.curved[t];
    sum += elastic_of(curved, x)[place];
    if (velocities == nullptr) return;
    sum += damping_of(fabric, curved, x, PointView(*velocities), Vector3::Zero())[place];
  });
  return sum;
}

template <typename View>
void add_curved_motions(const TriangleFabric& fabric, const View& positions, const View& rates,
                        std::vector<BendMotion>& motions) {
  for (const CurvedTriangle& curved : fabric.curved) {
    const SmoothNormal normal = normal_of(curved, positions);
    const Terms at = terms_of(curved, normal, positions);
    const Terms rate = rates_of(curved, normal, rates);
    const double s = curved.stiffness;
    BendMotion& motion = motions[static_cast<std::size_t>(fabric.piece_of(curved.points[0]))];
    const Eigen::Matrix3d mixed = at.sum * at.normal.transpose();
    motion.squares += s * at.normal * at.normal.transpose() - mixed - mixed.transpose();
    motion.moment +=
        s * at.normal.cross(rate.normal) - at.sum.cross(rate.normal) - at.normal.cross(rate.sum);
  }
}

void add_curved_sums(const Cloth& cloth, const Points& positions, Scalars& sums) {
  for (const CurvedTriangle& curved : cloth.triangle_fabric->curved) {
    const SmoothNormal normal(curved, positions);
    const Vector3 gradient =
        weighted_sum(curved, PointView(positions)) - curved.stiffness * normal.normal();
    const double stiffness = curved.stiffness + 5 * gradient.norm();
    const double slopes = normal.slope(0) + normal.slope(1) + normal.slope(2);
    for (std::size_t k = 0; k < 3; ++k) {
      sums[curved.points[k]] += stiffness * normal.slope(k) * slopes;
    }
  }
}

template void add_curved_forces(const TriangleFabric&, const QuadView&, const Workers&, Points&);
template void add_curved_damping(const TriangleFabric&, double, const QuadView&, const QuadView&,
                                 const std::vector<Vector3>&, const Workers&, Points&);
template void add_curved_damping(const TriangleFabric&, double, const PointView&, const PointView&,
                                 const std::vector<Vector3>&, const Workers&, Points&);
template void add_curved_motions(const TriangleFabric&, const QuadView&, const QuadView&,
                                 std::vector<BendMotion>&);
template void add_curved_motions(const TriangleFabric&, const PointView&, const PointView&,
                                 std::vector<BendMotion>&);

}  // namespace clothsim
