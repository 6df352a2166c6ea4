#include "clothsim/constraints/face_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clothsim/model/surface.h"
#include "clothsim/shapes/swept_face.h"

namespace clothsim {
namespace {

using Corners = std::array<int, 3>;

/// Passes that take triangles out of a collider, each of which may move its neighbours in.
constexpr int max_passes = 50;

/// How much of the offset more may be used up before a triangle is moved: others move it, too.
constexpr double grace = 0.1;

Triangle triangle_of(const Points& points, const Corners& corners) {
  return {points.row(corners[0]), points.row(corners[1]), points.row(corners[2])};
}

Triangle to_world(const Pose& pose, Triangle t) {
  for (Vector3& p : t) p = pose.position + pose.orientation * p;
  return t;
}

/// Sum of rows by weights.
Vector3 weighted(const Points& points, const Corners& corners,
                 const std::array<double, 3>& weights) {
  return (weights[0] * points.row(corners[0]) + weights[1] * points.row(corners[1]) +
          weights[2] * points.row(corners[2]))
      .transpose();
}

/// Adds a change to the free corners by their weights.
void spread(const Cloth& cloth, const Corners& corners, const std::array<double, 3>& weights,
            const Vector3& change, Points& points) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) points.row(corners[i]) += weights[i] * change.transpose();
  }
}

double yield_of(const Cloth& cloth, const Corners& corners, const std::array<double, 3>& weights) {
  double yield = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) yield += weights[i] * weights[i];
  }
  return yield;
}

bool any_held(const Cloth& cloth, const Corners& corners) {
  return std::any_of(corners.begin(), corners.end(), [&](int i) { return cloth.inv_mass[i] == 0; });
}

/// Velocity at a contact over that of the corner which moves fastest for it, where one is held:
/// next to that the free ones have long ways to go. 1 where all are free.
double lever_of(const Cloth& cloth, const Corners& corners, const std::array<double, 3>& weights) {
  if (!any_held(cloth, corners)) return 1;
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (cloth.inv_mass[corners[i]] > 0) largest = std::max(largest, weights[i]);
  }
  return largest > 0 ? yield_of(cloth, corners, weights) / largest : 0;
}

/// Is a corner held in the solid? Then so is the triangle.
bool is_held_inside(const Cloth& cloth, const Corners& corners, const LocalCloth& local) {
  return std::any_of(corners.begin(), corners.end(), [&](int i) {
    return cloth.inv_mass[i] == 0 && local.distance[i] < -surface_offset;
  });
}

/// How much further away a contact next to a held corner counts, so that it may sink in by as much:
/// by a lever without end a triangle could not rest on what it is pinned to [m].
double leeway(const Cloth& cloth, const Corners& corners, const Triangle& t,
              const std::array<double, 3>& weights) {
  constexpr double least_lever = 0.25;
  constexpr double most_share = 0.1;  // of the longest edge
  const double lever = lever_of(cloth, corners, weights);
  if (lever >= least_lever) return 0;
  const double edge = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  return most_share * edge * (1 - lever / least_lever);
}

/// As face_distance(), with that leeway.
std::optional<FaceDistance> distance_with_leeway(const Shape& shape, const Cloth& cloth,
                                                 const Corners& corners, const Triangle& t,
                                                 double margin) {
  std::optional<FaceDistance> distance = face_distance(shape, t, margin);
  if (distance) distance->value += leeway(cloth, corners, t, distance->weights);
  return distance;
}

/// Ways in which a triangle can touch: with its edges, from corner i to i + 1, with its face.
constexpr std::size_t features = 4;
constexpr std::size_t face = 3;

/// With which of them it does; empty where it touches with a corner alone.
std::optional<std::size_t> feature_of(const std::array<double, 3>& w) {
  const auto zeros = std::count(w.begin(), w.end(), 0.0);
  if (zeros > 1) return std::nullopt;
  if (zeros == 0) return face;
  return w[2] == 0 ? 0 : (w[0] == 0 ? 1 : 2);
}

/// May a point have passed through the shape in one step?
bool is_fast(const Shape& shape, const Vector3& way) {
  const double depth = safe_depth(shape);
  return way.squaredNorm() > depth * depth;
}

/// Calls visit(triangle, corners) where the triangle may touch within `margin` [m] with more than
/// its corners, or may have passed through.
template <class Visit>
void for_each_near(const Shape& shape, const Cloth& cloth, const TriangleBlocks& blocks,
                   const LocalCloth& local, double margin, Visit visit) {
  const double edge = std::isinf(local.edge) ? longest_edge(local.to, cloth.triangles) : local.edge;
  const double far = margin + edge / std::sqrt(3);  // of the nearest corner
  const double way = longest_row(local.to - local.from);
  const bool fast = way > safe_depth(shape);
  for (int b = 0; b < blocks.count(); ++b) {
    if (blocks.least(b, local.distance) > far + (fast ? way : 0)) continue;
    if (!fast && !touches_between_corners(shape, blocks.box(b, local.to), margin)) continue;
    for (std::size_t t = blocks.first_of(b); t < blocks.end_of(b); ++t) {
      const Corners& c = cloth.triangles[t];
      const Triangle to = triangle_of(local.to, c);
      const Eigen::AlignedBox3d box(to[0].cwiseMin(to[1]).cwiseMin(to[2]),
                                    to[0].cwiseMax(to[1]).cwiseMax(to[2]));
      if (!fast && !touches_between_corners(shape, box, margin)) continue;
      if (is_held_inside(cloth, c, local)) continue;
      visit(static_cast<int>(t), c);
    }
  }
}

