#include "clothsim/constraints/rigid_bodies.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "clothsim/shapes/mass_properties.h"

namespace clothsim {
namespace {

/// Largest force between two colliders, in weights of the bodies that they carry.
constexpr double strongest_squeeze = 100;

/// The same at one of many places, where all of a body may stand that leans or rocks.
constexpr double strongest_at_a_place = 5;

Matrix3 in_world(const Matrix3& tensor, const Eigen::Quaterniond& orientation) {
  const Matrix3 turn = orientation.toRotationMatrix();
  return turn * tensor * turn.transpose();
}

/// A pose displaced by `displacement` [m] and turned by a vector of axis times angle about the
/// point `center` of its frame.
Pose moved(const Pose& pose, const Vector3& center, const Vector3& displacement,
           const Vector3& turn) {
  const Eigen::Quaterniond orientation = turned(pose.orientation, turn);
  return {to_world(pose, center) + displacement - orientation * center, orientation};
}

bool is_slider(const std::optional<Joint>& joint) {
  return joint && joint->kind == Joint::Kind::slider;
}

bool is_hinge(const std::optional<Joint>& joint) {
  return joint && joint->kind == Joint::Kind::hinge;
}

Matrix3 projection_on(const Vector3& unit) { return unit * unit.transpose(); }

}  // namespace

RigidBodies::RigidBodies(const std::vector<ColliderSpec>& colliders)
    : bodies_(colliders.size()),
      leader_(colliders.size()),
      offsets_(colliders.size()),
      motions_(colliders.size()),
      group_(colliders.size()) {
  std::iota(group_.begin(), group_.end(), 0);
  last_group_ = group_;
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    leader_[k] = k;
    if (colliders[k].body) add_body(k, colliders[k]);
  }
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const ColliderSpec& spec = colliders[k];
    for (std::size_t l = 0; l < colliders.size() && !spec.part_of.empty(); ++l) {
      if (colliders[l].body && colliders[l].name == spec.part_of) leader_[k] = l;
    }
    const double radius = bounding_radius(spec.shape);
    radii_.push_back(std::isfinite(radius) ? radius : 0);
    if (!of(k)) continue;
    const Body& body = *of(k);
    const Pose pose = spec.pose * spec.offset;
    offsets_[k] = {to_local(body.start, pose.position),
                   body.start.orientation.conjugate() * pose.orientation};
    const Vector3 center =
        is_hinge(body.joint) ? body.joint->point : to_world(body.start, body.center);
    radii_.back() += (pose.position - center).norm();
    least_depth_ = std::min(least_depth_, safe_depth(spec.shape));
  }
}

void RigidBodies::add_body(std::size_t k, const ColliderSpec& collider) {
  const BodySpec& spec = *collider.body;
  const MassProperties even = mass_properties(collider.shape).value_or(MassProperties());
  Body body{};
  body.mass = spec.mass;
  body.damping = spec.damping;
  body.center = spec.center_of_mass.value_or(even.center);
  body.inertia = spec.inertia.value_or(spec.mass * even.inertia);
  body.inv_inertia = body.inertia.inverse();
  body.joint = spec.joint;
  body.start = collider.pose * collider.offset;
  if (is_hinge(body.joint)) {
    const Vector3& axis = body.joint->axis;
    const Vector3 arm = to_world(body.start, body.center) - body.joint->point;
    body.joint_inertia = axis.dot(in_world(body.inertia, body.start.orientation) * axis) +
                         body.mass * axis.cross(arm).squaredNorm();
  }
  bodies_[k] = body;
  mass_ += body.mass;
  ++bodies_in_scene_;
}

void RigidBodies::touch(std::size_t collider, std::size_t other) {
  if (!is_body(collider) || !is_body(other)) return;
  const std::size_t a = group_[leader_[collider]], b = group_[leader_[other]];
  std::replace(group_.begin(), group_.end(), std::max(a, b), std::min(a, b));
}

