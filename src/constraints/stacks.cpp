#include "clothsim/constraints/stacks.h"

#include <algorithm>
#include <map>
#include <set>

#include "clothsim/constraints/local_cloth.h"

namespace clothsim {
namespace {

/// Why a point has no node.
constexpr int not_seen = -1, not_between = -2;

using Box = Eigen::AlignedBox3d;

Box around(const ContactManifold& manifold, const Points& positions) {
  Box box;
  for (const ContactPoint& f : manifold.contact_points) {
    for (const int i : f.points) box.extend(row(positions, i));
  }
  return box;
}

/// The part of the manifold within the box.
ContactManifold within(const Box& box, const ContactManifold& manifold, const Points& positions) {
  ContactManifold result{manifold.collider, manifold.offset, {}};
  for (const ContactPoint& f : manifold.contact_points) {
    if (box.contains(f.place(positions))) result.contact_points.push_back(f);
  }
  return result;
}

/// Distance to a point at the step's start, before any layers between are known.
Pinches::ColliderDistance distance_to(const ContactManifold& manifold, const Vector3& x) {
  const Pose& pose = manifold.collider.previous();
  const Vector3 local = to_local(pose, x);
  const Distance d = signed_distance(manifold.collider.shape(), local, local);
  return {&manifold.collider, pose.orientation * d.normal, d.value, 0, 0, false};
}

Pinches::ColliderDistance touching(const ContactManifold& manifold, const ContactPoint& f,
                                   Pinches::ColliderDistance side) {
  side.layer_height = manifold.offset - f.nearer;
  side.touches = true;
  return side;
}

/// Distance of the manifold's own contact.
Pinches::ColliderDistance own_distance(const ContactManifold& manifold, const ContactPoint& f,
                                       const Points& start) {
  if (f.triangle == ContactPoint::no_triangle) {
    return touching(manifold, f, distance_to(manifold, f.place(start)));
  }
  return touching(manifold, f, {&manifold.collider, f.normal, f.distance, 0, 0, false});
}

/// The contacts of a manifold by point and triangle.
class ContactPointIndex {
 public:
  explicit ContactPointIndex(const ContactManifold& manifold) : manifold_(manifold) {
    for (const ContactPoint& f : manifold.contact_points) {
      if (f.triangle == ContactPoint::no_triangle) {
        points_.insert(f.points[0]);
      } else {
        triangles_[f.triangle].push_back(&f);
      }
    }
  }

  /// Contacts within that triangle.
  std::vector<const ContactPoint*> on(int triangle) const {
    const auto found = triangles_.find(triangle);
    return found == triangles_.end() ? std::vector<const ContactPoint*>() : found->second;
  }

  /// Distance of the collider from a contact of the other one. It touches there if it touches the
  /// points.
  Pinches::ColliderDistance beyond(const ContactPoint& f, const Points& start) const {
    bool touches = true;
    for (std::size_t k = 0; k < 3; ++k) {
      touches = touches && (f.weights[k] == 0 || points_.count(f.points[k]) > 0);
    }
    const Pinches::ColliderDistance side = distance_to(manifold_, f.place(start));
    return touches ? touching(manifold_, f, side) : side;
  }

