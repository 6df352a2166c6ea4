#include "clothsim/constraints/local_cloth.h"

#include <algorithm>

#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/springs.h"
#include "clothsim/model/cloth_spec.h"
#include "clothsim/shapes/signed_distances.h"

namespace clothsim {
namespace {

/// Largest extra distance at which points keep triangles off a shape, of the longest edge: an edge
/// e needs e^2 / (6 r) on a sphere of radius r, so that it may be 3/8 of r.
constexpr double highest_lift = 1.0 / 16;

/// Stretch beyond the strain limit that springs may have for a while.
constexpr double usual_excess = 0.05;

void move_into(const Pose& pose, const Points& points, Points& local) {
  const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
  local.noalias() = (points.rowwise() - pose.position.transpose()) * turn;
}

}  // namespace

void MeshMemory::fit(const MovingCollider& collider, const Cloth& cloth) {
  const bool is_mesh = std::holds_alternative<MeshShape>(collider.shape());
  points.resize(is_mesh ? static_cast<std::size_t>(cloth.num_points()) : 0);
  triangles.resize(is_mesh ? cloth.triangles.size() : 0);
}

void LocalCloth::place(const MovingCollider& collider, const Cloth& cloth, const Points& start,
                       const Points& end, MeshMemory& memory) {
  mesh = &memory;
  mesh->fit(collider, cloth);
  move_into(collider.previous(), start, from);
  move_into(collider.pose(), end, to);
  longest = longest_row(to - from) + collider.last_turn() * longest_row(to);
  distance.resize(to.rows());
  Points normals(to.rows(), 3);
  signed_distances(collider.shape(), Frame(collider.pose()), run_from(end, 0),
                   Frame(collider.previous()), run_from(start, 0), static_cast<int>(to.rows()),
                   {2 * surface_offset, mesh->points.data()}, distance.data(),
                   run_from(normals, 0));
}

void LocalCloth::place_middle(const MovingCollider& collider, const ContactStep& step,
                              const Points& end) {
  const Eigen::Matrix3d turn = collider.pose().orientation.toRotationMatrix();
  middle = step.drifted - collider.velocities_at(end);
  middle = to - step.displacement_factor * step.h * middle * turn;
}

void LocalCloth::place_points(const std::vector<int>& points, const MovingCollider& collider,
                              const ContactStep& step, const Points& end, double bound,
                              MeshMemory& memory) {
  mesh = &memory;
  const Frame before(collider.previous()), now(collider.pose());
  for (const int i : points) {
    const Vector3 x = row(end, i), drift = row(step.drifted, i) - collider.velocity_at(x);
    const Vector3 start = before.turn.transpose() * (row(step.start, i) - before.origin);
    const Vector3 at_end = now.turn.transpose() * (x - now.origin);
    const Vector3 to_middle = step.displacement_factor * step.h * (now.turn.transpose() * drift);
    from.row(i) = start;
    to.row(i) = at_end;
    middle.row(i) = at_end - to_middle;
  }
  longest = bound;
}

FaceQuery LocalCloth::query(std::size_t triangle, const Corners& corners) const {
  if (mesh->triangles.empty()) return {};
  FaceQuery result{&mesh->triangles[triangle]};
  for (std::size_t k = 0; k < 3; ++k) {
    result.neighbourhoods[k] = &mesh->points[static_cast<std::size_t>(corners[k])];
  }
  return result;
}

double longest_edge_within_limit(const Cloth& cloth, double stretch) {
  if (cloth.triangles.empty()) return infinity;
  // A cloth without limit gets the usual one: the distance of points changes with their springs
  // only where these stretch further.
  static const double usual_limit = Material().strain_limit.value();
  double limit = cloth.strain_limit.value_or(usual_limit);
  for (const auto& of_cloth : cloth.strain_limits) {
    limit = std::max(limit, of_cloth.value_or(usual_limit));
  }
  const double longest = 1 + std::max(limit + usual_excess, stretch);
  if (cloth.is_mesh()) return longest * longest_rest_length(cloth);
  // All triangles of a grid are alike. Without shear springs only its sides hold a cell.
  const auto& [a, b, c] = cloth.triangles.front();
  const auto length = [&](int i, int j) {
    return (cloth.rest_positions.row(j) - cloth.rest_positions.row(i)).norm();
  };
  const bool sheared = std::any_of(cloth.springs.begin(), cloth.springs.end(), [](const auto& run) {
    return run.family == SpringFamily::shear;
  });
  const double edge =
      sheared ? std::max({length(a, b), length(b, c), length(c, a)}) : length(a, b) + length(b, c);
  return longest * edge;
}

Clearance clearance(const Shape& shape, const Cloth& cloth, double stretch, bool pinched) {
  if (cloth.triangles.empty()) return {cloth.offset, false};
  const double edge = longest_edge_within_limit(cloth, stretch);
  // The lift falls as the offset grows.
  const double nearer = cloth.offset - cloth.min_offset();
  const double lifted = corner_distance(shape, edge, cloth.offset - nearer) + nearer;
  if (lifted - cloth.offset <= (pinched ? 0 : highest_lift * edge)) return {lifted, false};
  return {cloth.offset, true};
}

}  // namespace clothsim