double RigidBodies::mass_touching(std::size_t collider, std::size_t other) const {
  double most = 0;
  for (const std::size_t k : {leader_[collider], leader_[other]}) {
    double mass = 0;
    for (std::size_t l = 0; l < bodies_.size(); ++l) {
      const bool touches = group_[l] == group_[k] || last_group_[l] == last_group_[k];
      if (is_body(k) && is_body(l) && leads(l) && touches) mass += bodies_[l]->mass;
    }
    most = std::max(most, mass);
  }
  return most;
}

double RigidBodies::strongest_force(std::size_t collider, std::size_t other, int places,
                                    double gravity) const {
  return std::max(strongest_squeeze / places, strongest_at_a_place) *
         mass_touching(collider, other) * gravity;
}

void RigidBodies::put(std::size_t leader, const Pose& pose,
                      std::vector<MovingCollider>& colliders) const {
  const RigidMotion& motion = motions_[leader];
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (leader_[k] != leader) continue;
    const Pose of_part = pose_of(k, pose);
    colliders[k].move_to(of_part, motion.velocity_at(of_part.position), motion.angular_velocity);
  }
}

void RigidBodies::start(const std::vector<ColliderSpec>& specs,
                        std::vector<MovingCollider>& colliders) {
  for (std::size_t k = 0; k < specs.size(); ++k) {
    if (!leads(k)) continue;
    bodies_[k]->held = false;
    bodies_[k]->displacement = 0;
    group_[k] = k;
    set_velocity(k, specs[k].body->velocity, specs[k].body->angular_velocity, colliders);
  }
}

void RigidBodies::set_velocity(std::size_t k, const Vector3& velocity,
                               const Vector3& angular_velocity,
                               std::vector<MovingCollider>& colliders) {
  RigidMotion& motion = motions_[k];
  Body& body = *bodies_[k];
  const Pose& pose = colliders[k].pose();
  motion.center = is_hinge(body.joint) ? body.joint->point : to_world(pose, body.center);
  motion.velocity = velocity;
  motion.angular_velocity = angular_velocity;
  if (body.joint) {
    const Matrix3 free = projection_on(body.joint->axis);
    motion.velocity = is_slider(body.joint) ? Vector3(free * velocity) : Vector3::Zero();
    motion.angular_velocity =
        is_hinge(body.joint) ? Vector3(free * angular_velocity) : Vector3::Zero();
    body.displacement = nearest_displacement(body, pose);
  }
  for (std::size_t part = 0; part < colliders.size(); ++part) {
    if (leader_[part] == k) colliders[part].begin_step();
  }
  put(k, pose, colliders);
}

/// The pose of a body with a joint at a displacement of it.
Pose RigidBodies::on_joint(const Body& body, double displacement) {
  const Vector3 along = displacement * body.joint->axis;
  if (is_slider(body.joint)) return {body.start.position + along, body.start.orientation};
  return moved(body.start, to_local(body.start, body.joint->point), Vector3::Zero(), along);
}

/// The displacement within its limits at which a joint is nearest to a pose; of the turns of a
/// hinge the one that is nearest to the present displacement.
double RigidBodies::nearest_displacement(const Body& body, const Pose& pose) {
  const Joint& joint = *body.joint;
  if (is_slider(body.joint)) {
    const double displacement = joint.axis.dot(pose.position - body.start.position);
    return std::clamp(displacement, joint.lower, joint.upper);
  }
  constexpr double turn = 2 * M_PI;
  const Eigen::Quaterniond turned = pose.orientation * body.start.orientation.conjugate();
  const double angle = 2 * std::atan2(joint.axis.dot(turned.vec()), turned.w());
  double nearest = angle + turn * std::round((body.displacement - angle) / turn);
  if (nearest < joint.lower) nearest += turn * std::ceil((joint.lower - nearest) / turn);
  if (nearest > joint.upper) nearest -= turn * std::ceil((nearest - joint.upper) / turn);
  return std::clamp(nearest, joint.lower, joint.upper);
}

Pose RigidBodies::nearest_allowed(std::size_t leader, const Pose& pose) const {
  const Body& body = *bodies_[leader];
  return body.joint ? on_joint(body, nearest_displacement(body, pose)) : pose;
}

