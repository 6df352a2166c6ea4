#include "clothsim/collision/collider_contacts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace clothsim {
namespace {

/// A point in the frame of a collider.
Vector3 to_local(const Pose& pose, const Vector3& point) {
  return pose.orientation.conjugate() * (point - pose.position);
}

Vector3 row(const Points& points, int i) { return points.row(i).transpose(); }

/// Bounds of a cloth on its way through a step.
Eigen::AlignedBox3d bounds(const Points& start, const Points& end) {
  Eigen::AlignedBox3d box(start.colwise().minCoeff().transpose(),
                          start.colwise().maxCoeff().transpose());
  box.extend(Vector3(end.colwise().minCoeff().transpose()));
  box.extend(Vector3(end.colwise().maxCoeff().transpose()));
  return box;
}

/// False where no point in `box` can be within `margin` [m] of the collider.
bool in_reach(const MovingCollider& collider, const Eigen::AlignedBox3d& box, double margin) {
  const double radius = bounding_radius(collider.shape());
  if (std::isfinite(radius)) {
    const Eigen::AlignedBox3d path =
        Eigen::AlignedBox3d(collider.previous().position).extend(collider.pose().position);
    return std::sqrt(box.squaredExteriorDistance(path)) <= radius + margin;
  }
  // A plane: the corner of the box that lies deepest.
  const Vector3 normal = collider.pose().orientation * Vector3::UnitZ();
  const Vector3 half = box.sizes() / 2;
  const double middle = normal.dot(box.center() - collider.pose().position);
  const double spread = normal.cwiseAbs().dot(half);
  const Plane* plane = std::get_if<Plane>(&collider.shape());
  return (plane && plane->two_sided ? std::abs(middle) : middle) - spread <= margin;
}

/// Where a point that may have passed through the shape in one step came in.
std::optional<Vector3> swept_entry(const Shape& shape, const Vector3& from, const Vector3& to) {
  const double depth = safe_depth(shape);
  if ((to - from).squaredNorm() <= depth * depth) return std::nullopt;
  return entry_point(shape, from, to, surface_offset);
}

}  // namespace

void ColliderContacts::begin(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                             double h, double reach, const Points& start, const Points& drifted,
                             State& state) {
  const double scale = h_ > 0 ? h / h_ : 0;
  h_ = h;
  last_.swap(contacts_);
  contacts_.clear();
  if (colliders.empty()) return;

  const Eigen::AlignedBox3d box = bounds(start, state.positions);
  const double fastest = std::sqrt(state.velocities.rowwise().squaredNorm().maxCoeff());
  std::size_t kept = 0;
  for (int k = 0; k < static_cast<int>(colliders.size()); ++k) {
    const MovingCollider& collider = colliders[static_cast<std::size_t>(k)];
    const Vector3 box_speed = collider.velocity_at(box.center());
    if (!in_reach(collider, box, h * (fastest + box_speed.norm()) + surface_offset)) continue;

    for (int i = 0; i < cloth.num_points(); ++i) {
      if (cloth.inv_mass[i] == 0) continue;
      const Vector3 from = to_local(collider.previous(), row(start, i));
      Vector3 to = to_local(collider.pose(), row(state.positions, i));

      // A point that may have passed through stops where it came in.
      const auto entry = swept_entry(collider.shape(), from, to);
      if (entry) {
        to = *entry;
        state.positions.row(i) =
            (collider.pose().position + collider.pose().orientation * to).transpose();
      }

      // The gap this step would leave if the point only followed the surface.
      const Distance d = signed_distance(collider.shape(), to, from);
      const Vector3 normal = collider.pose().orientation * d.normal;
      const Vector3 surface_velocity = collider.velocity_at(row(state.positions, i));
      const double rate = normal.dot(row(state.velocities, i) - surface_velocity);
      const double drift = normal.dot(row(drifted, i) - surface_velocity);
      const double gap = d.value - surface_offset - reach * h * drift;
      const double slowest = entry ? 0 : -std::max(gap, 0.0) / h;
      // The impulse that ends its approach will carry it on to where it came in.
      if (entry && drift < 0) state.positions.row(i) += reach * h * drift * normal.transpose();

      // The last step's impulse, if it was in contact.
      const auto id = std::make_tuple(k, i);
      while (kept < last_.size() && std::make_tuple(last_[kept].collider, last_[kept].point) < id) {
        ++kept;
      }
      const bool held = kept < last_.size() && last_[kept].collider == k &&
                        last_[kept].point == i && last_[kept].push > 0;
      // Others may yet push a point on the surface into it.
      if (!held && rate >= slowest && gap > 0) continue;

      Contact contact{k, i, normal, surface_velocity, slowest, collider.friction()};
      if (held) {
        contact.push = scale * last_[kept].push;
        const Vector3 drag = scale * last_[kept].drag;
        contact.drag = drag - normal.dot(drag) * normal;
        state.velocities.row(i) += (contact.push * normal + contact.drag).transpose();
      }
      contacts_.push_back(contact);
    }
  }
}

