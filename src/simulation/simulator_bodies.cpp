// Rigid bodies: colliders that the cloth moves.

#include <algorithm>
#include <cmath>

#include "simulator_impl.h"

namespace clothsim {

void Simulator::Impl::attach_to_bodies() {
  for (const BodyPoints& attached : scene.cloth.attached) {
    std::vector<int> points;
    for (const auto& [column, r] : attached.points) {
      points.push_back(r * scene.cloth.columns + column);
    }
    attach(attached.body, Pose(), points, {attached.tear_force, {}});
  }
}

std::optional<std::size_t> Simulator::Impl::body_named(const std::string& name) const {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (bodies.leads(k) && scene.colliders[k].name == name) return k;
  }
  return {};
}

void Simulator::Impl::move_body(std::size_t leader, const Pose& target) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (bodies.leader(k) != leader) continue;
    const Pose of_part = bodies.pose_of(k, target);
    colliders[k].set_target(of_part, 1 / scene.simulation.frames_per_second);
  }
}

void Simulator::Impl::place_body(std::size_t leader, const Pose& pose) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (bodies.leader(k) == leader) colliders[k].place(bodies.pose_of(k, pose));
  }
}

void Simulator::Impl::put_elsewhere(std::size_t leader, const Pose& pose) {
  const std::vector<MovingCollider> before = colliders;
  place_body(leader, pose);
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    const Pose &from = before[k].pose(), &to = colliders[k].pose();
    const double turn = from.orientation.angularDistance(to.orientation);
    const double moved = (to.position - from.position).norm() +
                         (turn > 0 ? turn * bounding_radius(colliders[k].shape()) : 0);
    if (moved >= penetration_slop) collider_contacts.jump(k);
    if (moved > safe_depth(colliders[k].shape())) collider_contacts.put_on(k);
  }
}

void Simulator::Impl::start_colliders() {
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    colliders[i].place(scene.colliders[i].pose * scene.colliders[i].offset);
    colliders[i].enable(scene.colliders[i].enabled);
  }
  bodies.start(scene.colliders, colliders);
}

void Simulator::Impl::put_on_all() {
  for (std::size_t k = 0; k < colliders.size(); ++k) collider_contacts.put_on(k);
}

void Simulator::Impl::restore_velocities(bool of_memory) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!bodies.leads(k)) continue;
    const MovingCollider& c = colliders[k];
    if (bodies.is_held(k)) {
      bodies.set_held(k, c.pose(), of_memory);
      continue;
    }
    if (!of_memory) {
      bodies.set_velocity(k, c.velocity_at(to_world(c.pose(), bodies.center_of(k))),
                          c.angular_velocity(), colliders);
    } else {
      const RigidMotion motion = bodies.motion(k);
      bodies.set_velocity(k, motion.velocity, motion.angular_velocity, colliders);
    }
  }
}

void Simulator::Impl::begin_bodies(double h) {
  const Vector3& gravity = scene.simulation.gravity;
  bodies.begin_step(h, gravity, colliders);
  const auto attached = [&](double reach) {
    return attachments.touches(cloth, colliders, state.positions, reach);
  };
  body_contacts.prepare(h, std::max(gravity.norm(), min_gravity), scene.colliders, colliders,
                        attached, bodies);
}

void Simulator::Impl::solve_bodies_alone() {
  for (int pass = 0; pass < max_passes; ++pass) {
    if (body_contacts.solve_pass(bodies) <= rest_speed) break;
  }
  end_bodies();
}

void Simulator::Impl::end_bodies() {
  const std::vector<Overlap> by_points =
      touches() ? collider_contacts.overlaps(colliders, cloth, state.positions)
                : std::vector<Overlap>();
  bodies.end_step(body_contacts.pushes(bodies, by_points), colliders);
  if (touches()) collider_contacts.follow_bodies(colliders, bodies, state.positions);
}

bool Simulator::Impl::has_good_bodies() const {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!bodies.is_body(k)) continue;
    const Pose& pose = colliders[k].pose();
    const RigidMotion& motion = bodies.motion(k);
    const bool is_good = (pose.position.cwiseAbs().array() < farthest).all() &&
                         pose.orientation.coeffs().allFinite() && motion.velocity.allFinite() &&
                         motion.angular_velocity.allFinite();
    if (!is_good) return false;
  }
  return true;
}

int Simulator::Impl::substeps_of_bodies(double dt) const {
  const double steps = displacement_of_bodies(dt) / bodies.least_depth();
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

double Simulator::Impl::displacement_of_bodies(double dt) const {
  return dt * (bodies.longest_displacement(1) + dt * scene.simulation.gravity.norm());
}

std::size_t Simulator::Impl::body_index(int index) const {
  const auto i = static_cast<std::size_t>(index);
  const std::string& name = scene.colliders.at(i).name;
  if (!bodies.leads(i)) {
    throw InvalidValue({"colliders", name}, "a collider without mass", "one with `mass`, a body");
  }
  return i;
}

void Simulator::Impl::check_driven(std::size_t index) const {
  const std::string& name = scene.colliders.at(index).name;
  const std::size_t leader = bodies.leader(index);
  if (leader != index) {
    throw InvalidValue({"colliders", name}, "a part of " + scene.colliders[leader].name,
                       "a kinematic collider, one without a mass");
  }
  if (bodies.leads(index)) {
    throw InvalidValue({"colliders", name}, "a rigid body", "a collider without `mass`");
  }
}

}  // namespace clothsim