/// Longest way of a corner between where impulses act and the step's end [m].
double to_middle(const LocalCloth& local, const Corners& corners) {
  double longest2 = 0;
  for (const int i : corners) {
    longest2 = std::max(longest2, (local.to.row(i) - local.middle.row(i)).squaredNorm());
  }
  return std::sqrt(longest2);
}

/// Distance of a triangle at a step's end, and whether it is that of a sweep.
struct Approach {
  std::optional<FaceDistance> distance;
  double before = 0;  // [m] at the step's start, where negative
  bool swept = false;
};

Approach approach(const MovingCollider& collider, const Cloth& cloth, const Corners& corners,
                  const LocalCloth& local, double margin) {
  const Shape& shape = collider.shape();
  const Triangle from = triangle_of(local.from, corners), to = triangle_of(local.to, corners);
  Approach result;
  result.distance = distance_with_leeway(shape, cloth, corners, to, margin);

  const bool fast = is_fast(shape, to[0] - from[0]) || is_fast(shape, to[1] - from[1]) ||
                    is_fast(shape, to[2] - from[2]);
  const bool inside = result.distance && result.distance->value < 0;
  if (!inside && !fast) return result;

  // It may have been in the solid before, or have come through it.
  const auto before = distance_with_leeway(shape, cloth, corners, from, 0);
  if (before && before->value < 0) {
    result.before = before->value;
  } else if (fast || result.distance->value < -safe_depth(shape)) {
    auto swept = swept_face_distance(collider, to_world(collider.previous(), from),
                                     to_world(collider.pose(), to), cloth.offset);
    if (swept) swept->value += leeway(cloth, corners, to, swept->weights);
    if (swept && (!result.distance || swept->value < result.distance->value)) {
      result.distance = swept;
      result.swept = swept->value < cloth.offset;
    }
  }
  return result;
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
  const bool fast = longest_row(local.to - local.from) > safe_depth(collider.shape());
  const auto look_at = [&](int triangle, const Corners& corners) {
    // As it lies where impulses act, unless it is to be stopped or led out.
    const Triangle middle = triangle_of(local.middle, corners);
    Approach found;
    found.distance = distance_with_leeway(collider.shape(), cloth, corners, middle, margin);
    const bool may_be_inside =
        fast || (found.distance && found.distance->value < to_middle(local, corners));
    if (may_be_inside) {
      const Approach at_end = approach(collider, cloth, corners, local, margin);
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
  const double yield = yield_of(cloth, corners, weights);
  if (yield == 0) return;
  const double lever = lever_of(cloth, corners, weights);

  const Vector3 normal = collider.pose().orientation * distance.normal;
  const Vector3 surface_velocity =
      collider.velocity_at(weighted(state.positions, corners, weights));
  const double drift = normal.dot(weighted(step.drifted, corners, weights) - surface_velocity);
  if (swept) {
    // Back to where it came in, less what the impulse that ends its approach will move it.
    const double back = cloth.offset - distance.value + step.reach * step.h * std::min(0.0, drift);
    spread(cloth, corners, weights, back / yield * normal, state.positions);
    spread(cloth, corners, weights, back / yield * distance.normal, local.to);
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
       yield,
       lever,
       {normal, surface_velocity, slowest + lever * way_out_speed(depth), collider.friction()}});
  if (last) contacts_.back().impulse.resume(last->impulse, 1);
}

void FaceContacts::resume(const Cloth& cloth, double scale, Points& velocities) {
  for (Contact& c : contacts_) {
    if (c.impulse.push == 0) continue;
    c.impulse.resume(c.impulse, scale);
    spread(cloth, cloth.triangles[static_cast<std::size_t>(c.id.triangle)], c.weights,
           c.impulse.total(), velocities);
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
    spread(cloth, corners, c.weights, change, velocities);
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
      const Approach found = approach(collider, cloth, corners, local, cloth.offset);
      if (!found.distance) return;
      const double now = found.distance->value;
      const std::array<double, 3>& weights = found.distance->weights;
      const double yield = yield_of(cloth, corners, weights);
      if (yield == 0) return;
      const double in_reach = lever_of(cloth, corners, weights) * h;
      const double wanted = found.before < 0
                                ? required_distance(found.before, cloth.offset, in_reach)
                                : raised(now, cloth.offset);
      const bool must = now < wanted - grace * surface_offset;
      if (!must && (pass > 1 || now >= cloth.offset)) return;
      spread(cloth, corners, weights, (wanted - now) / yield * found.distance->normal, local.to);
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
