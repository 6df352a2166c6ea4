#include "clothsim/constraints/collider_contacts.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/surface.h"

namespace clothsim {

void ColliderContacts::prepare(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                               const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  stretch_ = step.stretch;
  faces_.start_over(h_);
  has_pinched_ = pinches_.count() > 0 || is_restored_pinched_;
  is_restored_pinched_ = false;
  pinches_.start_over(h_, step.gravity);
  recovers_ = false;
  recovery_factor_ = step.recovery_factor;
  if (colliders.empty()) return;

  std::vector<Penetration> penetrations = find(colliders, cloth, step, state);
  choose_exits(penetrations, colliders, cloth, step, state.positions);
  if (penetrations.size() > 1) find_pinched(colliders, cloth, step, penetrations);
  for (const Penetration& c : penetrations) {
    recovers_ = recovers_ || c.depth() > 0;
    leave_together(c, colliders[static_cast<std::size_t>(c.collider)], cloth, step,
                   state.positions);
  }
  recovery_duration_ = std::max(0.0, recovery_duration_ + (recovers_ ? step.h : -step.h));

  warm_start(cloth, scale, step.bodies, state);
  faces_.warm_start(state.positions, step.bodies, state.velocities);
  if (step.bodies) couple(colliders, cloth, step, state.positions);
  pinches_.solve_pass(state.velocities);
}

std::vector<ColliderContacts::Penetration> ColliderContacts::find(
    const std::vector<MovingCollider>& colliders, const Cloth& cloth, const ContactStep& step,
    State& state) {
  caches_.resize(colliders.size());
  motion_bound_.begin(step.start, state.positions);
  local_.edge = longest_edge_within_limit(cloth, step.stretch);
  const double speed = longest_row(state.velocities), drift = longest_row(step.drifted);
  std::vector<Penetration> result;
  for (int k = 0; k < static_cast<int>(colliders.size()); ++k) {
    ColliderCache& s = cache(k);
    s.slots.start_over();
    s.exit_direction.reset();
    s.near.clear();
    s.has_faces = false;
    const MovingCollider& collider = colliders[static_cast<std::size_t>(k)];
    if (!collider.enabled()) {
      s.is_clear = s.is_restored_clear = false;
      s.exit = {};
      continue;
    }
    Penetration penetration{k, {}, {}};
    find_at(s, collider, cloth, step, speed, drift, state, penetration);
    if (!s.near.empty() || s.has_faces) result.push_back(std::move(penetration));
  }
  return result;
}

void ColliderContacts::find_at(ColliderCache& s, const MovingCollider& collider, const Cloth& cloth,
                               const ContactStep& step, double speed, double drift, State& state,
                               Penetration& penetration) {
  if (!s.sleep_bounds.is_of(ContactSlots::num_blocks(cloth))) {
    s.sleep_bounds.reset(ContactSlots::num_blocks(cloth));
  }
  follow(s, collider, state.positions);

  // Nothing farther away can touch it.
  const Clearance keeps = clearance(collider.shape(), cloth, step.stretch, has_pinched_);
  const double of_surface = s.moved / step.h;
  const double margin = step.h * (speed + of_surface) + step.undetected_move + keeps.points;
  const double to_middle = step.displacement_factor * step.h * (drift + of_surface);
  const double near = margin + to_middle + keeps.points;
  const bool needs_edge = keeps.faces && std::isinf(local_.edge);
  if (needs_edge) local_.edge = longest_edge(state.positions, cloth.triangles);
  // Points whose faces may reach the collider are measured, too, so that they sleep again.
  const double reach = keeps.faces ? near + local_.edge / std::sqrt(3) : near;
  s.sleep_bounds.find_near(motion_bound_.total(), reach, s.near);
  s.has_faces = is_near_faces(s, keeps, margin);
  if (s.near.empty() && !s.has_faces) return;

  if (!s.slots.fits(cloth)) s.slots.reset(cloth);
  if (s.has_faces) {
    local_.place(collider, cloth, step.start, state.positions, s.mesh);
    local_.place_middle(collider, step, state.positions);
  }
  s.friction = collider.friction();
  s.keeps = keeps.points;
  s.within = near;
  find_points(s, collider, cloth, step, state, motion_bound_.total());
  if (step.bodies && step.bodies->is_body(static_cast<std::size_t>(penetration.collider))) {
    leave_out_passing(s, collider, cloth, step, state);
  }
  if (s.is_close) {
    const ContactSlots::Detector detector(collider, cloth, s.keeps, s.query(collider, cloth, near));
    for (const Span& span : s.near) {
      const int end = ContactSlots::end_of(span.end - 1, cloth);
      for (int i = ContactSlots::first_of(span.begin); i < end; ++i) {
        if (cloth.inv_mass[i] > 0) look_closely(s, i, detector, step, state, penetration);
      }
    }
  }
  if (s.has_faces) {
    const double within = step.undetected_move > 0 ? near : margin;
    faces_.find({penetration.collider, collider, cloth, step, speed, margin - step.undetected_move,
                 within, motion_bound_.total() + s.sleep_bounds.moved(),
                 step.h * (speed + of_surface), local_, state, penetration.faces});
  }
}

void ColliderContacts::find_points(ColliderCache& s, const MovingCollider& collider,
                                   const Cloth& cloth, const ContactStep& step, const State& state,
                                   std::optional<double> travelled) {
  const ContactSlots::Detector detector(collider, cloth, s.keeps,
                                        s.query(collider, cloth, s.within));
  for (const Span& span : s.near) {
    double nearest[Span::longest];
    s.slots.find(span, detector, cloth, step, state, nearest);
    for (int b = span.begin; b < span.end && travelled; ++b) {
      if (!s.slots.has_active(b)) s.sleep_bounds.keep(b, nearest[b - span.begin], *travelled);
    }
  }
}

bool ColliderContacts::is_settled() const {
  return !recovers_ && pinches_.count() == 0 &&
         std::none_of(caches_.begin(), caches_.end(),
                      [](const ColliderCache& s) { return s.exit.is_together(); });
}

void ColliderContacts::refresh(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                               const ContactStep& step, State& state) {
  faces_.start_over(h_);
  const double speed = std::max(longest_row(state.velocities), longest_row(step.drifted));
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    ColliderCache& s = caches_[k];
    if (!colliders[k].enabled()) continue;
    follow(s, colliders[k], state.positions);
    if (!s.near.empty()) {
      s.slots.start_over();
      find_points(s, colliders[k], cloth, step, state, {});
      if (step.bodies && step.bodies->is_body(k)) {
        leave_out_passing(s, colliders[k], cloth, step, state);
      }
    }
    if (!s.has_faces) continue;
    Penetration penetration{static_cast<int>(k), {}, {}};
    const double in_step = step.h * speed + s.moved;
    local_.place_points(faces_.near_points(k), colliders[k], step, state.positions, in_step,
                        s.mesh);
    faces_.find_again({penetration.collider, colliders[k], cloth, step, speed, in_step + s.keeps,
                       s.within, motion_bound_.total() + s.sleep_bounds.moved(), in_step, local_,
                       state, penetration.faces});
    recovers_ = recovers_ || penetration.depth() > 0;
  }
  recovery_duration_ = std::max(0.0, recovery_duration_ + (recovers_ ? step.h : -step.h));
  warm_start(cloth, 1, step.bodies, state);
  faces_.warm_start(state.positions, step.bodies, state.velocities);
  if (step.bodies) couple(colliders, cloth, step, state.positions);
}

