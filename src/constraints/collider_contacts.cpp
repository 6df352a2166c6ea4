#include "clothsim/constraints/collider_contacts.h"

#include <algorithm>
#include <cmath>

#include "clothsim/model/surface.h"

namespace clothsim {
namespace {

/// Distance of the farthest point [m].
double farthest_from(const Vector3& origin, const Points& points) {
  return std::sqrt((points.rowwise() - origin.transpose()).rowwise().squaredNorm().maxCoeff());
}

}  // namespace

void ColliderContacts::begin(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                             const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  stretch_ = step.stretch;
  faces_.start_over(h_);
  has_pinched_ = pinches_.count() > 0 || is_restored_pinched_;
  is_restored_pinched_ = false;
  pinches_.start_over(h_, step.gravity);
  recovers_ = false;
  pace_ = step.pace;
  if (colliders.empty()) return;

  std::vector<Caught> caught = find(colliders, cloth, step, state);
  if (caught.size() > 1) find_pinched(colliders, cloth, step, caught);
  for (const Caught& c : caught) {
    const MovingCollider& collider = colliders[static_cast<std::size_t>(c.collider)];
    recovers_ = recovers_ || c.depth() > 0;
    if (c.depth() > safe_depth(collider.shape())) {
      escape(c, collider, cloth, step, state.positions);
    }
  }
  leaving_ = std::max(0.0, leaving_ + (recovers_ ? step.h : -step.h));

  resume(cloth, scale, state);
  faces_.resume(state.positions, state.velocities);
  pinches_.sweep(state.velocities);
}

double ColliderContacts::Caught::depth() const {
  double deepest = 0;
  for (const auto& point : points) deepest = std::max(deepest, point.second);
  for (const CaughtFace& face : faces) deepest = std::max(deepest, face.depth);
  return deepest;
}

std::vector<ColliderContacts::Caught> ColliderContacts::find(
    const std::vector<MovingCollider>& colliders, const Cloth& cloth, const ContactStep& step,
    State& state) {
  sides_.resize(colliders.size());
  travel_.begin(step.start, state.positions);
  local_.edge = longest_edge_within_limit(cloth, step.stretch);
  const double speed = longest_row(state.velocities), drift = longest_row(step.drifted);
  std::vector<Caught> result;
  for (int k = 0; k < static_cast<int>(colliders.size()); ++k) {
    Side& s = side(k);
    s.slots.start_over();
    s.way_out.reset();
    s.near.clear();
    s.has_faces = false;
    const MovingCollider& collider = colliders[static_cast<std::size_t>(k)];
    if (!collider.enabled()) {
      s.is_clear = false;
      continue;
    }
    Caught caught{k, {}, {}};
    find_at(s, collider, cloth, step, speed, drift, state, caught);
    if (!s.near.empty() || s.has_faces) result.push_back(std::move(caught));
  }
  return result;
}

void ColliderContacts::find_at(Side& s, const MovingCollider& collider, const Cloth& cloth,
                               const ContactStep& step, double speed, double drift, State& state,
                               Caught& caught) {
  if (!s.room.is_of(ContactSlots::num_blocks(cloth))) {
    s.room.reset(ContactSlots::num_blocks(cloth));
  }
  follow(s, collider, state.positions);

  // Nothing farther away can touch it.
  const Clearance keeps = clearance(collider.shape(), cloth, step.stretch, has_pinched_);
  const double of_surface = s.moved / step.h;
  const double margin = step.h * (speed + of_surface) + step.way + keeps.points;
  const double to_middle = step.reach * step.h * (drift + of_surface);
  const double near = margin + to_middle + keeps.points;
  s.room.find_near(travel_.total(), near, s.near);
  if (keeps.faces && std::isinf(local_.edge)) {
    local_.edge = longest_edge(state.positions, cloth.triangles);
  }
  s.has_faces = is_near_faces(s, keeps, margin);
  if (s.near.empty() && !s.has_faces) return;

  if (!s.slots.fits(cloth)) s.slots.reset(cloth);
  if (s.has_faces) {
    local_.place(collider, step.start, state.positions);
    local_.place_middle(collider, step, state.positions);
  }
  s.friction = collider.friction();
  s.keeps = keeps.points;
  s.within = near;
  find_points(s, collider, cloth, step, state);
  if (s.is_close) {
    const ContactSlots::Seeker seeker(collider, s.keeps, s.asked(collider, cloth, near));
    for (const Span& span : s.near) {
      const int end = ContactSlots::end_of(span.end - 1, cloth);
      for (int i = ContactSlots::first_of(span.begin); i < end; ++i) {
        if (cloth.inv_mass[i] > 0) look_closely(s, i, seeker, step, state, caught);
      }
    }
  }
  if (s.has_faces) {
    faces_.find({caught.collider, collider, cloth, step, margin, local_, state, caught.faces});
  }
}

void ColliderContacts::find_points(Side& s, const MovingCollider& collider, const Cloth& cloth,
                                   const ContactStep& step, const State& state) {
  const ContactSlots::Seeker seeker(collider, s.keeps, s.asked(collider, cloth, s.within));
  for (const Span& span : s.near) s.slots.find(span, seeker, cloth, step, state);
}

bool ColliderContacts::is_settled() const { return !recovers_ && pinches_.count() == 0; }

void ColliderContacts::go_on(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                             const ContactStep& step, State& state) {
  const bool has_faces = faces_.size() > 0;
  faces_.start_over(h_);
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    Side& s = sides_[k];
    if (!colliders[k].enabled()) continue;
    follow(s, colliders[k], state.positions);
    if (!s.near.empty()) {
      s.slots.start_over();
      find_points(s, colliders[k], cloth, step, state);
    }
    if (!has_faces || !s.has_faces) continue;
    Caught caught{static_cast<int>(k), {}, {}};
    local_.place(colliders[k], step.start, state.positions);
    local_.place_middle(colliders[k], step, state.positions);
    faces_.find_again(
        {caught.collider, colliders[k], cloth, step, s.within, local_, state, caught.faces});
    recovers_ = recovers_ || caught.depth() > 0;
  }
  leaving_ = std::max(0.0, leaving_ + (recovers_ ? step.h : -step.h));
  resume(cloth, 1, state);
  faces_.resume(state.positions, state.velocities);
}

