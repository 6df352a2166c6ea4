#include "clothsim/constraints/face_contacts.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/face_approach.h"
#include "clothsim/shapes/tracked_distance.h"

namespace clothsim {
namespace {

/// Most that the normal of a triangle that is followed, not measured, may have turned [rad].
/// Normals that lag let contact forces drive the cloth: on a rim it moves for ever at 1.5 mm/s with
/// 0.06 rad, at 0.1 mm/s with this.
constexpr double followed_turn = 1e-3;

}  // namespace

void FaceContacts::start_over(double h) {
  list_.start_over(h);
  places_.clear();
}

std::optional<FaceContacts::Feature> FaceContacts::feature_of(const CornerWeights& w) {
  const auto zeros = std::count(w.begin(), w.end(), 0.0);
  if (zeros > 1) return std::nullopt;
  if (zeros == 0) return face;
  return w[2] == 0 ? first_edge : (w[0] == 0 ? second_edge : third_edge);
}

FaceContacts::AtCollider& FaceContacts::at_collider(int number, const Cloth& cloth) {
  if (!blocks_.fits(cloth)) blocks_.reset(cloth);
  at_.resize(std::max(at_.size(), static_cast<std::size_t>(number) + 1));
  AtCollider& result = at_[static_cast<std::size_t>(number)];
  result.measured.resize(cloth.triangles.size());
  return result;
}

double FaceContacts::distance_of(const ColliderQuery& at, const MeasuredTriangle& measured,
                                 const Corners& corners) {
  if (at.local.longest > safe_depth(at.collider.shape())) return -infinity;  // it may be through
  return std::min(measured.distance_at(raised_triangle(at, at.local.middle, corners)),
                  measured.distance_at(raised_triangle(at, at.local.to, corners)));
}

void FaceContacts::find(const ColliderQuery& at) {
  AtCollider& of = at_collider(at.number, at.cloth);
  ContactList::Last last(list_, key_of(at.number, 0, 0));
  of.near.clear();
  const auto is_far = [&](std::size_t triangle, const Corners& corners) {
    return distance_of(at, of.measured[triangle], corners) >= at.reach;
  };
  const auto look = [&](int triangle, const Corners& corners) {
    MeasuredTriangle& measured = of.measured[static_cast<std::size_t>(triangle)];
    NearTriangle near;
    near.triangle = triangle;
    near.distance = distance_of(at, measured, corners);
    near.reached_at = at.travelled + near.distance;
    if (near.distance <= at.margin) {
      const double margin = margin_of(at, corners);
      if (near.distance <= margin) look_at(at, margin, near, measured, last);
    }
    if (near.distance < at.reach) of.near.push_back(near);
  };
  for_each_near(at.collider.shape(), at.cloth, blocks_, at.local, at.reach, is_far, look);

  std::vector<char> is_near(static_cast<std::size_t>(at.cloth.num_points()), 0);
  for (const NearTriangle& near : of.near) {
    for (const int i : at.cloth.triangles[static_cast<std::size_t>(near.triangle)]) {
      is_near[static_cast<std::size_t>(i)] = 1;
    }
  }
  of.points.clear();
  for (int i = 0; i < at.cloth.num_points(); ++i) {
    if (is_near[static_cast<std::size_t>(i)]) of.points.push_back(i);
  }
}

void FaceContacts::find_again(const ColliderQuery& at) {
  ContactList::Last last(list_, key_of(at.number, 0, 0));
  AtCollider& of = at_[static_cast<std::size_t>(at.number)];
  for (NearTriangle& near : of.near) {
    if (near.reached_at > at.travelled + 2 * at.in_step + at.margin) continue;
    const auto triangle = static_cast<std::size_t>(near.triangle);
    const Corners& corners = at.cloth.triangles[triangle];
    if (follow(at, near, last)) continue;
    const double margin = margin_of(at, corners);
    if (distance_of(at, of.measured[triangle], corners) > margin) continue;
    look_at(at, margin, near, of.measured[triangle], last);
  }
}

bool FaceContacts::follow(const ColliderQuery& at, const NearTriangle& near,
                          ContactList::Last& last) {
  if (!near.is_beside) return false;
  const Corners& corners = at.cloth.triangles[static_cast<std::size_t>(near.triangle)];
  Triangle displacements = raised_triangle(at, at.local.middle, corners);
  // The normal from an edge or a tip turns by the displacement over the distance.
  const double longest = longest_displacement(near.corners, displacements);
  if (longest > followed_turn * near.distance) return false;
  for (std::size_t k = 0; k < 3; ++k) displacements[k] -= near.corners[k];
  for (std::size_t i = 0; i < features; ++i) {
    if (!near.touching[i]) continue;
    FaceDistance now = *near.touching[i];
    const CornerWeights& w = now.weights;
    now.value +=
        now.normal.dot(w[0] * displacements[0] + w[1] * displacements[1] + w[2] * displacements[2]);
    const std::uint64_t key = key_of(at.number, near.triangle, i);
    add(at, key, last.of(key), now, false, 0);
  }
  return true;
}

double FaceContacts::margin_of(const ColliderQuery& at, const Corners& corners) {
  double speed2 = 0;
  for (const int i : corners) {
    speed2 = std::max(
        {speed2, at.state.velocities.row(i).squaredNorm(), at.step.drifted.row(i).squaredNorm()});
  }
  return at.margin - at.step.h * std::max(0.0, at.speed - std::sqrt(speed2));
}

Triangle FaceContacts::raised_triangle(const ColliderQuery& at, const Points& points,
                                       const Corners& corners) {
  return raised_at_held(at.collider.shape(), at.cloth, corners,
                        clothsim::triangle_of(points, corners));
}

std::optional<FaceDistance> FaceContacts::measure(const ColliderQuery& at, NearTriangle& near,
                                                  MeasuredTriangle& measured) {
  const Shape& shape = at.collider.shape();
  const auto triangle = static_cast<std::size_t>(near.triangle);
  const Corners& corners = at.cloth.triangles[triangle];
  near.corners = raised_triangle(at, at.local.middle, corners);
  std::optional<FaceDistance> found;
  if (near.nearest) found = tracked_distance(shape, near.corners, *near.nearest);
  if (!found) {
    found = face_distance(shape, near.corners, at.reach, at.local.query(triangle, corners));
  }
  near.distance = found ? found->value : at.reach;
  // Raised corners may move further than the corners do, see raised_at_held().
  const Triangle as_it_is = clothsim::triangle_of(at.local.middle, corners);
  near.reached_at = at.travelled + near.distance - longest_displacement(as_it_is, near.corners);
  measured = {near.corners, near.distance, supporting_plane(shape, near.corners, found)};
  if (found) found->value += leeway(at.cloth, corners, near.corners, found->weights);
  return found;
}

void FaceContacts::look_at(const ColliderQuery& at, double margin, NearTriangle& near,
                           MeasuredTriangle& measured, ContactList::Last& last) {
  const auto& [number, collider, cloth, step, speed, margin_of_all, reach, travelled, in_step,
               local, state, penetrating_faces] = at;
  const Shape& shape = collider.shape();
  const auto triangle = static_cast<std::size_t>(near.triangle);
  const Corners& corners = cloth.triangles[triangle];
  near.touching = {};
  near.is_beside = false;
  // The triangle as it lies where impulses act, unless it is to be stopped or led out.
  FaceApproach found{measure(at, near, measured)};
  const double sinks = found.distance ? found.distance->value - near.distance : 0;
  const double at_end = measured.distance_at(raised_triangle(at, local.to, corners)) + sinks;
  const bool may_be_inside = local.longest > safe_depth(shape) || at_end < 0;
  if (may_be_inside) {
    const FaceApproach approached = approach(collider, cloth, triangle, local, margin);
    if (!approached.distance) return;
    if (approached.swept || approached.before < 0) found = approached;
  }
  const bool alone = found.swept || found.before < 0;
  if (!found.distance || (near.distance > margin && !alone)) return;
  // Not kept beyond the margin, where bounds decide whether a triangle is measured at all.
  near.nearest = found.distance->weights;
  near.is_beside = !may_be_inside;

  // Corners are left to the contacts of their points, unless they are to be led out.
  const auto feature = feature_of(found.distance->weights);
  if (!alone) {
    const auto edges = edges_along(shape, near.corners, *found.distance, margin);
    std::copy(edges.begin(), edges.end(), near.touching.begin());
    for (auto& edge : near.touching) {
      if (edge) edge->value += leeway(cloth, corners, near.corners, edge->weights);
    }
  }
  if (feature || alone) near.touching[feature.value_or(face)] = found.distance;

  for (std::size_t i = 0; i < features; ++i) {
    if (!near.touching[i]) continue;
    const FaceDistance& distance = *near.touching[i];
    const std::uint64_t key = key_of(number, near.triangle, i);
    const std::size_t before = places_.size();
    add(at, key, last.of(key), distance, found.swept, -found.before);
    if (found.before < 0 && places_.size() > before)
      penetrating_faces.push_back({near.triangle, before, -found.before, distance.weights});
  }
}

/// Does a triangle pass by a rim of a rigid body without coming nearer, see
/// ColliderContacts::leave_out_passing()?
bool FaceContacts::passes_by(const ColliderQuery& at, const Corners& corners) {
  const RigidBodies* bodies = at.step.bodies;
  if (!bodies || !bodies->is_body(static_cast<std::size_t>(at.number))) return false;
  Triangle end = raised_triangle(at, at.local.middle, corners);
  for (std::size_t k = 0; k < 3; ++k) {
    const int i = corners[k];
    const Vector3 v =
        row(at.state.velocities, i) - at.collider.velocity_at(row(at.state.positions, i));
    end[k] += at.step.h * (at.collider.pose().orientation.conjugate() * v);
  }
  const double keeps = at.cloth.offset_at(corners[0]) - passing_depth;
  const auto distance = face_distance(at.collider.shape(), end, keeps);
  return !distance || distance->value >= keeps;
}

void FaceContacts::add(const ColliderQuery& at, std::uint64_t key, const Contact* last,
                       const FaceDistance& distance, bool swept, double depth) {
  const auto& [number, collider, cloth, step, speed, margin, reach, travelled, in_step, local,
               state, penetrating_faces] = at;
  Contact contact{key};
  const Corners& corners = cloth.triangles[static_cast<std::size_t>(triangle_of(contact))];
  const std::array<double, 3>& weights = distance.weights;
  const CornerWeights moves = moves_of(cloth, corners, weights);
  const double inv_effective_mass = inv_effective_mass_of(weights, moves);
  if (inv_effective_mass == 0) return;
  const double lever = lever_of(cloth, corners, weights);
  const double keeps = cloth.offset_at(corners[0]);

  const Vector3 normal = collider.pose().orientation * distance.normal;
  const Vector3 x = weighted(state.positions, corners, weights);
  const Vector3 surface_velocity = collider.velocity_at(x);
  const double drift = normal.dot(weighted(step.drifted, corners, weights) - surface_velocity);
  if (swept) {
    // Back to where it came in, less the displacement by the impulse that ends its approach.
    const double back =
        keeps - distance.value + step.displacement_factor * step.h * std::min(0.0, drift);
    spread(corners, moves, back / inv_effective_mass * normal, state.positions);
    spread(corners, moves, back / inv_effective_mass * distance.normal, local.to);
  }

  // The gap at the step's end if the triangle only followed the surface.
  const double rate = normal.dot(weighted(state.velocities, corners, weights) - surface_velocity);
  const double gap = distance.value - keeps;
  const double target_velocity = swept ? 0 : -std::max(gap, 0.0) / step.h;
  const bool is_new = !last && gap > 0 && depth == 0;
  if (is_new && (rate >= target_velocity || passes_by(at, corners))) return;

  contact.points = {corners[0], corners[1], corners[2], corners[0]};
  contact.weights = {weights[0], weights[1], weights[2], 0};
  contact.compute_effective_mass(cloth);
  contact.nearest = keeps;
  const bool is_body = step.bodies && step.bodies->is_body(static_cast<std::size_t>(number));
  const double recovery = is_body ? 0 : lever * step.recovery_factor * exit_speed(depth);
  contact.impulse = {normal, surface_velocity, target_velocity + recovery, collider.friction()};
  if (last) contact.impulse.keep(last->impulse);
  list_.add(contact);
  places_.push_back({lever, distance.value, x});
}

void FaceContacts::release_pinched(const Pinches& pinches,
                                   const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                                   const ContactStep& step) {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Contact& c = list_.contacts()[i];
    const Corners& corners = cloth.triangles[static_cast<std::size_t>(triangle_of(c))];
    if (!pinches.holds_any(corners)) continue;
    const double keeps = cloth.offset_at(corners[0]);
    const MovingCollider& collider = colliders[static_cast<std::size_t>(collider_of(c))];
    Triangle start = clothsim::triangle_of(step.start, corners);
    for (Vector3& corner : start) corner = to_local(collider.previous(), corner);
    double sinks = 0;
    Vector3 held(0, 0, 0);  // share of the velocity there [m/s]
    for (std::size_t k = 0; k < 3; ++k) {
      if (!pinches.holds(corners[k])) {
        held += c.weights[k] * c.impulse.surface_velocity;
        c.impulse.max_normal_impulse = Pinches::max_overlap_impulse * pinches.weight(cloth);
        continue;
      }
      held += c.weights[k] * pinches.velocity(corners[k]);
      sinks += c.weights[k] *
               raise_of_held(collider.shape(), cloth.offset_at(corners[k]), start, k).norm();
      c.hold(k);
    }
    if (c.mass == 0) {
      c.impulse.deactivate();
      continue;
    }
    const double closing = std::max(0.0, c.impulse.normal.dot(c.impulse.surface_velocity - held));
    c.impulse.target_velocity =
        -std::max(0.0, places_[i].distance + sinks - keeps) / step.h - closing;
  }
}

