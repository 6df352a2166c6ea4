#include "clothsim/constraints/collider_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace clothsim {
namespace {

/// A turn within a step that is so small is taken as a straight way in the collider's frame [rad].
constexpr double smallest_turn = 0.1;

Vector3 to_world(const Pose& pose, const Vector3& local) {
  return pose.position + pose.orientation * local;
}

/// Bounds of a cloth on its way through a step.
Eigen::AlignedBox3d bounds(const Points& start, const Points& end) {
  Eigen::AlignedBox3d box(start.colwise().minCoeff().transpose(),
                          start.colwise().maxCoeff().transpose());
  box.extend(Vector3(end.colwise().minCoeff().transpose()));
  box.extend(Vector3(end.colwise().maxCoeff().transpose()));
  return box;
}

/// Where a point that may have passed through the shape in one step came in, in the collider's own
/// frame at the step's end.
std::optional<Vector3> swept_entry(const MovingCollider& collider, const Vector3& from,
                                   const Vector3& to, double offset) {
  const double depth = safe_depth(collider.shape());
  const double turn = collider.last_turn();
  if ((to - from).squaredNorm() <= depth * depth) return std::nullopt;
  if (turn <= smallest_turn) return entry_point(collider.shape(), from, to, offset);

  // Its way is bent in a frame that turns: piece by piece.
  const Vector3 start = to_world(collider.previous(), from), end = to_world(collider.pose(), to);
  const int pieces = static_cast<int>(std::ceil(turn / smallest_turn));
  Vector3 last = from;
  for (int i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    const Vector3 next = to_local(collider.pose_at(share), start + share * (end - start));
    const auto entry = entry_point(collider.shape(), last, next, offset);
    if (entry) return entry;
    last = next;
  }
  return std::nullopt;
}

/// Distance of a point from the surface at the step's start, 0 where it was outside [m].
double depth_before(const Shape& shape, const Vector3& from) {
  return std::min(0.0, signed_distance(shape, from, from).value);
}

/// Direction in which a piece of cloth, of which `held` are the points, leaves a solid about the
/// origin: square to the piece, away from the middle.
Vector3 way_out(const Cloth& cloth, const Points& points, const std::vector<char>& held) {
  Vector3 normal(0, 0, 0), middle(0, 0, 0);
  for (const auto& [a, b, c] : cloth.triangles) {
    if (!held[static_cast<std::size_t>(a)] && !held[static_cast<std::size_t>(b)] &&
        !held[static_cast<std::size_t>(c)]) {
      continue;
    }
    normal += (row(points, b) - row(points, a)).cross(row(points, c) - row(points, a));
  }
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (held[static_cast<std::size_t>(i)]) middle += row(points, i);
  }
  if (normal.norm() == 0) normal = middle;
  if (normal.norm() == 0) normal = Vector3::UnitZ();
  return (normal.dot(middle) < 0 ? -1 : 1) * normal.normalized();
}

}  // namespace

void ColliderContacts::begin(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                             const ContactStep& step, State& state) {
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  stretch_ = step.stretch;
  last_.swap(contacts_);
  contacts_.clear();
  next_last_ = 0;
  faces_.start_over();
  escapes_.clear();
  pinches_.start_over(h_, step.gravity);
  recovers_ = false;
  if (colliders.empty()) return;

  std::vector<Caught> caught = find(colliders, cloth, step, state);
  if (caught.size() > 1) find_pinched(colliders, cloth, state.positions, caught);
  for (const Caught& c : caught) {
    const MovingCollider& collider = colliders[static_cast<std::size_t>(c.collider)];
    recovers_ = recovers_ || c.depth() > 0;
    if (c.depth() > safe_depth(collider.shape())) {
      escape(c, collider, cloth, step, state.positions);
    }
  }
  resume(cloth, scale, state.velocities);
}

double ColliderContacts::Caught::depth() const {
  double deepest = 0;
  for (const CaughtPoint& point : points) deepest = std::max(deepest, point.depth);
  for (const CaughtFace& face : faces) deepest = std::max(deepest, face.depth);
  return deepest;
}

