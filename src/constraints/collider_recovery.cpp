// Rare cases of contact, point by point: steps that may have taken a point through a shape, points
// in a shape, and pairs of shapes that leave no room.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "clothsim/constraints/collider_contacts.h"

namespace clothsim {
namespace {

/// Entry of a point that may have passed through the shape in one step: its distance and normal as
/// it came in, and its place at the step's end, both in the collider's own frame at that end.
struct Entry {
  Distance at;
  Vector3 end;
};

/// Moves a point from its entry along the surface by the rest of its path, until that bends away by
/// its safe depth or leads in again. A point that stopped would be moved against its velocity by
/// friction, and gain energy; one that went far beyond would take the cloth around thin solids.
Entry slide(const Shape& shape, const Vector3& at, const Vector3& to, double offset) {
  const Distance d = signed_distance(shape, at, at);
  const Vector3 left = to - at;
  // Off the surface by more than rounding, which would lead in.
  const double lift = std::sqrt(std::numeric_limits<double>::epsilon()) * left.norm();
  const Vector3 along = left + (lift - d.normal.dot(left)) * d.normal;
  const double bent = signed_distance(shape, at + along, at).value - d.value;
  const Vector3 end = at + std::min(1.0, safe_depth(shape) / std::max(bent, lift)) * along;
  return {d, entry_point(shape, at, end, offset).value_or(end)};
}

/// Empty where it has not come in.
std::optional<Entry> swept_entry(const MovingCollider& collider, const Vector3& from,
                                 const Vector3& to, double offset) {
  const double depth = safe_depth(collider.shape());
  const double turn = collider.last_turn();
  if ((to - from).squaredNorm() <= depth * depth) return std::nullopt;

  // In a turning frame the path is curved: pieces that deviate from their chords by less than
  // matters.
  const Vector3 start = to_world(collider.previous(), from), end = to_world(collider.pose(), to);
  const double radius = std::max(from.norm(), to.norm());
  const int pieces =
      std::max(1, static_cast<int>(std::ceil(turn * std::sqrt(radius / (8 * depth)))));
  Vector3 last = from;
  for (int i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    const Vector3 next = to_local(collider.pose_at(share), start + share * (end - start));
    const auto entry = entry_point(collider.shape(), last, next, offset);
    if (entry) return slide(collider.shape(), *entry, next, offset);
    last = next;
  }
  return std::nullopt;
}

/// Distance of a point from the surface at the step's start, 0 where it was outside [m].
double depth_before(const Shape& shape, const Vector3& from) {
  return std::min(0.0, signed_distance(shape, from, from).value);
}

}  // namespace

double ColliderContacts::Penetration::depth() const {
  double deepest = 0;
  for (const auto& point : points) deepest = std::max(deepest, point.second);
  for (const PenetratingFace& face : faces) deepest = std::max(deepest, face.depth);
  return deepest;
}

void ColliderContacts::look_closely(ColliderCache& s, int i, const ContactSlots::Detector& detector,
                                    const ContactStep& step, State& state,
                                    Penetration& penetration) {
  const MovingCollider& collider = detector.collider;
  const Shape& shape = collider.shape();
  const Vector3 from = to_local(collider.previous(), row(step.start, i));
  Vector3 to = to_local(collider.pose(), row(state.positions, i));

  // A point that may have passed through moves on along the surface from its entry.
  const double offset = detector.offset_at(i);
  const auto entry = swept_entry(collider, from, to, offset);
  if (entry) {
    to = entry->end;
    state.positions.row(i) = to_world(collider.pose(), to).transpose();
  }
  const Distance d = entry ? entry->at : signed_distance(shape, to, from);
  const double depth = d.value < 0 ? -depth_before(shape, from) : 0;
  if (!entry && depth == 0) return;
  if (s.has_faces) {
    local_.to.row(i) = to.transpose();
    local_.distance[i] = entry ? signed_distance(shape, to, from).value : d.value;
  }

  // The gap at the step's end if the point only followed the surface.
  const Vector3 normal = detector.frame.turn * d.normal;
  const Vector3 surface_velocity = collider.velocity_at(row(state.positions, i));
  const double rate = normal.dot(row(state.velocities, i) - surface_velocity);
  const double drift = normal.dot(row(step.drifted, i) - surface_velocity);
  const double gap = d.value - offset - step.displacement_factor * step.h * drift;
  const double target_velocity = entry ? 0 : -std::max(gap, 0.0) / step.h;
  // The impulse that ends its approach will move it on to there.
  if (entry && drift < 0)
    state.positions.row(i) += step.displacement_factor * step.h * drift * normal.transpose();

  if (!s.slots.has_impulse(i) && rate >= target_velocity && gap > 0) {
    if (s.slots.touches(i)) s.slots.remove(i);
    return;
  }
  if (depth > 0) penetration.points.emplace_back(i, depth);
  // A rigid body is not pushed off: the projection alone moves the point out.
  const bool is_body =
      step.bodies && step.bodies->is_body(static_cast<std::size_t>(penetration.collider));
  const double recovery = is_body ? 0 : step.recovery_factor * exit_speed(depth);
  s.slots.put(i, normal, surface_velocity, target_velocity + recovery);
}

ColliderContacts::Touched ColliderContacts::touched_by(int number, const Cloth& cloth,
                                                       const Points& positions) {
  Touched result;
  const ContactSlots& slots = cache(number).slots;
  slots.for_each_touching_both(slots, [&](int i) {
    result.normals.extend(slots.normal(i));
    result.places.extend(row(positions, i));
  });
  faces_.for_each_on(number, [&](int triangle, const auto&, const Vector3& normal, double) {
    result.normals.extend(normal);
    for (const int i : cloth.triangles[static_cast<std::size_t>(triangle)]) {
      result.places.extend(row(positions, i));
    }
  });
  return result;
}

ContactManifold ColliderContacts::manifold_of(int number, const MovingCollider& collider,
                                              const Cloth& cloth) {
  ContactManifold manifold{
      collider, clearance(collider.shape(), cloth, stretch_, has_pinched_).points, {}};
  const ContactSlots& slots = cache(number).slots;
  slots.for_each_touching_both(slots, [&](int i) {
    manifold.contact_points.push_back(
        {ContactPoint::no_triangle, {i, i, i}, {1, 0, 0}, slots.normal(i), 0, cloth.nearer_by(i)});
  });
  faces_.for_each_on(
      number, [&](int triangle, const auto& weights, const Vector3& normal, double distance) {
        const Corners& corners = cloth.triangles[static_cast<std::size_t>(triangle)];
        manifold.contact_points.push_back(
            {triangle, corners, weights, normal, distance, cloth.nearer_by(corners[0])});
      });
  return manifold;
}

void ColliderContacts::pinch(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                             const ContactStep& step,
                             const std::vector<Penetration>& penetrations) {
  std::vector<Touched> touched;
  for (const Penetration& c : penetrations) {
    touched.push_back(touched_by(c.collider, cloth, step.start));
  }
  const auto can_hold = [&](const Touched& a, const Touched& b) {
    // Points of round shapes may stand off a little more than the offset.
    const double max_distance = 2 * Stacks::max_layer_height(cloth, cloth.offset);
    return can_face(a.normals, b.normals) && a.places.exteriorDistance(b.places) <= max_distance;
  };
  const auto is_body = [&](std::size_t k) {
    return step.bodies && step.bodies->is_body(static_cast<std::size_t>(penetrations[k].collider));
  };
  std::map<std::size_t, ContactManifold> manifolds;  // of those that face another collider
  const auto is_left = [&](std::size_t k) {
    const Penetration& c = penetrations[k];
    return cache(c.collider).exit.is_together() && c.depth() > 0;
  };
  const auto manifold = [&](std::size_t k) -> const ContactManifold& {
    const int number = penetrations[k].collider;
    const MovingCollider& collider = colliders[static_cast<std::size_t>(number)];
    if (manifolds.count(k) == 0) manifolds.emplace(k, manifold_of(number, collider, cloth));
    return manifolds.at(k);
  };
  for (std::size_t l = 1; l < penetrations.size(); ++l) {
    for (std::size_t k = l; k-- > 0;) {
      if (is_body(k) || is_body(l) || !can_hold(touched[k], touched[l])) continue;
      if (is_left(k) || is_left(l)) continue;
      stacks_.pinch(manifold(k), manifold(l), cloth, step.start, step.h, step.touches, pinches_);
    }
  }
}

void ColliderContacts::find_pinched(const std::vector<MovingCollider>& colliders,
                                    const Cloth& cloth, const ContactStep& step,
                                    std::vector<Penetration>& penetrations) {
  pinch(colliders, cloth, step, penetrations);
  if (pinches_.count() == 0) return;

  // No other contact acts on these points.
  for (ColliderCache& s : caches_) {
    s.slots.for_each_touching_both(s.slots, [&](int point) {
      if (pinches_.holds(point)) s.slots.remove(point);
    });
  }
  faces_.release_pinched(pinches_, colliders, cloth, step);
  const auto drop = [](auto& list, const auto& is_held) {
    list.erase(std::remove_if(list.begin(), list.end(), is_held), list.end());
  };
  for (Penetration& c : penetrations) {
    drop(c.points, [&](const auto& point) { return pinches_.holds(point.first); });
    drop(c.faces, [&](const PenetratingFace& f) {
      return pinches_.holds_any(cloth.triangles[static_cast<std::size_t>(f.triangle)]);
    });
  }
}

double ColliderContacts::project_closely(ColliderCache& s, const Span& span,
                                         const ContactSlots::Detector& detector, const Cloth& cloth,
                                         const Points& start, Points& positions, double* free) {
  double longest = 0;
  const int first = ContactSlots::first_of(span.begin);
  for (int i = first; i < ContactSlots::end_of(span.end - 1, cloth); ++i) {
    double& is_free = free[i - first];
    is_free = pinches_.holds(i) ? 0 : cloth.inv_mass[i];
    if (!s.is_close || is_free == 0) continue;
    const auto distance = project_closely(s, i, detector, start, positions);
    if (!distance) continue;
    longest = std::max(longest, *distance);
    is_free = 0;
  }
  return longest;
}

std::optional<double> ColliderContacts::project_closely(ColliderCache& s, int i,
                                                        const ContactSlots::Detector& detector,
                                                        const Points& start, Points& positions) {
  const MovingCollider& collider = detector.collider;
  const Vector3 from = to_local(collider.previous(), row(start, i));
  Vector3 to = to_local(collider.pose(), row(positions, i));
  const double offset = detector.offset_at(i);
  const auto entry = swept_entry(collider, from, to, offset);
  if (entry) to = entry->end;
  const Distance d = signed_distance(collider.shape(), to, from);
  if (s.exit_direction && s.leaves[static_cast<std::size_t>(i)]) {
    const double advance = s.exit_direction->dot(to - from);
    to += std::max(0.0, recovery_factor_ * s.exit_speed * h_ - advance) * *s.exit_direction;
  } else {
    const double before = signed_distance(collider.shape(), from, from).value;
    const bool leaves = before < 0 || s.exit.is_together();
    if (!entry && !leaves) return std::nullopt;
    const double speed = s.exit.is_together() ? s.exit.velocity.norm() : recovery_speed;
    const double required =
        leaves ? required_distance(before, offset, recovery_factor_ * speed * h_) : offset;
    to += std::max(0.0, required - d.value) * d.normal;
  }
  const double ends = signed_distance(collider.shape(), to, from).value;
  s.is_clear = s.is_clear && ends >= penetration_slop;
  s.exit.lags = s.exit.lags || (s.exit.is_together() && ends < offset - penetration_slop);
  const Vector3 end = to_world(collider.pose(), to);
  const double distance = (end - row(positions, i)).norm();
  positions.row(i) = end.transpose();
  return distance;
}

}  // namespace clothsim