void FaceContacts::warm_start(const Points& positions, RigidBodies* bodies, Points& velocities) {
  list_.warm_start(positions, velocities);
  if (!bodies) return;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Contact& c = list_.contacts()[i];
    bodies->motion(static_cast<std::size_t>(collider_of(c))).give(-c.impulse.total(), places_[i].x);
  }
}

double FaceContacts::solve_pass(RigidBodies* bodies, Points& velocities) {
  if (!bodies) return list_.solve_pass(-1, velocities);  // over all: faces are few
  double largest = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Contact& c = list_.contacts()[i];
    if (c.mass == 0) continue;
    RigidMotion& body = bodies->motion(static_cast<std::size_t>(collider_of(c)));
    const Vector3 &x = places_[i].x, &normal = c.impulse.normal;
    if (body.is_body) c.impulse.surface_velocity = body.velocity_at(x);
    const double mass = 1 / (1 / c.mass + body.inv_mass_at(x, normal));
    const double tangential_mass = 1 / (1 / c.mass + body.inv_mass_across(x, normal));
    const Vector3 v = weighted_sum(c.points, c.weights, velocities);
    const Vector3 change = c.impulse.update(v, mass, tangential_mass);
    if (change.isZero(0)) continue;
    c.give(change, velocities);
    body.give(-change, x);
    largest = std::max(largest, change.norm() / std::min(mass, tangential_mass));
  }
  return largest;
}