double RigidBodies::distance_from_joint(std::size_t leader, const Pose& pose) const {
  const Pose nearest = nearest_allowed(leader, pose);
  return std::max((pose.position - nearest.position).norm(),
                  pose.orientation.angularDistance(nearest.orientation));
}

void RigidBodies::set_held(std::size_t leader, const Pose& pose, bool keeps_velocity) {
  RigidMotion& motion = motions_[leader];
  motion.center = pose.position;
  if (keeps_velocity) return;
  motion.velocity.setZero();
  motion.angular_velocity.setZero();
}

void RigidBodies::move_freely(Body& body, RigidMotion& motion, double h, const Vector3& gravity,
                              const Pose& from) {
  const Vector3 momentum = in_world(body.inertia, from.orientation) * motion.angular_velocity;
  const Eigen::Quaterniond halfway = turned(from.orientation, h / 2 * motion.angular_velocity);
  const Vector3 turning = in_world(body.inv_inertia, halfway) * momentum;
  const Vector3 displacement = h * motion.velocity + displacement_factor * h * h * gravity;
  body.pose = moved(from, body.center, displacement, h * turning);
  motion.least_inv_mass = 1 / body.mass;
  motion.inv_mass = motion.least_inv_mass * Matrix3::Identity();
  motion.inv_inertia = in_world(body.inv_inertia, body.pose.orientation);
  motion.center = to_world(body.pose, body.center);
  motion.velocity += h * gravity;
  motion.angular_velocity = motion.inv_inertia * momentum;
}

void RigidBodies::slide(Body& body, RigidMotion& motion, double h, const Vector3& gravity) {
  const Vector3& axis = body.joint->axis;
  const double acceleration = axis.dot(gravity);
  const double speed = axis.dot(motion.velocity);
  body.at_impulses = body.displacement + h * speed + displacement_factor * h * h * acceleration;
  body.pose = on_joint(body, body.at_impulses);
  motion.center = to_world(body.pose, body.center);
  motion.velocity = (speed + h * acceleration) * axis;
  motion.inv_mass = projection_on(axis) / body.mass;
}

/// Velocity Verlet in the angle.
void RigidBodies::swing(Body& body, RigidMotion& motion, double h, const Vector3& gravity,
                        const Pose& from) {
  const Joint& joint = *body.joint;
  const auto acceleration = [&](const Pose& pose) {
    const Vector3 arm = to_world(pose, body.center) - joint.point;
    return body.mass * joint.axis.dot(arm.cross(gravity)) / body.joint_inertia;
  };
  const double first = acceleration(from);
  const double rate = joint.axis.dot(motion.angular_velocity);
  body.at_impulses = body.displacement + h * rate + displacement_factor * h * h * first;
  body.pose = on_joint(body, body.at_impulses);
  motion.center = joint.point;
  motion.angular_velocity = (rate + h / 2 * (first + acceleration(body.pose))) * joint.axis;
  motion.inv_inertia = projection_on(joint.axis) / body.joint_inertia;
}

void RigidBodies::begin_step(double h, const Vector3& gravity,
                             std::vector<MovingCollider>& colliders) {
  h_ = h;
  last_group_ = group_;
  std::iota(group_.begin(), group_.end(), 0);
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    MovingCollider& collider = colliders[k];
    RigidMotion& motion = motions_[k];
    if (is_body(k)) {
      collider.begin_step();
      if (!leads(k)) continue;
      Body& body = *bodies_[k];
      const double kept = std::exp(-body.damping * h);
      motion.velocity *= kept;
      motion.angular_velocity *= kept;
      motion.is_body = true;
      if (is_slider(body.joint)) {
        slide(body, motion, h, gravity);
      } else if (is_hinge(body.joint)) {
        swing(body, motion, h, gravity, collider.pose());
      } else {
        move_freely(body, motion, h, gravity, collider.pose());
      }
      body.velocity = motion.velocity;
      body.turning = motion.angular_velocity;
    } else {
      motion = {};
      motion.center = collider.pose().position;
      motion.velocity = collider.velocity();
      motion.angular_velocity = collider.angular_velocity();
      if (leads(k) && bodies_[k]->joint) {  // held
        bodies_[k]->displacement = nearest_displacement(*bodies_[k], collider.pose());
      }
    }
  }
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (leads(k) && is_body(k)) put(k, bodies_[k]->pose, colliders);
  }
}

