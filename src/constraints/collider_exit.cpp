// The common direction in which cloth leaves a collider: where it is deep inside, or where the
// collider was put on it.

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/constraints/corners.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/cloth.h"

namespace clothsim {
namespace {

/// Cloth that lies less deep in a collider leaves it by the nearest surface everywhere [m].
constexpr double put_on_depth = 10 * penetration_slop;

/// Time [s] in which cloth leaves a collider that was put on it, at recovery_speed at most. With
/// 0.3 s a ball in a floor would throw stiff cloth half as fast, but cloth would be out too late
/// after a jump.
constexpr double put_on_time = 0.2;

/// After this time [s] cloth that is held inside leaves by the nearest surfaces.
constexpr double longest_exit = 10 * put_on_time;

/// Relative error of a speed that was computed from a velocity.
constexpr double rounding = 1e-9;

/// Most steps of a search along a straight line.
constexpr int most_steps = 100;

/// Least ratio of the length of the sum of a piece's area vectors to its area: a piece that is more
/// folded has no common direction.
constexpr double least_coherence = 0.5;

/// Least mean of the cosines between the normal of cloth that lies in a thin shape and the normals
/// of the nearest surfaces: a shape that pierces the cloth has less.
constexpr double least_along = 0.95;

/// Cloth within this multiple of the distance that contact keeps counts as touching.
constexpr double touching = 1.5;

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

/// The normal to a piece of cloth that is in a collider.
struct PieceNormal {
  Vector3 out;      // to the side where most points are nearest to the surface, unit
  bool is_pierced;  // by a shape that is thinner than the cells
};

/// Empty for a piece that is folded, in which no direction is the way out of all. `edge`: size of
/// the cells [m].
std::optional<PieceNormal> normal_to(const Shape& shape, const Cloth& cloth, const Points& points,
                                     const std::vector<char>& marked, double edge) {
  const auto [normals, areas] = normals_of(cloth, points, marked);
  if (!(normals.norm() > least_coherence * areas)) return std::nullopt;
  const Vector3 normal = normals.normalized();
  double out = 0, along = 0;
  int count = 0;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!marked[static_cast<std::size_t>(i)]) continue;
    const Vector3 nearest = signed_distance(shape, row(points, i), row(points, i)).normal;
    out += nearest.dot(normal);
    along += std::abs(nearest.dot(normal));
    ++count;
  }
  const double thickness = 4 * safe_depth(shape);
  const bool pierced = thickness < edge && along < least_along * count;
  return PieceNormal{out < 0 ? -normal : normal, pierced};
}

/// Is a point that is held in the shape? `points`: in its frame [m].
bool holds_any(const Shape& shape, const Cloth& cloth, const Points& points) {
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] > 0) continue;
    if (signed_distance(shape, row(points, i), row(points, i)).value < 0) return true;
  }
  return false;
}

/// Distance from a point to the surface in the given direction, unit [m]; 0 outside. By steps of
/// the distance to the nearest surface (Hart 1996, "Sphere tracing"); where these are too many, a
/// bound.
double way_out(const Shape& shape, const Vector3& from, const Vector3& direction) {
  Vector3 x = from;
  for (int k = 0; k < most_steps; ++k) {
    const double depth = -signed_distance(shape, x, x).value;
    if (depth < penetration_slop) return direction.dot(x - from);
    x += depth * direction;
  }
  return 2 * bounding_radius(shape);
}

}  // namespace

bool ColliderContacts::is_blocked(const std::vector<MovingCollider>& colliders, std::size_t left,
                                  const Cloth& cloth, const ContactStep& step,
                                  const Points& positions, const Vector3& direction) const {
  const std::vector<char>& leaves = caches_[left].leaves;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (k == left || !colliders[k].enabled() || caches_[k].near.empty()) continue;
    if (step.bodies && step.bodies->is_body(k)) continue;
    const Pose& pose = colliders[k].pose();
    for (int i = 0; i < cloth.num_points(); ++i) {
      if (!leaves[static_cast<std::size_t>(i)]) continue;
      const Vector3 x = to_local(pose, row(positions, i));
      const Distance d = signed_distance(colliders[k].shape(), x, x);
      const bool touches = d.value < touching * (caches_[k].keeps - cloth.nearer_by(i));
      if (touches && (pose.orientation * d.normal).dot(direction) < blocking * direction.norm())
        return true;
    }
  }
  return false;
}

