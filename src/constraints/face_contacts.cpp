#include "clothsim/constraints/face_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clothsim/constraints/face_approach.h"

namespace clothsim {
namespace {

/// Passes that take triangles out of a collider, each of which may move its neighbours in.
constexpr int max_passes = 50;

/// How much of the offset more may be used up before a triangle is moved: others move it, too.
constexpr double grace = 0.1;

/// Ways in which a triangle can touch: with its edges, from corner i to i + 1, with its face.
constexpr std::size_t features = 4;
constexpr std::size_t face = 3;

/// With which of them it does; empty where it touches with a corner alone.
std::optional<std::size_t> feature_of(const CornerWeights& w) {
  const auto zeros = std::count(w.begin(), w.end(), 0.0);
  if (zeros > 1) return std::nullopt;
  if (zeros == 0) return face;
  return w[2] == 0 ? 0 : (w[0] == 0 ? 1 : 2);
}

/// Longest way of a corner between where impulses act and the step's end [m].
double to_middle(const LocalCloth& local, const Corners& corners) {
  double longest2 = 0;
  for (const int i : corners) {
    longest2 = std::max(longest2, (local.to.row(i) - local.middle.row(i)).squaredNorm());
  }
  return std::sqrt(longest2);
}

}  // namespace

void FaceContacts::start_over() {
  last_.swap(contacts_);
  contacts_.clear();
  next_last_ = 0;
}

const FaceContacts::Contact* FaceContacts::last_of(const Id& id) {
  while (next_last_ < last_.size() && last_[next_last_].id < id) ++next_last_;
  if (next_last_ == last_.size() || id < last_[next_last_].id) return nullptr;
  return last_[next_last_].impulse.push > 0 ? &last_[next_last_] : nullptr;
}

void FaceContacts::find(int index, const MovingCollider& collider, const Cloth& cloth,
                        const ContactStep& step, double margin, LocalCloth& local, State& state,
                        std::vector<CaughtFace>& caught) {
  if (!blocks_.fits(cloth)) blocks_.reset(cloth);
  const bool fast = local.longest > safe_depth(collider.shape());
  const auto look_at = [&](int triangle, const Corners& corners) {
    // As it lies where impulses act, unless it is to be stopped or led out.
    const Triangle middle = triangle_of(local.middle, corners);
    FaceApproach found;
    found.distance = distance_with_leeway(collider.shape(), cloth, corners, middle, margin);
    const bool may_be_inside =
        fast || (found.distance && found.distance->value < to_middle(local, corners));
    if (may_be_inside) {
      const FaceApproach at_end = approach(collider, cloth, corners, local, margin);
      if (!at_end.distance) return;
      if (at_end.swept || at_end.before < 0) found = at_end;
    }
    if (!found.distance) return;
    const bool alone = found.swept || found.before < 0;

    // Corners are left to the contacts of their points, unless they are to be led out.
    std::array<std::optional<FaceDistance>, features> touching;
    const auto feature = feature_of(found.distance->weights);
    if (!alone) {
      const auto edges = edges_along(collider.shape(), middle, *found.distance, margin);
      std::copy(edges.begin(), edges.end(), touching.begin());
      for (auto& edge : touching) {
        if (edge) edge->value += leeway(cloth, corners, middle, edge->weights);
      }
    }
    if (feature || alone) touching[feature.value_or(face)] = found.distance;

    for (std::size_t i = 0; i < features; ++i) {
      if (!touching[i]) continue;
      const Id id{index, triangle, static_cast<int>(i)};
      const std::size_t before = contacts_.size();
      add(id, collider, cloth, step, *touching[i], found.swept, -found.before, local, state);
      if (found.before < 0 && contacts_.size() > before) {
        caught.push_back({triangle, before, -found.before});
      }
    }
  };
  for_each_near(collider.shape(), cloth, blocks_, local, margin, look_at);
}

void FaceContacts::add(const Id& id, const MovingCollider& collider, const Cloth& cloth,
                       const ContactStep& step, const FaceDistance& distance, bool swept,
                       double depth, LocalCloth& local, State& state) {
  const Corners& corners = cloth.triangles[static_cast<std::size_t>(id.triangle)];
  const std::array<double, 3>& weights = distance.weights;
  const CornerWeights moves = moves_of(cloth, corners, weights);
  const double yield = yield_of(weights, moves);
  if (yield == 0) return;
  const double lever = lever_of(cloth, corners, weights);

  const Vector3 normal = collider.pose().orientation * distance.normal;
  const Vector3 surface_velocity =
      collider.velocity_at(weighted(state.positions, corners, weights));
  const double drift = normal.dot(weighted(step.drifted, corners, weights) - surface_velocity);
  if (swept) {
    // Back to where it came in, less what the impulse that ends its approach will move it.
    const double back = cloth.offset - distance.value + step.reach * step.h * std::min(0.0, drift);
    spread(corners, moves, back / yield * normal, state.positions);
    spread(corners, moves, back / yield * distance.normal, local.to);
  }

  // The gap this step would leave if the triangle only followed the surface.
  const double rate = normal.dot(weighted(state.velocities, corners, weights) - surface_velocity);
  const double gap = distance.value - cloth.offset;
  const double slowest = swept ? 0 : -std::max(gap, 0.0) / step.h;
  const Contact* last = last_of(id);
  if (!last && rate >= slowest && gap > 0 && depth == 0) return;

  contacts_.push_back(
      {id,
       weights,
       moves,
       yield,
       lever,
       {normal, surface_velocity, slowest + lever * way_out_speed(depth), collider.friction()}});
  if (last) contacts_.back().impulse.resume(last->impulse, 1);
}

void FaceContacts::resume(const Cloth& cloth, double scale, Points& velocities) {
  for (Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    c.impulse.resume(c.impulse, scale);
    spread(cloth.triangles[static_cast<std::size_t>(c.id.triangle)], c.moves, c.impulse.total(),
           velocities);
  }
}

void FaceContacts::find_pinched(const std::vector<MovingCollider>& colliders,
                                const PointContacts& of_point, const Cloth& cloth,
                                const Points& positions, Pinches& pinches) const {
  const auto collider_of = [&](const Contact& c) -> const MovingCollider& {
    return colliders[static_cast<std::size_t>(c.id.collider)];
  };
  const auto pinch = [&](int triangle, const Pinches::Side& a, const Pinches::Side& b) {
    if (!Pinches::leave_no_room(a.contact, b.contact)) return;
    for (const int corner : cloth.triangles[static_cast<std::size_t>(triangle)]) {
      pinches.add(corner, row(positions, corner), a, b, cloth);
    }
  };

  const auto triangle = [&](std::size_t i) { return contacts_[i].id.triangle; };
  for_each_two(contacts_.size(), cloth.triangles.size(), triangle, [&](auto i, auto j) {
    const Contact &a = contacts_[i], &b = contacts_[j];
    if (a.id.collider == b.id.collider) return;
    pinch(a.id.triangle, {a.impulse, collider_of(a)}, {b.impulse, collider_of(b)});
  });

  // The other side may hold the corners alone.
  for (const Contact& c : contacts_) {
    for (int other = 0; other < static_cast<int>(colliders.size()); ++other) {
      if (other == c.id.collider) continue;
      const auto corners = under(c, other, of_point, cloth);
      if (!corners) continue;
      pinch(c.id.triangle, {c.impulse, collider_of(c)},
            {*corners, colliders[static_cast<std::size_t>(other)]});
    }
  }
}

/// What the contacts of a triangle's corners with another collider ask for where `c` acts; nothing
/// if one that has a share of it has none.
std::optional<ContactImpulse> FaceContacts::under(const Contact& c, int other,
                                                  const PointContacts& of_point,
                                                  const Cloth& cloth) {
  ContactImpulse all;
  all.normal.setZero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (c.weights[k] == 0) continue;
    const int corner = cloth.triangles[static_cast<std::size_t>(c.id.triangle)][k];
    const std::optional<ContactImpulse> of_corner = of_point(other, corner);
    if (!of_corner) return {};
    all.normal += c.weights[k] * of_corner->normal;
    all.surface_velocity += c.weights[k] * of_corner->surface_velocity;
    all.slowest += c.weights[k] * of_corner->slowest;
    all.friction += c.weights[k] * of_corner->friction;
  }
  all.normal.normalize();
  return all;
}