void ColliderContacts::warm_start(const Cloth& cloth, double scale, RigidBodies* bodies,
                                  State& state) {
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    ColliderCache& s = caches_[k];
    s.slots.close();
    for (const int block : s.slots.active()) {
      s.sleep_bounds.wake(block);  // blocks in contact do not sleep
    }
    s.slots.warm_start(cloth, scale, state.velocities);
    if (!bodies || !bodies->is_body(k)) continue;
    Wrench impulse;
    s.slots.add_impulses(cloth.mass, bodies->motion(k).center, state.positions, impulse);
    bodies->motion(k).give(impulse);
  }
}

MeshQuery ColliderContacts::ColliderCache::query(const MovingCollider& collider, const Cloth& cloth,
                                                 double distance) {
  if (!std::holds_alternative<MeshShape>(collider.shape())) return {};
  mesh.points.resize(static_cast<std::size_t>(cloth.num_points()));
  return {distance, mesh.points.data()};
}

void ColliderContacts::follow(ColliderCache& s, const MovingCollider& collider,
                              const Points& positions) const {
  const bool turns = collider.last_turn() > 0 || collider.pose().orientation.coeffs() !=
                                                     s.sleep_bounds.pose().orientation.coeffs();
  const double radius = turns ? farthest_from(collider.pose().position, positions) : 0;
  const double jumped =
      s.sleep_bounds.follow(collider.previous(), radius) + motion_bound_.between_steps();
  s.moved = s.sleep_bounds.follow(collider.pose(), radius);
  s.is_clear = (s.is_clear && jumped < penetration_slop) || s.is_restored_clear;
  s.is_restored_clear = false;
  s.is_close = !s.is_clear || s.exit.is_together() ||
               motion_bound_.in_step() + s.moved > safe_depth(collider.shape());
}

bool ColliderContacts::stays_clear(const ColliderCache& s, const MovingCollider& collider,
                                   const Points& positions) const {
  if (!s.is_clear) return false;
  SleepBounds next = s.sleep_bounds;
  const double radius = farthest_from(collider.pose().position, positions);
  return next.follow(collider.pose(), radius) + motion_bound_.since_step(positions) <
         penetration_slop;
}