std::vector<RigidBodies::JointLimit> RigidBodies::joint_limits(std::size_t leader) const {
  const Body& body = *bodies_[leader];
  if (!body.joint || body.held) return {};
  const Joint& joint = *body.joint;
  JointLimit lower;
  if (is_slider(body.joint)) {
    lower.direction.force = joint.axis;
    lower.mass = body.mass;
  } else {
    lower.direction.torque = joint.axis;
    lower.mass = body.joint_inertia;
  }
  const double rate = joint.axis.dot(is_slider(body.joint) ? body.velocity : body.turning);
  const double place = body.at_impulses - displacement_factor * h_ * rate;
  JointLimit upper = lower;
  upper.direction.force *= -1;
  upper.direction.torque *= -1;
  lower.gap = place - joint.lower;
  upper.gap = joint.upper - place;
  return {lower, upper};
}

double RigidBodies::speed_of_surface(std::size_t k) const {
  return motion(k).velocity.norm() + radii_[k] * motion(k).angular_velocity.norm();
}

double RigidBodies::fastest_surface() const {
  double fastest = 0;
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    if (is_body(k)) fastest = std::max(fastest, speed_of_surface(k));
  }
  return fastest;
}

double RigidBodies::longest_displacement(double h) const {
  double fastest = 0, slower = 0;  // the two fastest surfaces
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    const double speed = speed_of_surface(k);
    slower = std::max(slower, std::min(speed, fastest));
    fastest = std::max(fastest, speed);
  }
  return h * (fastest + slower);
}

void RigidBodies::end_motion(Body& body, RigidMotion& motion, double h, const RigidMotion& push,
                             Pose& pose) {
  const Vector3 displacement =
      displacement_factor * h * (motion.velocity - body.velocity) + push.velocity;
  const Vector3 turn =
      displacement_factor * h * (motion.angular_velocity - body.turning) + push.angular_velocity;
  if (body.joint) {
    const Joint& joint = *body.joint;
    const double more = joint.axis.dot(is_slider(body.joint) ? displacement : turn);
    body.displacement = std::clamp(body.at_impulses + more, joint.lower, joint.upper);
    pose = on_joint(body, body.displacement);
    if (is_slider(body.joint)) motion.center = to_world(pose, body.center);
    return;
  }
  pose = moved(body.pose, body.center, displacement, turn);
  const Vector3 momentum = in_world(body.inertia, body.pose.orientation) * motion.angular_velocity;
  motion.angular_velocity = in_world(body.inv_inertia, pose.orientation) * momentum;
  motion.center = to_world(pose, body.center);
}

void RigidBodies::end_step(const std::vector<RigidMotion>& pushes,
                           std::vector<MovingCollider>& colliders) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!leads(k) || !is_body(k)) continue;
    Pose pose;
    end_motion(*bodies_[k], motions_[k], h_, pushes.empty() ? RigidMotion() : pushes[k], pose);
    put(k, pose, colliders);
  }
}

void RigidBodies::write(MemoryWriter& memory) const {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (!leads(k)) continue;
    memory.add(motions_[k].velocity);
    memory.add(motions_[k].angular_velocity);
    memory.add(bodies_[k]->displacement);
    memory.add(static_cast<double>(group_[k]));
  }
}

void RigidBodies::read(MemoryReader& memory) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (!leads(k)) continue;
    motions_[k].velocity = memory.vector();
    motions_[k].angular_velocity = memory.vector();
    bodies_[k]->displacement = memory.number();
    group_[k] = static_cast<std::size_t>(memory.index(bodies_.size()));
  }
}

}  // namespace clothsim
