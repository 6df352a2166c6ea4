// The common direction in which cloth leaves a collider: where it is deep inside, or where the
// collider was put on it.

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/model/cloth.h"

namespace clothsim {
namespace {

/// Cloth that lies less deep in a collider leaves it by the nearest surface everywhere [m].
constexpr double put_on_depth = 10 * penetration_slop;

/// Cloth leaves a collider that was put on it at the speed of its depth / put_on_time [s]. In half
/// of the time stiff cloth is thrown twice as fast.
constexpr double put_on_time = 0.1;

/// The least such speed [m/s]: the way out may be longer than the depth.
constexpr double least_leaving_speed = 0.3;

/// Least length of the sum of a piece's normals, by their areas: a piece that is more folded has no
/// common direction.
constexpr double least_coherence = 0.5;

/// Cosine of the angle between a direction and the normal of a surface that blocks it.
constexpr double blocking = -0.5;

bool is_any(const Corners& corners, const std::vector<char>& marked) {
  return std::any_of(corners.begin(), corners.end(),
                     [&](int i) { return marked[static_cast<std::size_t>(i)] != 0; });
}

/// Sum of the normals of the triangles with a point that is `marked`, times their areas [m^2], and
/// the sum of these areas.
std::pair<Vector3, double> normals_of(const Cloth& cloth, const Points& points,
                                      const std::vector<char>& marked) {
  Vector3 sum(0, 0, 0);
  double areas = 0;
  for (const Corners& c : cloth.triangles) {
    if (!is_any(c, marked)) continue;
    const Vector3 a = row(points, c[0]);
    const Vector3 normal = (row(points, c[1]) - a).cross(row(points, c[2]) - a) / 2;
    sum += normal;
    areas += normal.norm();
  }
  return {sum, areas};
}

/// Direction in which a piece of cloth with the points `held` leaves a solid about the origin:
/// normal to the piece, away from the predicted middle of the piece. On its way out it does not
/// turn back as the middle passes through. `displacements`: displacements of points in a step of h
/// [s].
Vector3 direction_out(const Cloth& cloth, const Points& points, const Points& displacements,
                      double h, const std::vector<char>& held) {
  Vector3 normal = normals_of(cloth, points, held).first, middle(0, 0, 0);
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!held[static_cast<std::size_t>(i)]) continue;
    middle += row(points, i) + recovery_time / h * row(displacements, i);
  }
  if (normal.norm() == 0) normal = middle;
  if (normal.norm() == 0) normal = Vector3::UnitZ();
  return (normal.dot(middle) < 0 ? -1 : 1) * normal.normalized();
}

/// Normal to a piece of cloth, to the side where most of its points are nearest to the surface;
/// empty for a piece that is folded, in which no direction is the way out of all.
std::optional<Vector3> normal_out(const Shape& shape, const Cloth& cloth, const Points& points,
                                  const std::vector<char>& marked) {
  const auto [normals, areas] = normals_of(cloth, points, marked);
  if (!(normals.norm() > least_coherence * areas)) return std::nullopt;
  Vector3 nearest(0, 0, 0);
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!marked[static_cast<std::size_t>(i)]) continue;
    nearest += signed_distance(shape, row(points, i), row(points, i)).normal;
  }
  return (normals.dot(nearest) < 0 ? -1 : 1) * normals.normalized();
}

}  // namespace

bool ColliderContacts::is_left_together(const Penetration& penetration,
                                        const MovingCollider& collider, const Cloth& cloth,
                                        const ContactStep& step) {
  const double safe = safe_depth(collider.shape());
  if (penetration.depth() > safe) return true;
  const ColliderCache& s = cache(penetration.collider);
  if (!s.is_put_on || std::isinf(safe) || penetration.depth() <= put_on_depth) return false;
  // Cloth that is held inside cannot leave.
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] > 0) continue;
    const Vector3 x = to_local(collider.previous(), row(step.start, i));
    if (signed_distance(collider.shape(), x, x).value < 0) return false;
  }
  return true;
}

bool ColliderContacts::is_blocked(const std::vector<MovingCollider>& colliders, std::size_t left,
                                  const Points& positions, const Vector3& direction) const {
  const std::vector<char>& leaves = caches_[left].leaves;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (k == left || !colliders[k].enabled() || caches_[k].near.empty()) continue;
    const Pose& pose = colliders[k].pose();
    for (Eigen::Index i = 0; i < positions.rows(); ++i) {
      if (!leaves[static_cast<std::size_t>(i)]) continue;
      const Vector3 x = to_local(pose, row(positions, static_cast<int>(i)));
      const Distance d = signed_distance(colliders[k].shape(), x, x);
      const bool touches = d.value < 1.5 * caches_[k].keeps;
      if (touches && (pose.orientation * d.normal).dot(direction) < blocking) return true;
    }
  }
  return false;
}

void ColliderContacts::leave_together(const Penetration& penetration,
                                      const std::vector<MovingCollider>& colliders,
                                      const Cloth& cloth, const ContactStep& step,
                                      const Points& positions) {
  const auto number = static_cast<std::size_t>(penetration.collider);
  const MovingCollider& collider = colliders[number];
  ColliderCache& s = cache(penetration.collider);
  s.leaves.assign(static_cast<std::size_t>(cloth.num_points()), 0);
  for (const auto& point : penetration.points) s.leaves[static_cast<std::size_t>(point.first)] = 1;
  for (const PenetratingFace& face : penetration.faces) {
    for (const int i : cloth.triangles[static_cast<std::size_t>(face.triangle)]) {
      s.leaves[static_cast<std::size_t>(i)] = 1;
    }
  }
  local_.place(collider, cloth, step.start, positions, s.mesh);
  const Eigen::Quaterniond& turn = collider.pose().orientation;
  if (s.is_put_on && !s.put_on_direction) {
    const auto normal = normal_out(collider.shape(), cloth, local_.from, s.leaves);
    if (normal) s.put_on_direction = turn * *normal;
  }
  if (s.put_on_direction) {
    const Vector3 back = -*s.put_on_direction;
    const bool turns_back = is_blocked(colliders, number, positions, *s.put_on_direction) &&
                            !is_blocked(colliders, number, positions, back);
    if (turns_back) s.put_on_direction = back;
    s.exit_direction = turn.conjugate() * *s.put_on_direction;
    s.leaving_speed =
        std::clamp(penetration.depth() / put_on_time, least_leaving_speed, recovery_speed);
  } else if (penetration.depth() > safe_depth(collider.shape())) {
    s.exit_direction = direction_out(cloth, local_.from, local_.to - local_.from, step.h, s.leaves);
    s.leaving_speed = recovery_speed;
  } else {
    return;
  }
  s.is_close = true;

  // All its points leave that way, those outside too.
  const Vector3 direction = turn * *s.exit_direction;
  const bool is_body = step.bodies && step.bodies->is_body(number);
  const double speed = is_body ? 0 : step.recovery_factor * s.leaving_speed;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!s.leaves[static_cast<std::size_t>(i)] || cloth.inv_mass[i] == 0) continue;
    s.slots.put(i, direction, collider.velocity_at(row(positions, i)), speed);
  }
  for (const PenetratingFace& face : penetration.faces) {
    faces_.redirect(face.contact, direction, speed);
  }
}

}  // namespace clothsim