bool ColliderContacts::is_near_faces(const ColliderCache& s, const Clearance& keeps,
                                     double distance) const {
  return keeps.faces &&
         s.sleep_bounds.is_near(motion_bound_.total(), distance + local_.edge / std::sqrt(3));
}

double ColliderContacts::solve_pass(const Cloth& cloth, const Points& positions,
                                    RigidBodies* bodies, Points& velocities) {
  double residual2 = 0, on_bodies = 0;
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    ColliderCache& s = caches_[k];
    if (bodies && bodies->is_body(k)) {
      on_bodies = std::max(on_bodies, s.slots.solve_pass(s.friction, cloth, positions,
                                                         bodies->motion(k), velocities));
    } else {
      residual2 = std::max(residual2, s.slots.solve_pass(s.friction, velocities));
    }
  }
  const double on_faces = faces_.solve_pass(bodies, velocities);
  return std::max({std::sqrt(residual2), on_bodies, on_faces, pinches_.solve_pass(velocities)}) *
         h_;
}

bool ColliderContacts::has_edges(const std::vector<MovingCollider>& colliders,
                                 const Cloth& cloth) const {
  const bool pinched = pinches_.count() > 0 || is_restored_pinched_;
  return pinched || std::any_of(colliders.begin(), colliders.end(), [&](const MovingCollider& c) {
           return c.enabled() && clearance(c.shape(), cloth).faces;
         });
}

int ColliderContacts::count() const {
  int points = 0;
  for (const ColliderCache& s : caches_) points += s.slots.count();
  return points + faces_.count() + pinches_.count();
}

void ColliderContacts::jump(std::size_t collider) {
  if (collider < caches_.size()) {
    caches_[collider].is_clear = caches_[collider].is_restored_clear = false;
  }
}

void ColliderContacts::find_jumps(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                                  const Points& positions) {
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    for (int i = 0; i < cloth.num_points() && caches_[k].is_restored_clear; ++i) {
      if (cloth.inv_mass[i] == 0) continue;
      const Vector3 place = to_local(colliders[k].pose(), row(positions, i));
      if (signed_distance(colliders[k].shape(), place, place).value < penetration_slop) jump(k);
    }
  }
}

void ColliderContacts::put_on(std::size_t collider) {
  if (collider >= caches_.size()) caches_.resize(collider + 1);
  caches_[collider].exit = {ColliderExit::Way::undecided};
}

std::vector<ColliderExit> ColliderContacts::exits() const {
  std::vector<ColliderExit> exits;
  for (const ColliderCache& s : caches_) exits.push_back(s.exit);
  return exits;
}

void ColliderContacts::set_exits(const std::vector<ColliderExit>& exits) {
  caches_.resize(std::max(caches_.size(), exits.size()));
  for (std::size_t k = 0; k < exits.size(); ++k) caches_[k].exit = exits[k];
}

void ColliderContacts::reset() {
  caches_.clear();
  motion_bound_ = {};
  faces_.reset();
  coupled_.clear();
  pinches_.start_over(0);
  is_restored_pinched_ = false;
  recovers_ = false;
  recovery_duration_ = 0;
  h_ = 0;
}

void ColliderContacts::write(MemoryWriter& memory, const std::vector<MovingCollider>& colliders,
                             const Points& positions) const {
  memory.add(h_);
  int points = 0;
  for (const ColliderCache& s : caches_) points += s.slots.count();
  memory.add(points);
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    caches_[k].slots.for_each_with_impulse([&](int point, const ContactImpulse& impulse) {
      memory.add(static_cast<double>(k));
      memory.add(point);
      impulse.write(memory);
    });
  }
  faces_.write(memory);
  std::vector<std::size_t> clear;
  for (std::size_t k = 0; k < caches_.size(); ++k) {
    if (caches_[k].is_restored_clear || stays_clear(caches_[k], colliders[k], positions)) {
      clear.push_back(k);
    }
  }
  memory.add(static_cast<double>(clear.size()));
  for (const std::size_t k : clear) memory.add(static_cast<double>(k));
  write_exits(memory);
  memory.add(pinches_.count() > 0 || is_restored_pinched_);
  memory.add(recovers_);
  memory.add(recovery_duration_);
}

void ColliderContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  caches_.resize(colliders);
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    ContactSlots& slots = cache(memory.index(colliders)).slots;
    const int point = memory.index(static_cast<std::size_t>(cloth.num_points()));
    if (!slots.fits(cloth)) slots.reset(cloth);
    ContactImpulse impulse;
    impulse.read(memory);
    slots.set_impulse(point, impulse);
  }
  faces_.read(memory);
  for (std::size_t left = memory.count(); left > 0; --left) {
    cache(memory.index(colliders)).is_restored_clear = true;
  }
  read_exits(memory, colliders);
  is_restored_pinched_ = memory.index(2) == 1;
  recovers_ = memory.index(2) == 1;
  recovery_duration_ = std::max(0.0, memory.number());
}

}  // namespace clothsim