double ColliderContacts::sweep(Points& velocities) {
  double residual2 = 0;
  for (Contact& c : contacts_) {
    Vector3 v = row(velocities, c.point) - c.surface_velocity;

    // Off the surface, or towards it no faster than the gap allows.
    const double rate = c.normal.dot(v);
    const double push = std::max(0.0, c.push + c.slowest - rate);
    Vector3 change = (push - c.push) * c.normal;
    c.push = push;

    // Against sliding, as far as Coulomb's cone reaches.
    Vector3 drag = c.drag - (v - rate * c.normal);
    const double strongest = c.friction * push;
    const double length = drag.norm();
    if (length > strongest) drag *= strongest / length;
    change += drag - c.drag;
    c.drag = drag;

    velocities.row(c.point) += change.transpose();
    residual2 = std::max(residual2, change.squaredNorm());
  }
  return std::sqrt(residual2) * h_;
}

void ColliderContacts::correct(const std::vector<MovingCollider>& colliders, const Cloth& cloth,
                               const Points& start, Points& positions) const {
  const Eigen::AlignedBox3d box = bounds(start, positions);
  for (const MovingCollider& collider : colliders) {
    if (!in_reach(collider, box, surface_offset)) continue;
    for (int i = 0; i < cloth.num_points(); ++i) {
      if (cloth.inv_mass[i] == 0) continue;
      const Vector3 from = to_local(collider.previous(), row(start, i));
      Vector3 to = to_local(collider.pose(), row(positions, i));
      const auto entry = swept_entry(collider.shape(), from, to);
      if (entry) to = *entry;
      const Distance d = signed_distance(collider.shape(), to, from);
      if (!entry && d.value >= surface_offset) continue;
      to += std::max(0.0, surface_offset - d.value) * d.normal;
      positions.row(i) = (collider.pose().position + collider.pose().orientation * to).transpose();
    }
  }
}

int ColliderContacts::count() const {
  return static_cast<int>(std::count_if(contacts_.begin(), contacts_.end(),
                                        [](const Contact& c) { return c.push > 0; }));
}

void ColliderContacts::reset() {
  contacts_.clear();
  h_ = 0;
}

void ColliderContacts::write(MemoryWriter& memory) const {
  memory.add(h_);
  memory.add(count());
  for (const Contact& c : contacts_) {
    if (c.push == 0) continue;
    memory.add(c.collider);
    memory.add(c.point);
    memory.add(c.push);
    memory.add(c.drag);
  }
}

void ColliderContacts::read(MemoryReader& memory, std::size_t colliders, const Cloth& cloth) {
  reset();
  h_ = std::max(0.0, memory.number());
  for (std::size_t left = memory.count(); left > 0; --left) {
    const int collider = memory.index(colliders);
    const int point = memory.index(static_cast<std::size_t>(cloth.num_points()));
    Contact c{collider, point, Vector3::Zero(), Vector3::Zero(), 0, 0};
    c.push = std::max(0.0, memory.number());
    c.drag = memory.vector();
    contacts_.push_back(c);
  }
}

}  // namespace clothsim
