#include "clothsim/constraints/rigid_bodies.h"

#include <algorithm>
#include <cmath>

#include "clothsim/shapes/mass_properties.h"

namespace clothsim {
namespace {

Matrix3 in_world(const Matrix3& tensor, const Eigen::Quaterniond& orientation) {
  const Matrix3 turn = orientation.toRotationMatrix();
  return turn * tensor * turn.transpose();
}

/// A pose displaced by `way` [m] and turned by a vector of axis times angle about the point
/// `center` of its frame.
Pose moved(const Pose& pose, const Vector3& center, const Vector3& way, const Vector3& turn) {
  const Eigen::Quaterniond orientation = turned(pose.orientation, turn);
  return {to_world(pose, center) + way - orientation * center, orientation};
}

}  // namespace

RigidBodies::RigidBodies(const std::vector<ColliderSpec>& colliders) {
  bodies_.resize(colliders.size());
  motions_.resize(colliders.size());
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const std::optional<BodySpec>& spec = colliders[k].body;
    const double radius = bounding_radius(colliders[k].shape);
    radii_.push_back(std::isfinite(radius) ? radius : 0);
    if (!spec) continue;
    const MassProperties even = mass_properties(colliders[k].shape).value_or(MassProperties());
    Body body{};
    body.mass = spec->mass;
    body.damping = spec->damping;
    body.center = spec->center_of_mass.value_or(even.center);
    body.inertia = spec->inertia.value_or(spec->mass * even.inertia);
    body.inv_inertia = body.inertia.inverse();
    bodies_[k] = body;
    radii_.back() += body.center.norm();
    mass_ += body.mass;
    least_depth_ = std::min(least_depth_, safe_depth(colliders[k].shape));
    ++bodies_in_scene_;
  }
}

void RigidBodies::put(const Pose& pose, const RigidMotion& motion, MovingCollider& collider) {
  collider.move_to(pose, motion.velocity_at(pose.position), motion.angular_velocity);
}

void RigidBodies::set_velocity(std::size_t k, const Vector3& velocity,
                               const Vector3& angular_velocity, MovingCollider& collider) {
  RigidMotion& motion = motions_[k];
  motion.center = to_world(collider.pose(), bodies_[k]->center);
  motion.velocity = velocity;
  motion.angular_velocity = angular_velocity;
  collider.begin_step();
  put(collider.pose(), motion, collider);
}

void RigidBodies::move_freely(Body& body, RigidMotion& motion, double h, const Vector3& gravity,
                              const Pose& from) {
  const double kept = std::exp(-body.damping * h);
  motion.velocity *= kept;
  motion.angular_velocity *= kept;
  const Vector3 momentum = in_world(body.inertia, from.orientation) * motion.angular_velocity;
  const Eigen::Quaterniond halfway = turned(from.orientation, h / 2 * motion.angular_velocity);
  const Vector3 turning = in_world(body.inv_inertia, halfway) * momentum;
  const Vector3 way = h * motion.velocity + displacement_factor * h * h * gravity;
  body.pose = moved(from, body.center, way, h * turning);
  motion.inv_mass = 1 / body.mass;
  motion.inv_inertia = in_world(body.inv_inertia, body.pose.orientation);
  motion.center = to_world(body.pose, body.center);
  motion.velocity += h * gravity;
  motion.angular_velocity = motion.inv_inertia * momentum;
  body.velocity = motion.velocity;
  body.turning = motion.angular_velocity;
}

void RigidBodies::begin_step(double h, const Vector3& gravity,
                             std::vector<MovingCollider>& colliders) {
  h_ = h;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    MovingCollider& collider = colliders[k];
    if (is_body(k)) {
      collider.begin_step();
      move_freely(*bodies_[k], motions_[k], h, gravity, collider.pose());
      put(bodies_[k]->pose, motions_[k], collider);
    } else {
      motions_[k].center = collider.pose().position;
      motions_[k].velocity = collider.velocity();
      motions_[k].angular_velocity = collider.angular_velocity();
    }
  }
}

double RigidBodies::speed_of_surface(std::size_t k) const {
  return motions_[k].velocity.norm() + radii_[k] * motions_[k].angular_velocity.norm();
}

double RigidBodies::fastest_surface() const {
  double fastest = 0;
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    if (is_body(k)) fastest = std::max(fastest, speed_of_surface(k));
  }
  return fastest;
}

double RigidBodies::longest_way(double h) const {
  double fastest = 0, slower = 0;  // the two fastest surfaces
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    const double speed = speed_of_surface(k);
    slower = std::max(slower, std::min(speed, fastest));
    fastest = std::max(fastest, speed);
  }
  return h * (fastest + slower);
}

void RigidBodies::end_step(const std::vector<RigidMotion>& pushes,
                           std::vector<MovingCollider>& colliders) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!is_body(k)) continue;
    const Body& body = *bodies_[k];
    RigidMotion& motion = motions_[k];
    Vector3 way = displacement_factor * h_ * (motion.velocity - body.velocity);
    Vector3 turn = displacement_factor * h_ * (motion.angular_velocity - body.turning);
    if (!pushes.empty()) {
      way += pushes[k].velocity;
      turn += pushes[k].angular_velocity;
    }
    const Pose pose = moved(body.pose, body.center, way, turn);
    const Vector3 momentum =
        in_world(body.inertia, body.pose.orientation) * motion.angular_velocity;
    motion.angular_velocity = in_world(body.inv_inertia, pose.orientation) * momentum;
    motion.center = to_world(pose, body.center);
    put(pose, motion, colliders[k]);
  }
}

void RigidBodies::write(MemoryWriter& memory) const {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (!is_body(k)) continue;
    memory.add(motions_[k].velocity);
    memory.add(motions_[k].angular_velocity);
  }
}

void RigidBodies::read(MemoryReader& memory) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (!is_body(k)) continue;
    motions_[k].velocity = memory.vector();
    motions_[k].angular_velocity = memory.vector();
  }
}

}  // namespace clothsim