std::vector<ColliderContacts::Caught> ColliderContacts::find(
    const std::vector<MovingCollider>& colliders, const Cloth& cloth, const ContactStep& step,
    State& state) {
  std::vector<Caught> result;
  const Eigen::AlignedBox3d box = bounds(step.start, state.positions);
  const double fastest = longest_row(state.velocities);
  const double fastest_drift = longest_row(step.drifted);
  local_.edge = longest_edge_within_limit(cloth, step.stretch);
  for (int k = 0; k < static_cast<int>(colliders.size()); ++k) {
    const MovingCollider& collider = colliders[static_cast<std::size_t>(k)];
    const Clearance keeps = clearance(collider.shape(), cloth, step.stretch);
    const double of_surface = collider.fastest_in(box);
    const double margin = step.h * (fastest + of_surface) + keeps.points;
    if (!collider.reaches(box, margin)) continue;

    Caught caught{k, {}, {}};
    local_.place(collider, step.start, state.positions);
    local_.place_middle(collider, step, state.positions);
    const double reach =
        margin + step.reach * step.h * (fastest_drift + of_surface) + local_.longest;
    find_points(k, collider, cloth, step, keeps.points, reach, state, caught.points);
    if (keeps.faces) {
      faces_.find(k, collider, cloth, step, margin, local_, state, caught.faces);
    }
    result.push_back(std::move(caught));
  }
  return result;
}

void ColliderContacts::find_pinched(const std::vector<MovingCollider>& colliders,
                                    const Cloth& cloth, const Points& positions,
                                    std::vector<Caught>& caught) {
  const auto point = [&](std::size_t i) { return contacts_[i].point; };
  const auto side = [&](const Contact& c) -> Pinches::Side {
    return {c.impulse, colliders[static_cast<std::size_t>(c.collider)]};
  };
  for_each_two(contacts_.size(), static_cast<std::size_t>(cloth.num_points()), point,
               [&](auto i, auto j) {
                 const Contact &a = contacts_[i], &b = contacts_[j];
                 if (!Pinches::leave_no_room(a.impulse, b.impulse)) return;
                 pinches_.add(a.point, row(positions, a.point), side(a), side(b), cloth);
               });
  const auto of_point = [&](int collider, int p) -> const ContactImpulse* {
    const auto id = std::make_tuple(collider, p);
    const auto c = std::lower_bound(contacts_.begin(), contacts_.end(), id,
                                    [](const Contact& a, const auto& b) { return a.id() < b; });
    return c != contacts_.end() && c->id() == id ? &c->impulse : nullptr;
  };
  faces_.find_pinched(colliders, of_point, cloth, positions, pinches_);
  if (pinches_.count() == 0) return;

  // Nothing else pushes them about.
  for (Contact& c : contacts_) {
    if (pinches_.holds(c.point)) c.impulse.let_go();
  }
  faces_.leave_to(pinches_, cloth);
  const auto drop = [](auto& list, const auto& is_held) {
    list.erase(std::remove_if(list.begin(), list.end(), is_held), list.end());
  };
  for (Caught& c : caught) {
    drop(c.points, [&](const CaughtPoint& p) { return pinches_.holds(p.point); });
    drop(c.faces, [&](const CaughtFace& f) {
      return pinches_.holds_any(cloth.triangles[static_cast<std::size_t>(f.triangle)]);
    });
  }
}

void ColliderContacts::resume(const Cloth& cloth, double scale, Points& velocities) {
  for (Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    c.impulse.resume(c.impulse, scale);
    velocities.row(c.point) += c.impulse.total().transpose();
  }
  faces_.resume(cloth, scale, velocities);
  pinches_.sweep(velocities);
}