void FaceContacts::leave_to(const Pinches& pinches, const Cloth& cloth) {
  for (Contact& c : contacts_) {
    const Corners& corners = cloth.triangles[static_cast<std::size_t>(c.id.triangle)];
    if (pinches.holds_any(corners)) c.impulse.let_go();
  }
}

double FaceContacts::sweep(const Cloth& cloth, Points& velocities) {
  double residual2 = 0;
  for (Contact& c : contacts_) {
    const Corners& corners = cloth.triangles[static_cast<std::size_t>(c.id.triangle)];
    const Vector3 change = c.impulse.update(weighted(velocities, corners, c.weights), 1 / c.yield);
    spread(corners, c.moves, change, velocities);
    residual2 = std::max(residual2, change.squaredNorm());
  }
  return std::sqrt(residual2);
}

void FaceContacts::correct(const MovingCollider& collider, const Cloth& cloth, double h,
                           const std::vector<char>& held, LocalCloth& local,
                           std::vector<char>& moved) {
  if (!blocks_.fits(cloth)) blocks_.reset(cloth);
  const auto any_of = [](const auto& marks, const Corners& c, int mark) {
    return std::any_of(c.begin(), c.end(),
                       [&](int i) { return marks[static_cast<std::size_t>(i)] >= mark; });
  };
  std::vector<int> last_move(static_cast<std::size_t>(cloth.num_points()), 0);  // by pass
  for (int pass = 1; pass <= max_passes; ++pass) {
    bool again = false;
    const auto move_out = [&](int, const Corners& corners) {
      // In the first pass all, then those with a corner that has just moved.
      if (!any_of(last_move, corners, pass - 1)) return;
      if (!held.empty() && any_of(held, corners, 1)) return;
      const FaceApproach found = approach(collider, cloth, corners, local, cloth.offset);
      if (!found.distance) return;
      const double now = found.distance->value;
      const std::array<double, 3>& weights = found.distance->weights;
      const CornerWeights moves = moves_of(cloth, corners, weights);
      const double yield = yield_of(weights, moves);
      if (yield == 0) return;
      const double in_reach = lever_of(cloth, corners, weights) * h;
      const double wanted = found.before < 0
                                ? required_distance(found.before, cloth.offset, in_reach)
                                : raised(now, cloth.offset);
      const bool must = now < wanted - grace * surface_offset;
      if (!must && (pass > 1 || now >= cloth.offset)) return;
      spread(corners, moves, (wanted - now) / yield * found.distance->normal, local.to);
      for (const int i : corners) {
        if (cloth.inv_mass[i] == 0) continue;
        if (must) last_move[static_cast<std::size_t>(i)] = pass;
        moved[static_cast<std::size_t>(i)] = 1;
        local.distance[i] =
            signed_distance(collider.shape(), local.to.row(i), local.from.row(i)).value;
      }
      again = again || must;
    };
    for_each_near(collider.shape(), cloth, blocks_, local, cloth.offset, move_out);
    if (!again) break;
  }
}

int FaceContacts::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.impulse.push > 0; }));
}

void FaceContacts::reset() { contacts_.clear(); }

void FaceContacts::write(MemoryWriter& memory) const {
  memory.add(count());
  for (const Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    memory.add(c.id.collider);
    memory.add(c.id.triangle);
    memory.add(c.id.feature);
    c.impulse.write(memory);
  }
}

void FaceContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  for (std::size_t left = memory.count(); left > 0; --left) {
    Contact c{};
    c.id.collider = memory.index(colliders);
    c.id.triangle = memory.index(cloth.triangles.size());
    c.id.feature = memory.index(features);
    c.impulse.read(memory);
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