void ColliderContacts::resume(const Cloth& cloth, double scale, State& state) {
  for (Side& s : sides_) {
    s.slots.close();
    for (const int block : s.slots.active()) s.room.wake(block);  // what touches, does not sleep
    s.slots.resume(cloth, scale, state.velocities);
  }
}

Asked ColliderContacts::Side::asked(const MovingCollider& collider, const Cloth& cloth,
                                    double reach) {
  if (!std::holds_alternative<MeshShape>(collider.shape())) return {};
  neighbourhoods.resize(static_cast<std::size_t>(cloth.num_points()));
  return {reach, neighbourhoods.data()};
}

void ColliderContacts::follow(Side& s, const MovingCollider& collider,
                              const Points& positions) const {
  const bool turns = collider.last_turn() > 0 ||
                     collider.pose().orientation.coeffs() != s.room.pose().orientation.coeffs();
  const double radius = turns ? farthest_from(collider.pose().position, positions) : 0;
  const double jumped = s.room.follow(collider.previous(), radius) + travel_.between_steps();
  s.moved = s.room.follow(collider.pose(), radius);
  s.is_clear = s.is_clear && jumped < may_sink;
  s.is_close = !s.is_clear || travel_.in_step() + s.moved > safe_depth(collider.shape());
}

bool ColliderContacts::is_near_faces(const Side& s, const Clearance& keeps, double reach) const {
  return keeps.faces && s.room.is_near(travel_.total(), reach + local_.edge / std::sqrt(3));
}

double ColliderContacts::sweep(Points& velocities) {
  double residual2 = 0;
  for (Side& s : sides_) residual2 = std::max(residual2, s.slots.sweep(s.friction, velocities));
  const double on_faces = faces_.sweep(velocities);
  return std::max({std::sqrt(residual2), on_faces, pinches_.sweep(velocities)}) * h_;
}

void ColliderContacts::correct(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                               const Points& start, Points& positions) {
  pinches_.correct(start, positions);
  travel_.go_on(start, positions);
  correct_all(colliders, cloth, start, positions);
}

void ColliderContacts::correct_near(const std::vector<MovingCollider>& colliders,
                                    const Cloth& cloth, const Points& start, Points& positions) {
  travel_.add(longest_way(start, positions));
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    Side& s = sides_[k];
    if (s.near.empty()) continue;
    const ContactSlots::Seeker seeker(colliders[k], s.keeps,
                                      s.asked(colliders[k], cloth, 2 * s.keeps));
    double longest = 0;
    for (const Span& span : s.near) {
      const double* free = &cloth.inv_mass[ContactSlots::first_of(span.begin)];
      double least[Span::longest];
      longest =
          std::max(longest, ContactSlots::push_out(span, seeker, free, start, positions, least));
    }
    moved_out(k, longest);
  }
  travel_.end(positions);
}

void ColliderContacts::moved_out(std::size_t collider, double way) {
  travel_.add(way);
  // It may have been moved into another one.
  for (std::size_t other = 0; other < collider && way >= may_sink; ++other) {
    sides_[other].is_clear = false;
  }
}