void ColliderContacts::find_points(int index, const MovingCollider& collider, const Cloth& cloth,
                                   const ContactStep& step, double offset, double reach,
                                   State& state, std::vector<CaughtPoint>& caught) {
  const Eigen::Matrix3d turn = collider.pose().orientation.toRotationMatrix();
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] == 0) continue;

    // The last step's impulse, if it was in contact.
    const auto id = std::make_tuple(index, i);
    while (next_last_ < last_.size() && last_[next_last_].id() < id) ++next_last_;
    const bool held = next_last_ < last_.size() && last_[next_last_].id() == id &&
                      last_[next_last_].impulse.push > 0;
    if (!held && local_.distance[i] > reach) continue;
    const Vector3 from = row(local_.from, i);
    Vector3 to = row(local_.to, i);

    // A point that may have passed through stops where it came in.
    const auto entry = swept_entry(collider, from, to, offset);
    if (entry) {
      to = *entry;
      local_.to.row(i) = to.transpose();
      state.positions.row(i) = to_world(collider.pose(), to).transpose();
    }

    // The gap this step would leave if the point only followed the surface. What is held, as it
    // lies where impulses act.
    Distance d = signed_distance(collider.shape(), to, from);
    local_.distance[i] = d.value;
    const double depth = d.value < 0 ? -depth_before(collider.shape(), from) : 0;
    const bool at_middle = held && depth == 0 && !entry;
    if (at_middle) d = signed_distance(collider.shape(), row(local_.middle, i), from);
    const Vector3 normal = turn * d.normal;
    const Vector3 surface_velocity = collider.velocity_at(row(state.positions, i));
    const double rate = normal.dot(row(state.velocities, i) - surface_velocity);
    const double drift = normal.dot(row(step.drifted, i) - surface_velocity);
    const double gap = d.value - offset - (at_middle ? 0 : step.reach * step.h * drift);
    const double slowest = entry ? 0 : -std::max(gap, 0.0) / step.h;
    // The impulse that ends its approach will carry it on to where it came in.
    if (entry && drift < 0)
      state.positions.row(i) += step.reach * step.h * drift * normal.transpose();

    // Others may yet push a point on the surface into it.
    if (!held && rate >= slowest && gap > 0) continue;

    if (depth > 0) caught.push_back({i, depth});
    contacts_.push_back(
        {index,
         i,
         {normal, surface_velocity, slowest + way_out_speed(depth), collider.friction()}});
    if (held) contacts_.back().impulse.resume(last_[next_last_].impulse, 1);
  }
}

void ColliderContacts::escape(const Caught& caught, const MovingCollider& collider,
                              const Cloth& cloth, const ContactStep& step,
                              const Points& positions) {
  const int index = caught.collider;
  Escape out{index, {}, std::vector<char>(static_cast<std::size_t>(cloth.num_points()), 0)};
  for (const CaughtPoint& p : caught.points) out.held[static_cast<std::size_t>(p.point)] = 1;
  for (const CaughtFace& face : caught.faces) {
    for (const int i : cloth.triangles[static_cast<std::size_t>(face.triangle)]) {
      out.held[static_cast<std::size_t>(i)] = 1;
    }
  }
  local_.place(collider, step.start, positions);
  out.direction = way_out(cloth, local_.from, out.held);

  // All its points go that way, those outside too.
  const Vector3 direction = collider.pose().orientation * out.direction;
  std::vector<char> missing = out.held;
  for (Contact& c : contacts_) {
    const auto point = static_cast<std::size_t>(c.point);
    if (c.collider != index || !out.held[point]) continue;
    c.impulse.normal = direction;
    c.impulse.slowest = recovery_speed;
    missing[point] = 0;
  }
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (!missing[static_cast<std::size_t>(i)] || cloth.inv_mass[i] == 0) continue;
    contacts_.push_back({index,
                         i,
                         {direction, collider.velocity_at(row(positions, i)), recovery_speed,
                          collider.friction()}});
  }
  std::sort(contacts_.begin(), contacts_.end(),
            [](const Contact& p, const Contact& q) { return p.id() < q.id(); });
  for (const CaughtFace& face : caught.faces) faces_.redirect(face.contact, direction);
  escapes_.push_back(std::move(out));
}

