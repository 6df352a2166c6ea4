#include "clothsim/collision/face_contacts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clothsim/collision/swept_face.h"
#include "clothsim/model/surface.h"

namespace clothsim {
namespace {

using Corners = std::array<int, 3>;

/// Passes that take triangles out of a collider, each of which may move its neighbours in.
constexpr int max_passes = 50;

/// How much of the offset may be used up before a triangle is moved.
constexpr double play = 0.1;

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

bool at_corner(const std::array<double, 3>& w) { return std::max({w[0], w[1], w[2]}) == 1; }

/// Calls visit(triangle, corners) where any point of the triangle may be within `margin` [m].
template <class Visit>
void for_each_near(const Cloth& cloth, const LocalCloth& local, double margin, Visit visit) {
  double edge = longest_edge_within_limit(cloth);
  if (std::isinf(edge)) edge = longest_edge(local.to, cloth.triangles);
  const double far = margin + edge / std::sqrt(3);  // of the nearest corner
  for (std::size_t t = 0; t < cloth.triangles.size(); ++t) {
    const Corners& c = cloth.triangles[t];
    const double nearest =
        std::min({local.distance[c[0]], local.distance[c[1]], local.distance[c[2]]});
    if (nearest <= far) visit(static_cast<int>(t), c);
  }
}

/// Distance of a triangle at a step's end, and whether it is that of a sweep.
struct Approach {
  std::optional<FaceDistance> distance;
  double before = 0;  // [m] at the step's start, where negative
  bool swept = false;
};

Approach approach(const MovingCollider& collider, const Corners& corners, const LocalCloth& local,
                  double margin) {
  const Shape& shape = collider.shape();
  const Triangle from = triangle_of(local.from, corners), to = triangle_of(local.to, corners);
  Approach result;
  result.distance = face_distance(shape, to, margin);

  double way2 = 0;
  for (std::size_t i = 0; i < 3; ++i) way2 = std::max(way2, (to[i] - from[i]).squaredNorm());
  const double depth = safe_depth(shape);
  const bool inside = result.distance && result.distance->value < 0;
  if (!inside && way2 <= depth * depth) return result;

  // It may have been in the solid before, or have come through it.
  const auto before = face_distance(shape, from, 0);
  if (before && before->value < 0) {
    result.before = before->value;
  } else if (way2 > depth * depth || (inside && result.distance->value < -depth)) {
    const auto swept = swept_face_distance(collider, to_world(collider.previous(), from),
                                           to_world(collider.pose(), to), surface_offset);
    if (swept && (!result.distance || swept->value < result.distance->value || inside)) {
      result.distance = swept;
      result.swept = swept->value < surface_offset;
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

const FaceContacts::Contact* FaceContacts::last_of(int collider, int triangle) {
  const auto id = std::make_tuple(collider, triangle);
  const auto id_of = [](const Contact& c) { return std::make_tuple(c.collider, c.triangle); };
  while (next_last_ < last_.size() && id_of(last_[next_last_]) < id) ++next_last_;
  if (next_last_ == last_.size() || id_of(last_[next_last_]) != id) return nullptr;
  return last_[next_last_].impulse.push > 0 ? &last_[next_last_] : nullptr;
}

void FaceContacts::find(int index, const MovingCollider& collider, const Cloth& cloth,
                        const ContactStep& step, double margin, LocalCloth& local, State& state,
                        std::vector<CaughtFace>& caught) {
  const Eigen::Matrix3d turn = collider.pose().orientation.toRotationMatrix();
  for_each_near(cloth, local, margin, [&](int triangle, const Corners& corners) {
    const Approach found = approach(collider, corners, local, margin);
    if (!found.distance || (at_corner(found.distance->weights) && found.before == 0)) return;
    const std::array<double, 3>& weights = found.distance->weights;
    const double yield = yield_of(cloth, corners, weights);
    if (yield == 0) return;

    const Vector3 normal = turn * found.distance->normal;
    const Vector3 surface_velocity =
        collider.velocity_at(weighted(state.positions, corners, weights));
    const double drift = normal.dot(weighted(step.drifted, corners, weights) - surface_velocity);
    if (found.swept) {
      // Back to where it came in, less what the impulse that ends its approach will move it.
      const double back =
          surface_offset - found.distance->value + step.reach * step.h * std::min(0.0, drift);
      spread(cloth, corners, weights, back / yield * normal, state.positions);
      spread(cloth, corners, weights, back / yield * found.distance->normal, local.to);
    }

    // The gap this step would leave if the triangle only followed the surface.
    const double rate = normal.dot(weighted(state.velocities, corners, weights) - surface_velocity);
    const double gap = found.distance->value - surface_offset - step.reach * step.h * drift;
    const double slowest = found.swept ? 0 : -std::max(gap, 0.0) / step.h;
    const Contact* last = last_of(index, triangle);
    if (!last && rate >= slowest && gap > 0) return;

    if (found.before < 0) caught.push_back({triangle, contacts_.size(), -found.before});
    contacts_.push_back({index,
                         triangle,
                         weights,
                         yield,
                         {normal, surface_velocity, slowest, collider.friction()}});
    if (last) contacts_.back().impulse.resume(last->impulse, 1);
  });
}

void FaceContacts::resume(const Cloth& cloth, double scale, std::size_t first, Points& velocities) {
  for (std::size_t i = first; i < contacts_.size(); ++i) {
    Contact& c = contacts_[i];
    if (c.impulse.push == 0) continue;
    c.impulse.resume(c.impulse, scale);
    spread(cloth, cloth.triangles[static_cast<std::size_t>(c.triangle)], c.weights,
           c.impulse.total(), velocities);
  }
}

double FaceContacts::sweep(const Cloth& cloth, Points& velocities) {
  double residual2 = 0;
  for (Contact& c : contacts_) {
    const Corners& corners = cloth.triangles[static_cast<std::size_t>(c.triangle)];
    const Vector3 change = c.impulse.update(weighted(velocities, corners, c.weights), c.yield);
    spread(cloth, corners, c.weights, change, velocities);
    residual2 = std::max(residual2, change.squaredNorm());
  }
  return std::sqrt(residual2);
}

void FaceContacts::correct(const MovingCollider& collider, const Cloth& cloth, double h,
                           const std::vector<char>& held, LocalCloth& local,
                           std::vector<char>& moved) const {
  // Those near enough that a neighbour's move may bring them in.
  const double margin = safe_depth(collider.shape());
  std::vector<int> near;
  for_each_near(cloth, local, margin, [&](int triangle, const Corners& c) {
    if (!held.empty() &&
        (held[static_cast<std::size_t>(c[0])] || held[static_cast<std::size_t>(c[1])] ||
         held[static_cast<std::size_t>(c[2])])) {
      return;
    }
    near.push_back(triangle);
  });

  std::vector<int> last_move(static_cast<std::size_t>(cloth.num_points()), 0);  // by pass
  for (int pass = 1; pass <= max_passes; ++pass) {
    bool again = false;
    for (const int triangle : near) {
      const Corners& corners = cloth.triangles[static_cast<std::size_t>(triangle)];
      const auto is_new = [&](int i) { return last_move[static_cast<std::size_t>(i)] >= pass - 1; };
      if (!is_new(corners[0]) && !is_new(corners[1]) && !is_new(corners[2])) continue;
      const Approach found = approach(collider, corners, local, surface_offset);
      if (!found.distance) continue;
      const double wanted = required_distance(found.before, surface_offset, h);
      if (found.distance->value >= wanted - play * surface_offset) continue;
      const std::array<double, 3>& weights = found.distance->weights;
      const double yield = yield_of(cloth, corners, weights);
      if (yield == 0) continue;
      spread(cloth, corners, weights,
             (wanted - found.distance->value) / yield * found.distance->normal, local.to);
      for (const int i : corners) {
        if (cloth.inv_mass[i] == 0) continue;
        last_move[static_cast<std::size_t>(i)] = pass;
        moved[static_cast<std::size_t>(i)] = 1;
      }
      again = true;
    }
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
    memory.add(c.collider);
    memory.add(c.triangle);
    memory.add(c.impulse.push);
    memory.add(c.impulse.drag);
  }
}

void FaceContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  for (std::size_t left = memory.count(); left > 0; --left) {
    Contact c{};
    c.collider = memory.index(colliders);
    c.triangle = memory.index(cloth.triangles.size());
    c.impulse.push = std::max(0.0, memory.number());
    c.impulse.drag = memory.vector();
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