bool ColliderContacts::is_overlapped(const Penetration& penetration,
                                     const std::vector<MovingCollider>& colliders,
                                     const Cloth& cloth, const Points& start) {
  const auto overlaps = [&](const MovingCollider& other, const Vector3& place, double depth,
                            double thickness) {
    const bool may_be_jaw = std::isfinite(safe_depth(other.shape()));
    const Vector3 x = to_local(other.previous(), place);
    const double overlap = depth - signed_distance(other.shape(), x, x).value;
    return overlap > (may_be_jaw ? 2 * thickness : put_on_depth);
  };
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (k == static_cast<std::size_t>(penetration.collider) || !colliders[k].enabled()) continue;
    for (const auto& [point, depth] : penetration.points) {
      if (overlaps(colliders[k], row(start, point), depth, cloth.thickness_at(point))) return true;
    }
    for (const PenetratingFace& face : penetration.faces) {
      const Corners& c = cloth.triangles[static_cast<std::size_t>(face.triangle)];
      const Vector3 touched = weighted(start, c, face.weights);
      if (overlaps(colliders[k], touched, face.depth, cloth.thickness_at(c[0]))) return true;
    }
  }
  return false;
}

void ColliderContacts::mark_leaving(const Penetration& penetration, const Cloth& cloth) {
  ColliderCache& s = cache(penetration.collider);
  s.leaves.assign(static_cast<std::size_t>(cloth.num_points()), 0);
  for (const auto& point : penetration.points) s.leaves[static_cast<std::size_t>(point.first)] = 1;
  for (const PenetratingFace& face : penetration.faces) {
    for (const int i : cloth.triangles[static_cast<std::size_t>(face.triangle)]) {
      s.leaves[static_cast<std::size_t>(i)] = 1;
    }
  }
}

void ColliderContacts::choose_exits(const std::vector<Penetration>& penetrations,
                                    const std::vector<MovingCollider>& colliders,
                                    const Cloth& cloth, const ContactStep& step,
                                    const Points& positions) {
  if (std::all_of(caches_.begin(), caches_.end(),
                  [](const ColliderCache& s) { return s.exit.is_nearest(); })) {
    return;
  }
  std::vector<double> depths(caches_.size(), 0);
  for (const Penetration& c : penetrations) {
    depths[static_cast<std::size_t>(c.collider)] = c.depth();
  }
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    if (depths[k] == 0 && !caches_[k].exit.lags) caches_[k].exit = {};
  }
  for (const Penetration& c : penetrations) {
    ColliderExit& exit = cache(c.collider).exit;
    if (exit.is_nearest()) continue;
    const auto number = static_cast<std::size_t>(c.collider);
    exit.duration += step.h;
    if (exit.duration > longest_exit) {
      exit = {};
      continue;
    }
    mark_leaving(c, cloth);
    if (!exit.is_together()) {
      exit = chosen_exit(c, colliders, cloth, step, positions);
    } else if (!exit.has_turned_back &&
               is_blocked(colliders, number, cloth, step, positions, exit.velocity)) {
      exit = chosen_exit(c, colliders, cloth, step, positions);
      exit.has_turned_back = exit.is_together();
    }
  }
}

