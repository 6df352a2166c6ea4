#include "clothsim/dynamics/internal_damping.h"

#include "clothsim/dynamics/bend_rotation.h"
#include "clothsim/dynamics/bends.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/dynamics/curved_bends.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/dynamics/triangle_forces.h"

namespace clothsim {
namespace {

double length_of(const Points& positions, int a, int b) {
  return (positions.row(b) - positions.row(a)).norm();
}

/// Sets value(length_of) for each spring, where length_of(x) is its length at positions x, or the
/// square for the edges of a mesh.
template <typename Value>
void take_lengths(const Cloth& cloth, Past& past, const Value& value) {
  for_each_spring(cloth, [&](const SpringRun&, int a, int b) {
    if (cloth.is_mesh()) {
      past.squares.push_back(
          value([&](const Points& x) { return (x.row(b) - x.row(a)).squaredNorm(); }));
    } else {
      past.lengths.push_back(value([&](const Points& x) { return length_of(x, a, b); }));
    }
  });
}

/// The same for the strain of each cell.
template <typename Value>
void take_strains(const Cloth& cloth, Past& past, const Value& value) {
  for_each_cell(cloth, [&](const Cell& cell) {
    past.strains.push_back(value([&](const Points& x) { return cell.value(x); }));
  });
}

/// Change of a triangle's squared edges since the past [m^2].
Vector3 change_of(const Cloth& cloth, std::size_t triangle, const Past& past,
                  const Points& positions) {
  Vector3 change = squared_edges(cloth.triangles[triangle], positions);
  for (std::size_t k = 0; k < 3; ++k) {
    const int edge = cloth.triangle_fabric->triangles[triangle].edges[k];
    change[static_cast<Eigen::Index>(k)] -= past.squares[static_cast<std::size_t>(edge)];
  }
  return change;
}

void add_membrane_gradient(const Cloth& cloth, const Past& past, const Points& positions,
                           Points& gradient) {
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const Vector3 pulls =
        cloth.internal_damping_at(cloth.triangles[t][0])[0] / past.time *
        (cloth.triangle_fabric->triangles[t].stretch * change_of(cloth, t, past, positions));
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = cloth.triangles[t][k], b = cloth.triangles[t][(k + 1) % 3];
      const Eigen::RowVector3d pull =
          2 * pulls[static_cast<Eigen::Index>(k)] * (positions.row(b) - positions.row(a));
      gradient.row(a) -= pull;
      gradient.row(b) += pull;
    }
  }
}

}  // namespace

Past past_of(const Cloth& cloth, const State& state, double h) {
  if (!is_damped(cloth)) return {};
  const Points& positions = state.positions;
  Past past{h, {}, {}, {}, positions, positions + h / 2 * state.velocities};
  const auto value = [&](const auto& at) { return at(positions); };
  take_lengths(cloth, past, value);
  take_strains(cloth, past, value);
  return past;
}

Past past_of(const Cloth& cloth, const Points& positions, const Points& last, double h) {
  if (!is_damped(cloth)) return {};
  Past past{2 * h / 3, {}, {}, {}, (4 * positions - last) / 3, 2 * positions - last};
  const auto value = [&](const auto& at) { return (4 * at(positions) - at(last)) / 3; };
  take_lengths(cloth, past, value);
  take_strains(cloth, past, value);
  return past;
}

double damping_potential(const Cloth& cloth, const Past& past, const Points& positions) {
  if (past.empty()) return 0;
  double of_springs = 0;
  std::size_t id = 0;
  if (!cloth.is_mesh()) {
    for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
      const double change = length_of(positions, a, b) - past.lengths[id++];
      of_springs += cloth.internal_damping[0] * run.stiffness * change * change / 2;
    });
  } else {
    for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
      const Vector3 change = change_of(cloth, t, past, positions);
      of_springs += cloth.internal_damping_at(cloth.triangles[t][0])[0] *
                    change.dot(cloth.triangle_fabric->triangles[t].stretch * change) / 2;
    }
  }
  id = 0;
  for_each_cell(cloth, [&](const Cell& cell) {
    const double change = cell.value(positions) - past.strains[id++];
    of_springs += cloth.internal_damping[0] * cell.stiffness * change * change / 2;
  });
  double of_bends = 0;
  if (has_damped_bends(cloth)) {
    const Points change = positions - past.points;
    Points relative;
    remove_rotation(cloth, past.frame, change, relative);
    for_each_bend(cloth, [&](const auto& bend) {
      const Vector3 rate = bend.rate(past.frame, relative);
      of_bends += cloth.internal_damping_at(bend.points[0])[1] * bend.stiffness *
                  bend.rate(past.frame, change).dot(rate) / 2;
    });
  }
  return (of_springs + of_bends) / past.time;
}

void add_damping_gradient(const Cloth& cloth, const Past& past, const Points& positions,
                          Points& gradient) {
  if (past.empty()) return;
  const auto add = [&](int a, int b, const Eigen::RowVector3d& pull) {
    gradient.row(a) -= pull;
    gradient.row(b) += pull;
  };
  std::size_t id = 0;
  if (cloth.is_mesh()) {
    add_membrane_gradient(cloth, past, positions, gradient);
  } else {
    for_each_spring(cloth, [&](const SpringRun& run, int a, int b) {
      const Eigen::RowVector3d d = positions.row(b) - positions.row(a);
      const double length = d.norm();
      const double change = length - past.lengths[id++];
      if (length > 0) {
        add(a, b, cloth.internal_damping[0] / past.time * run.stiffness * change / length * d);
      }
    });
  }
  id = 0;
  for_each_cell(cloth, [&](const Cell& cell) {
    const double change = cell.value(positions) - past.strains[id++];
    cell.add_gradient(positions, cloth.internal_damping[0] / past.time * cell.stiffness * change,
                      gradient);
  });
  if (!has_damped_bends(cloth)) return;
  Points relative;
  remove_rotation(cloth, past.frame, positions - past.points, relative);
  for_each_bent_pair(cloth, [&](double w, int a, int b) {
    const double tau = cloth.internal_damping_at(a)[1];
    add(a, b, tau / past.time * w * (relative.row(b) - relative.row(a)));
  });
  if (!cloth.is_mesh() || cloth.triangle_fabric->curved.empty()) return;
  Points forces = Points::Zero(gradient.rows(), 3);
  add_curved_damping(*cloth.triangle_fabric, 1 / past.time, PointView(past.frame),
                     PointView(relative), {}, {}, forces);
  gradient -= forces;
}

}  // namespace clothsim