 private:
  const ContactManifold& manifold_;
  std::set<int> points_;
  std::map<int, std::vector<const ContactPoint*>> triangles_;
};

}  // namespace

bool can_face(const Normals& a, const Normals& b) {
  if (a.isEmpty() || b.isEmpty()) return false;
  double min_product = 0;  // bound on the scalar product of two normals
  for (int axis = 0; axis < 3; ++axis) {
    const double p[] = {a.min()[axis], a.max()[axis]};
    const double q[] = {b.min()[axis], b.max()[axis]};
    min_product += std::min({p[0] * q[0], p[0] * q[1], p[1] * q[0], p[1] * q[1]});
  }
  return min_product <= -Pinches::facing;
}

void Stacks::pinch(const ContactManifold& all_of_a, const ContactManifold& all_of_b,
                   const Cloth& cloth, const Points& start, double h, const SelfTouches* touches,
                   Pinches& pinches) {
  if (all_of_a.contact_points.empty() || all_of_b.contact_points.empty()) return;
  const double max_distance =
      Stacks::max_layer_height(cloth, std::max(all_of_a.offset, all_of_b.offset));
  const Vector3 margin = Vector3::Constant(max_distance);
  const auto wider = [&](Box box) { return Box(box.min() - margin, box.max() + margin); };
  const ContactManifold a = within(wider(around(all_of_b, start)), all_of_a, start);
  const ContactManifold b = within(wider(around(all_of_a, start)), all_of_b, start);
  if (a.contact_points.empty() || b.contact_points.empty()) return;

  nodes_.clear();
  edges_.clear();
  node_of_.assign(static_cast<std::size_t>(cloth.num_points()), not_seen);
  add_contact_points(a, b, start);
  if (nodes_.empty()) return;
  if (touches) add_edges(a, b, start, max_distance, *touches);
  propagate_heights();
  for (const Node& node : nodes_) {
    if (node.a.layer_height == 0 || node.b.layer_height == 0) {
      continue;  // no chain of layers to one of the colliders
    }
    if (node.a.touches && node.b.touches && !node.is_between) continue;  // beside each other
    const Vector3 x = row(start, node.point);
    // Layers that are hit faster than recovery_speed are no grip: impulses let piles fly apart.
    const double speed = (b.collider.velocity_at(x) - a.collider.velocity_at(x)).norm();
    if (!node.is_between && speed > recovery_speed) continue;
    if (Pinches::leave_no_room(node.a, node.b, x, h)) {
      pinches.add(node.point, x, node.a, node.b, cloth);
    }
  }
}

void Stacks::add_contact_points(const ContactManifold& a, const ContactManifold& b,
                                const Points& start) {
  const ContactPointIndex on_a(a), on_b(b);
  const auto take = [&](const ContactPoint& f, const Pinches::ColliderDistance& of_a,
                        const Pinches::ColliderDistance& of_b) {
    if (!Pinches::face_each_other(of_a.normal, of_b.normal)) return;
    for (const int i : f.points) add(i, of_a, of_b);
  };
  for (const ContactPoint& f : a.contact_points) {
    const Pinches::ColliderDistance of_a = own_distance(a, f, start);
    const auto same = on_b.on(f.triangle);
    if (same.empty()) take(f, of_a, on_b.beyond(f, start));
    for (const ContactPoint* other : same) take(f, of_a, own_distance(b, *other, start));
  }
  for (const ContactPoint& f : b.contact_points) {
    if (on_a.on(f.triangle).empty()) take(f, on_a.beyond(f, start), own_distance(b, f, start));
  }
}

void Stacks::add(int point, const Pinches::ColliderDistance& a,
                 const Pinches::ColliderDistance& b) {
  const bool is_between = a.touches && b.touches;
  int& number = node_of_[static_cast<std::size_t>(point)];
  if (number < 0) {
    number = static_cast<int>(nodes_.size());
    nodes_.push_back({point, is_between, a, b});
    return;
  }
  Node& node = nodes_[static_cast<std::size_t>(number)];
  const bool is_nearer = a.distance + b.distance < node.a.distance + node.b.distance;
  const bool counts = is_between == node.is_between ? is_nearer : is_between;
  node.is_between = node.is_between || is_between;
  const auto merge = [&](Pinches::ColliderDistance& side, const Pinches::ColliderDistance& now) {
    if (counts) {
      side.normal = now.normal;
      side.distance = now.distance;
    }
    side.touches = side.touches || now.touches;
    if (now.layer_height > side.layer_height) {
      side.layer_height = now.layer_height;
      side.layers = now.layers;
    }
  };
  merge(node.a, a);
  merge(node.b, b);
}

int Stacks::node_between(int point, const ContactManifold& a, const ContactManifold& b,
                         const Points& start, double max_distance) {
  int& number = node_of_[static_cast<std::size_t>(point)];
  if (number != not_seen) return number;
  const Vector3 x = row(start, point);
  number = not_between;
  const Pinches::ColliderDistance of_a = distance_to(a, x);
  if (of_a.distance > max_distance) return number;
  const Pinches::ColliderDistance of_b = distance_to(b, x);
  if (of_a.distance + of_b.distance > max_distance) return number;
  if (Pinches::face_each_other(of_a.normal, of_b.normal)) add(point, of_a, of_b);
  return number;
}

void Stacks::add_edges(const ContactManifold& a, const ContactManifold& b, const Points& start,
                       double max_distance, const SelfTouches& touches) {
  touches([&](const SelfTouch& touch) {
    for (std::size_t p = 0; p < 4; ++p) {
      if (touch.weights[p] <= 0) continue;
      const int upper = node_between(touch.points[p], a, b, start, max_distance);
      if (upper < 0) continue;
      for (std::size_t q = 0; q < 4; ++q) {
        if (touch.weights[q] >= 0) continue;
        const int lower = node_between(touch.points[q], a, b, start, max_distance);
        if (lower < 0) continue;
        const Pinches::ColliderDistance &of_upper = nodes_[static_cast<std::size_t>(upper)].a,
                                        &of_lower = nodes_[static_cast<std::size_t>(lower)].a;
        const double cosine = touch.normal.dot(of_upper.normal);
        // In this order chains have no cycle.
        if (cosine > Pinches::facing && of_upper.distance > of_lower.distance) {
          edges_.push_back({lower, upper, touch.nearest});
        } else if (cosine < -Pinches::facing && of_upper.distance < of_lower.distance) {
          edges_.push_back({upper, lower, touch.nearest});
        }
      }
    }
  });
}

/// Finds the longest chains from either collider. It ends, since chains have no cycle.
void Stacks::propagate_heights() {
  const auto raise = [](Pinches::ColliderDistance& to, const Pinches::ColliderDistance& from,
                        double layer_height) {
    if (from.layer_height == 0 || to.layer_height >= from.layer_height + layer_height) return false;
    to.layer_height = from.layer_height + layer_height;
    to.layers = from.layers + 1;
    to.touches = false;
    return true;
  };
  for (bool rises = true; rises;) {
    rises = false;
    for (const Edge& edge : edges_) {
      Node& below = nodes_[static_cast<std::size_t>(edge.below)];
      Node& above = nodes_[static_cast<std::size_t>(edge.above)];
      const bool from_a = raise(above.a, below.a, edge.layer_height);
      const bool from_b = raise(below.b, above.b, edge.layer_height);
      rises = rises || from_a || from_b;
    }
  }
}

}  // namespace clothsim