double ColliderContacts::sweep(const Cloth& cloth, Points& velocities) {
  double residual2 = 0;
  for (Contact& c : contacts_) {
    Vector3 velocity = row(velocities, c.point);
    if (velocity == c.left) continue;
    const Vector3 change = c.impulse.update(velocity, 1);
    velocity += change;
    velocities.row(c.point) = velocity.transpose();
    c.left = velocity;
    residual2 = std::max(residual2, change.squaredNorm());
  }
  const double on_faces = faces_.sweep(cloth, velocities);
  return std::max({std::sqrt(residual2), on_faces, pinches_.sweep(velocities)}) * h_;
}

void ColliderContacts::correct(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                               const Points& start, Points& positions) {
  pinches_.correct(start, positions);
  const Eigen::AlignedBox3d box = bounds(start, positions);
  for (int k = 0; k < static_cast<int>(colliders.size()); ++k) {
    const MovingCollider& collider = colliders[static_cast<std::size_t>(k)];
    const Clearance keeps = clearance(collider.shape(), cloth, stretch_);
    if (!collider.reaches(box, keeps.points)) continue;

    const auto escape = std::find_if(escapes_.begin(), escapes_.end(),
                                     [&](const Escape& e) { return e.collider == k; });
    local_.place(collider, start, positions);
    std::vector<char> moved(static_cast<std::size_t>(cloth.num_points()), 0);
    for (int i = 0; i < cloth.num_points(); ++i) {
      const bool escapes = escape != escapes_.end() && escape->held[static_cast<std::size_t>(i)];
      if (!escapes && local_.distance[i] > keeps.points + local_.longest) continue;
      const Vector3 from = row(local_.from, i);
      Vector3 to = row(local_.to, i);
      const auto entry =
          cloth.inv_mass[i] > 0 ? swept_entry(collider, from, to, keeps.points) : std::nullopt;
      if (entry) to = *entry;
      const Distance d = signed_distance(collider.shape(), to, from);
      local_.distance[i] = d.value;
      if (cloth.inv_mass[i] == 0 || pinches_.holds(i)) continue;

      if (escapes) {
        const double way = escape->direction.dot(to - from);
        to += std::max(0.0, recovery_speed * h_ - way) * escape->direction;
      } else if (d.value < keeps.points) {
        const double before = depth_before(collider.shape(), from);
        const double wanted = required_distance(before, keeps.points, h_);
        to += std::max(0.0, wanted - d.value) * d.normal;
      } else if (!entry) {
        continue;
      }
      local_.to.row(i) = to.transpose();
      local_.distance[i] = signed_distance(collider.shape(), to, from).value;
      moved[static_cast<std::size_t>(i)] = 1;
    }
    if (keeps.faces) {
      std::vector<char> held = pinches_.held();
      if (escape != escapes_.end()) {
        held.resize(escape->held.size());
        std::transform(held.begin(), held.end(), escape->held.begin(), held.begin(),
                       [](char a, char b) { return a | b; });
      }
      faces_.correct(collider, cloth, h_, held, local_, moved);
    }
    for (int i = 0; i < cloth.num_points(); ++i) {
      if (!moved[static_cast<std::size_t>(i)]) continue;
      positions.row(i) = to_world(collider.pose(), row(local_.to, i)).transpose();
    }
  }
}

int ColliderContacts::points_count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.impulse.push > 0; }));
}

int ColliderContacts::count() const { return points_count() + faces_.count() + pinches_.count(); }

void ColliderContacts::reset() {
  contacts_.clear();
  faces_.reset();
  pinches_.start_over(0);
  recovers_ = false;
  h_ = 0;
}

void ColliderContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  memory.add(points_count());
  for (const Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    memory.add(c.collider);
    memory.add(c.point);
    c.impulse.write(memory);
  }
  faces_.write(memory);
  pinches_.write(memory);
  memory.add(recovers_);
}

void ColliderContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    Contact c{};
    c.collider = memory.index(colliders);
    c.point = memory.index(static_cast<std::size_t>(cloth.num_points()));
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
  faces_.read(memory, colliders, cloth);
  pinches_.read(memory, cloth);
  recovers_ = memory.index(2) == 1;
}

}  // namespace clothsim
