// Positions of the cloth that contacts of colliders correct at a step's end.

#include <algorithm>

#include "clothsim/constraints/collider_contacts.h"

namespace clothsim {
namespace {

/// Depth of a triangle at which it is projected between detections, beyond that in which
/// projections leave it and rounding.
constexpr double sunk_depth = 1.01 * penetration_slop;

/// Ends motion that a projection has undone: a point that it has moved from `before` keeps no
/// velocity against that displacement beyond its motion from `start` in the step of h [s].
void end_undone_motion(double h, const Points& start, const Points& before, State& state) {
  for (Eigen::Index i = 0; i < before.rows(); ++i) {
    const Eigen::RowVector3d displacement = state.positions.row(i) - before.row(i);
    if (displacement.isZero(0)) continue;
    const Eigen::RowVector3d direction = displacement.normalized();
    const double moved = direction.dot(state.positions.row(i) - start.row(i));
    const double lacking = std::min(0.0, moved / h) - direction.dot(state.velocities.row(i));
    if (lacking > 0) state.velocities.row(i) += lacking * direction;
  }
}

}  // namespace

void ColliderContacts::project_positions(const std::vector<MovingCollider>& colliders,
                                         const Cloth& cloth, const Points& start, State& state) {
  // One collider may move points back into another one.
  const bool may_conflict = recovers_ && colliders.size() > 1;
  if (may_conflict) unprojected_ = state.positions;
  pinches_.project_positions(start, state.positions);
  motion_bound_.update(start, state.positions);
  project_all(colliders, cloth, start, state.positions);
  if (may_conflict) end_undone_motion(h_, start, unprojected_, state);
}

void ColliderContacts::project_near(const std::vector<MovingCollider>& colliders,
                                    const Cloth& cloth, const Points& start, Points& positions) {
  const double in_step = longest_displacement(start, positions);
  motion_bound_.add(in_step);
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    ColliderCache& s = caches_[k];
    if (!s.near.empty()) {
      const ContactSlots::Detector detector(colliders[k], cloth, s.keeps,
                                            s.query(colliders[k], cloth, 2 * s.keeps));
      double longest = 0;
      for (const Span& span : s.near) {
        const double* free = &cloth.inv_mass[ContactSlots::first_of(span.begin)];
        double min_distances[Span::longest];
        longest = std::max(longest, ContactSlots::project_positions(span, detector, free, start,
                                                                    positions, min_distances));
      }
      moved_out(k, longest);
    }
    if (s.has_faces && has_sunk(k, colliders[k], cloth, in_step, positions)) {
      moved_out(k, project_faces(k, colliders[k], cloth, start, positions));
    }
  }
  motion_bound_.end(positions);
}

bool ColliderContacts::has_sunk(std::size_t number, const MovingCollider& collider,
                                const Cloth& cloth, double in_step, const Points& positions) const {
  if (in_step + caches_[number].moved < penetration_slop) return false;
  bool result = false;
  faces_.for_each_on(static_cast<int>(number), [&](int triangle, const CornerWeights& weights,
                                                   const Vector3&, double) {
    if (result) return;
    const Corners& corners = cloth.triangles[static_cast<std::size_t>(triangle)];
    Triangle t = triangle_of(positions, corners);
    for (Vector3& corner : t) corner = to_local(collider.pose(), corner);
    t = raised_at_held(collider.shape(), cloth, corners, t);
    const Vector3 x = weights[0] * t[0] + weights[1] * t[1] + weights[2] * t[2];
    result = signed_distance(collider.shape(), x, x).value + leeway(cloth, corners, t, weights) <
             cloth.offset_at(corners[0]) - sunk_depth;
  });
  return result;
}

void ColliderContacts::moved_out(std::size_t collider, double distance) {
  motion_bound_.add(distance);
  // It may have been moved into another one.
  for (std::size_t other = 0; other < collider && distance >= penetration_slop; ++other) {
    caches_[other].is_clear = false;
  }
}

void ColliderContacts::project_again(const std::vector<MovingCollider>& colliders,
                                     const Cloth& cloth, const Points& start, Points& positions) {
  motion_bound_.begin(start, positions);
  project_all(colliders, cloth, start, positions);
}

void ColliderContacts::project_all(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                                   const Points& start, Points& positions) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!colliders[k].enabled()) continue;
    moved_out(k, project_at(k, colliders[k], cloth, start, positions));
  }
  motion_bound_.end(positions);
}

double ColliderContacts::project_at(std::size_t number, const MovingCollider& collider,
                                    const Cloth& cloth, const Points& start, Points& positions) {
  ColliderCache& s = caches_[number];
  const Clearance keeps = clearance(collider.shape(), cloth, stretch_, has_pinched_);
  s.sleep_bounds.find_near(motion_bound_.total(), 2 * keeps.points, s.inside);
  s.is_close = s.is_close || motion_bound_.in_step() + s.moved > safe_depth(collider.shape());
  s.is_clear = pinches_.count() == 0;
  s.exit.lags = false;
  const ContactSlots::Detector detector(collider, cloth, keeps.points,
                                        s.query(collider, cloth, 2 * keeps.points));
  double longest = 0;
  for (const Span& span : s.inside) {
    const double* can_move = &cloth.inv_mass[ContactSlots::first_of(span.begin)];
    double free[Span::longest * ContactSlots::block], min_distances[Span::longest];
    if (s.is_close || pinches_.count() > 0) {
      const double distance = project_closely(s, span, detector, cloth, start, positions, free);
      longest = std::max(longest, distance);
      can_move = free;
    }
    const double distance =
        ContactSlots::project_positions(span, detector, can_move, start, positions, min_distances);
    longest = std::max(longest, distance);
    for (int b = span.begin; b < span.end; ++b) {
      const double nearest = min_distances[b - span.begin];
      if (!s.slots.has_active(b)) s.sleep_bounds.keep(b, nearest, motion_bound_.total());
      // A pin in the solid may be let go.
      if (nearest < penetration_slop && ContactSlots::has_pin(b, cloth)) s.is_clear = false;
    }
  }
  if (is_near_faces(s, keeps, keeps.points)) {
    longest = std::max(longest, project_faces(number, collider, cloth, start, positions));
  }
  return longest;
}

double ColliderContacts::project_faces(std::size_t number, const MovingCollider& collider,
                                       const Cloth& cloth, const Points& start, Points& positions) {
  ColliderCache& s = caches_[number];
  std::vector<char> held = pinches_.held();
  if (s.exit_direction) {
    held.resize(s.leaves.size());
    std::transform(held.begin(), held.end(), s.leaves.begin(), held.begin(),
                   [](char a, char b) { return a | b; });
  }
  local_.place(collider, cloth, start, positions, s.mesh);
  std::vector<char> moved(static_cast<std::size_t>(cloth.num_points()), 0);
  faces_.project_positions(static_cast<int>(number), collider, cloth, recovery_factor_ * h_, held,
                           local_, moved);
  double longest = 0;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!moved[static_cast<std::size_t>(i)]) continue;
    const Vector3 to = to_world(collider.pose(), row(local_.to, i));
    longest = std::max(longest, (to - row(positions, i)).norm());
    positions.row(i) = to.transpose();
    s.is_clear = s.is_clear && local_.distance[i] >= penetration_slop;
  }
  return longest;
}

}  // namespace clothsim