ColliderExit ColliderContacts::chosen_exit(const Penetration& penetration,
                                           const std::vector<MovingCollider>& colliders,
                                           const Cloth& cloth, const ContactStep& step,
                                           const Points& positions) {
  const auto number = static_cast<std::size_t>(penetration.collider);
  const Shape& shape = colliders[number].shape();
  const bool is_body = step.bodies && step.bodies->is_body(number);
  if (is_body || std::isinf(safe_depth(shape)) || penetration.depth() <= put_on_depth) return {};
  local_.place(colliders[number], cloth, step.start, positions, caches_[number].mesh);
  if (holds_any(shape, cloth, local_.from)) return {};
  const auto normal =
      normal_to(shape, cloth, local_.from, cache(penetration.collider).leaves, local_.edge);
  if (!normal) return {};
  const Eigen::Quaterniond& turn = colliders[number].pose().orientation;
  Vector3 direction = turn * normal->out;
  const bool is_ahead = is_blocked(colliders, number, cloth, step, positions, direction);
  const bool is_behind = is_blocked(colliders, number, cloth, step, positions, -direction);
  if (is_ahead && is_behind) return {};
  // Jaws that overlap by less than the cloth's thickness hold it.
  if (is_ahead && !is_overlapped(penetration, colliders, cloth, step.start)) return {};
  if (normal->is_pierced && !is_ahead && !is_behind) return {};
  if (is_ahead) direction = -direction;

  const Vector3 way = turn.conjugate() * direction;
  double longest = penetration.depth();
  for (const auto& point : penetration.points) {
    longest = std::max(longest, way_out(shape, row(local_.from, point.first), way));
  }
  for (const PenetratingFace& face : penetration.faces) {
    const Corners& c = cloth.triangles[static_cast<std::size_t>(face.triangle)];
    longest = std::max(longest, way_out(shape, weighted(local_.from, c, face.weights), way));
  }
  const double speed = std::min(recovery_speed, longest / put_on_time);
  return {ColliderExit::Way::together, speed * direction, is_ahead};
}

void ColliderContacts::leave_together(const Penetration& penetration,
                                      const MovingCollider& collider, const Cloth& cloth,
                                      const ContactStep& step, const Points& positions) {
  ColliderCache& s = cache(penetration.collider);
  const double depth = penetration.depth();
  const bool is_together = s.exit.is_together() && depth > 0;
  if (!is_together && !(depth > safe_depth(collider.shape()))) return;
  mark_leaving(penetration, cloth);
  const Eigen::Quaterniond& turn = collider.pose().orientation;
  if (is_together) {
    s.exit_speed = s.exit.velocity.norm();
    s.exit_direction = turn.conjugate() * s.exit.velocity / s.exit_speed;
  } else {
    s.exit_speed = recovery_speed;
    local_.place(collider, cloth, step.start, positions, s.mesh);
    s.exit_direction = direction_out(cloth, local_.from, local_.to - local_.from, step.h, s.leaves);
  }
  s.is_close = true;

  // All its points leave that way, those outside too.
  const Vector3 direction = turn * *s.exit_direction;
  const bool is_body =
      step.bodies && step.bodies->is_body(static_cast<std::size_t>(penetration.collider));
  const double speed = is_body ? 0 : step.recovery_factor * s.exit_speed;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!s.leaves[static_cast<std::size_t>(i)] || cloth.inv_mass[i] == 0) continue;
    s.slots.put(i, direction, collider.velocity_at(row(positions, i)), speed);
  }
  for (const PenetratingFace& face : penetration.faces) {
    faces_.redirect(face.contact, direction, speed);
  }
}

void ColliderContacts::write_exits(MemoryWriter& memory) const {
  const auto is_written = [](const ColliderCache& s) { return !s.exit.is_nearest(); };
  memory.add(static_cast<double>(std::count_if(caches_.begin(), caches_.end(), is_written)));
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    if (!is_written(caches_[k])) continue;
    const ColliderExit& exit = caches_[k].exit;
    memory.add(static_cast<double>(k));
    memory.add(exit.is_together());
    if (!exit.is_together()) continue;
    memory.add(exit.velocity);
    memory.add(exit.has_turned_back);
    memory.add(exit.lags);
    memory.add(exit.duration);
  }
}

void ColliderContacts::read_exits(MemoryReader& memory, std::size_t colliders) {
  for (std::size_t left = memory.count(); left > 0; --left) {
    ColliderExit& exit = cache(memory.index(colliders)).exit;
    exit = {ColliderExit::Way::undecided};
    if (memory.index(2) == 0) continue;
    exit.way = ColliderExit::Way::together;
    exit.velocity = memory.vector();
    const double speed = exit.velocity.norm();
    if (!(speed > 0 && speed <= recovery_speed * (1 + rounding))) {
      throw InvalidValue({"memory"}, "cloth that leaves a collider at " + to_text(speed) + " m/s",
                         "a speed above 0 and of at most " + to_text(recovery_speed) + " m/s");
    }
    exit.has_turned_back = memory.index(2) == 1;
    exit.lags = memory.index(2) == 1;
    exit.duration = std::max(0.0, memory.number());
  }
}

}  // namespace clothsim