void ColliderContacts::correct_again(const std::vector<MovingCollider>& colliders,
                                     const Cloth& cloth, const Points& start, Points& positions) {
  travel_.begin(start, positions);
  correct_all(colliders, cloth, start, positions);
}

void ColliderContacts::correct_all(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                                   const Points& start, Points& positions) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!colliders[k].enabled()) continue;
    moved_out(k, correct_at(sides_[k], colliders[k], cloth, start, positions));
  }
  travel_.end(positions);
}

double ColliderContacts::correct_at(Side& s, const MovingCollider& collider, const Cloth& cloth,
                                    const Points& start, Points& positions) {
  const Clearance keeps = clearance(collider.shape(), cloth, stretch_, has_pinched_);
  s.room.find_near(travel_.total(), 2 * keeps.points, s.inside);
  s.is_close = s.is_close || travel_.in_step() + s.moved > safe_depth(collider.shape());
  s.is_clear = pinches_.count() == 0;
  const ContactSlots::Seeker seeker(collider, keeps.points,
                                    s.asked(collider, cloth, 2 * keeps.points));
  double longest = 0;
  for (const Span& span : s.inside) {
    const double* can_move = &cloth.inv_mass[ContactSlots::first_of(span.begin)];
    double free[Span::longest * ContactSlots::block], least[Span::longest];
    if (s.is_close || pinches_.count() > 0) {
      const double way = correct_closely(s, span, seeker, cloth, start, positions, free);
      longest = std::max(longest, way);
      can_move = free;
    }
    const double way = ContactSlots::push_out(span, seeker, can_move, start, positions, least);
    longest = std::max(longest, way);
    for (int b = span.begin; b < span.end; ++b) {
      const double nearest = least[b - span.begin];
      if (!s.slots.has_active(b)) s.room.keep(b, nearest, travel_.total());
      // A pin in the solid may be let go.
      if (nearest < may_sink && ContactSlots::has_pin(b, cloth)) s.is_clear = false;
    }
  }
  if (is_near_faces(s, keeps, keeps.points)) {
    longest = std::max(longest, correct_faces(s, collider, cloth, start, positions));
  }
  return longest;
}

double ColliderContacts::correct_faces(Side& s, const MovingCollider& collider, const Cloth& cloth,
                                       const Points& start, Points& positions) {
  std::vector<char> held = pinches_.held();
  if (s.way_out) {
    held.resize(s.leaves.size());
    std::transform(held.begin(), held.end(), s.leaves.begin(), held.begin(),
                   [](char a, char b) { return a | b; });
  }
  local_.place(collider, start, positions);
  std::vector<char> moved(static_cast<std::size_t>(cloth.num_points()), 0);
  faces_.correct(collider, cloth, pace_ * h_, held, local_, moved);
  double longest = 0;
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!moved[static_cast<std::size_t>(i)]) continue;
    const Vector3 to = to_world(collider.pose(), row(local_.to, i));
    longest = std::max(longest, (to - row(positions, i)).norm());
    positions.row(i) = to.transpose();
    s.is_clear = s.is_clear && local_.distance[i] >= may_sink;
  }
  return longest;
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
  for (const Side& s : sides_) points += s.slots.count();
  return points + faces_.count() + pinches_.count();
}

void ColliderContacts::reset() {
  sides_.clear();
  travel_ = {};
  faces_.reset();
  pinches_.start_over(0);
  is_restored_pinched_ = false;
  recovers_ = false;
  leaving_ = 0;
  h_ = 0;
}

void ColliderContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  int points = 0;
  for (const Side& s : sides_) points += s.slots.count();
  memory.add(points);
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    sides_[k].slots.for_each_held([&](int point, const ContactImpulse& impulse) {
      memory.add(static_cast<double>(k));
      memory.add(point);
      impulse.write(memory);
    });
  }
  faces_.write(memory);
  memory.add(pinches_.count() > 0 || is_restored_pinched_);
  memory.add(recovers_);
  memory.add(leaving_);
}

void ColliderContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  sides_.resize(colliders);
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    ContactSlots& slots = side(memory.index(colliders)).slots;
    const int point = memory.index(static_cast<std::size_t>(cloth.num_points()));
    if (!slots.fits(cloth)) slots.reset(cloth);
    ContactImpulse impulse;
    impulse.read(memory);
    slots.hold(point, impulse);
  }
  faces_.read(memory);
  is_restored_pinched_ = memory.index(2) == 1;
  recovers_ = memory.index(2) == 1;
  leaving_ = std::max(0.0, memory.number());
}

}  // namespace clothsim
