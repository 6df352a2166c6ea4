#include "clothsim/dynamics/curved_bends.h"

#include <array>
#include <vector>

#include "clothsim/model/smooth_normal.h"

namespace clothsim {
namespace {

/// The forces of a triangle on its points [N].
using TriangleForces = std::array<Vector3, PatchBend::size>;

TriangleForces forces_of(const CurvedTriangle& curved, const double* positions) {
  const auto at = [&](std::size_t k) {
    return Eigen::Map<const Vector3>(positions + 4 * curved.points[k]);
  };
  const SmoothNormal normal(at(0), at(1), at(2), curved.softening);
  const Vector3& n = normal.normal();
  Vector3 gradient = -curved.stiffness * n;
  for (std::size_t k = 0; k < PatchBend::size; ++k) gradient += curved.weights[k] * at(k);
  TriangleForces forces;
  for (std::size_t k = 0; k < PatchBend::size; ++k) forces[k] = curved.weights[k] * n;
  for (std::size_t k = 0; k < 3; ++k) forces[k] += normal.pulled_back(k, gradient);
  return forces;
}

}  // namespace

void add_curved_forces(const TriangleFabric& fabric, const double* positions,
                       const Workers& workers, Points& forces) {
  if (fabric.curved.empty()) return;
  static thread_local std::vector<TriangleForces> of_triangles;
  std::vector<TriangleForces>& all = of_triangles;  // of this thread, for all workers
  all.resize(fabric.curved.size());
  workers.parallel_for(static_cast<int>(all.size()), [&](int begin, int end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      all[t] = forces_of(fabric.curved[t], positions);
    }
  });
  workers.parallel_for(static_cast<int>(forces.rows()), [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto point = static_cast<std::size_t>(i);
      Vector3 sum = Vector3::Zero();
      for (int l = fabric.first_curved_links[point]; l < fabric.first_curved_links[point + 1];
           ++l) {
        const auto& [curved, place] = fabric.curved_links[static_cast<std::size_t>(l)];
        sum += all[static_cast<std::size_t>(curved)][static_cast<std::size_t>(place)];
      }
      forces.row(i) += sum.transpose();
    }
  });
}

void add_curved_sums(const Cloth& cloth, const Points& positions, Scalars& sums) {
  for (const CurvedTriangle& curved : cloth.triangle_fabric->curved) {
    const SmoothNormal normal(curved, positions);
    Vector3 gradient = -curved.stiffness * normal.normal();
    for (std::size_t k = 0; k < PatchBend::size; ++k) {
      gradient += curved.weights[k] * row(positions, curved.points[k]);
    }
    const double stiffness = curved.stiffness + 5 * gradient.norm();
    const double slopes = normal.slope(0) + normal.slope(1) + normal.slope(2);
    for (std::size_t k = 0; k < 3; ++k) {
      sums[curved.points[k]] += stiffness * normal.slope(k) * slopes;
    }
  }
}

}  // namespace clothsim