void FaceContacts::project_positions(int number, const MovingCollider& collider, const Cloth& cloth,
                                     double h, const std::vector<char>& held, LocalCloth& local,
                                     std::vector<char>& moved) {
  const AtCollider& of = at_collider(number, cloth);
  const auto is_far = [&](std::size_t triangle, const Corners& corners) {
    const Triangle to = clothsim::triangle_of(local.to, corners);
    return of.measured[triangle].distance_at(to) > cloth.offset;
  };
  const auto any_of = [](const auto& marks, const Corners& c, int mark) {
    return std::any_of(c.begin(), c.end(),
                       [&](int i) { return marks[static_cast<std::size_t>(i)] >= mark; });
  };
  std::vector<int> last_move(static_cast<std::size_t>(cloth.num_points()), 0);  // by pass
  for (int pass = 1; pass <= max_conflict_passes; ++pass) {
    bool again = false;
    const auto move_out = [&](int triangle, const Corners& corners) {
      // All in the first pass, then those with a corner that has just moved.
      if (!any_of(last_move, corners, pass - 1)) return;
      if (!held.empty() && any_of(held, corners, 1)) return;
      const double keeps = cloth.offset_at(corners[0]);
      const FaceApproach found =
          approach(collider, cloth, static_cast<std::size_t>(triangle), local, keeps);
      if (!found.distance) return;
      const double now = found.distance->value;
      const std::array<double, 3>& weights = found.distance->weights;
      const CornerWeights moves = moves_of(cloth, corners, weights);
      const double inv_effective_mass = inv_effective_mass_of(weights, moves);
      if (inv_effective_mass == 0) return;
      const double in_reach = lever_of(cloth, corners, weights) * h;
      const double wanted = found.before < 0
                                ? required_distance(found.before, keeps, recovery_speed * in_reach)
                                : raised(now, keeps);
      const bool must = now < wanted - penetration_slop;  // others may move it out, too
      if (!must && (pass > 1 || now >= keeps)) return;
      spread(corners, moves, (wanted - now) / inv_effective_mass * found.distance->normal,
             local.to);
      for (const int i : corners) {
        if (cloth.inv_mass[i] == 0) continue;
        if (must) last_move[static_cast<std::size_t>(i)] = pass;
        moved[static_cast<std::size_t>(i)] = 1;
        local.distance[i] =
            signed_distance(collider.shape(), local.to.row(i), local.from.row(i)).value;
      }
      again = again || must;
    };
    for_each_near(collider.shape(), cloth, blocks_, local, cloth.offset, is_far, move_out);
    if (!again) break;
  }
}

void FaceContacts::reset() {
  list_.reset();
  places_.clear();
  at_.clear();
}

}  // namespace clothsim
