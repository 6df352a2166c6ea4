// Rigid bodies: colliders that the cloth moves.

#include <algorithm>
#include <cmath>

#include "simulator_impl.h"

namespace clothsim {

void Simulator::Impl::start_bodies() {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!bodies.is_body(k)) continue;
    const BodySpec& spec = *scene.colliders[k].body;
    bodies.set_velocity(k, spec.velocity, spec.angular_velocity, colliders[k]);
  }
}

void Simulator::Impl::restore_velocities(bool of_memory) {
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (!bodies.is_body(k)) continue;
    MovingCollider& c = colliders[k];
    if (!of_memory) {
      bodies.set_velocity(k, c.velocity_at(to_world(c.pose(), bodies.center_of(k))),
                          c.angular_velocity(), c);
    } else {
      const RigidMotion motion = bodies.motion(k);
      bodies.set_velocity(k, motion.velocity, motion.angular_velocity, c);
    }
  }
}

void Simulator::Impl::begin_bodies(double h) {
  const Vector3& gravity = scene.simulation.gravity;
  bodies.begin_step(h, gravity, colliders);
  body_contacts.prepare(h, std::max(gravity.norm(), min_gravity), colliders, bodies);
}

void Simulator::Impl::solve_bodies_alone() {
  for (int pass = 0; pass < max_passes; ++pass) {
    if (body_contacts.solve_pass(bodies) <= rest_speed) break;
  }
  end_bodies();
}

void Simulator::Impl::end_bodies() {
  const std::vector<Overlap> by_points =
      touches() ? collider_contacts.overlaps(colliders, state.positions) : std::vector<Overlap>();
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
  const double steps = way_of_bodies(dt) / bodies.least_depth();
  return static_cast<int>(std::clamp(std::ceil(steps), 1.0, double{max_substeps}));
}

double Simulator::Impl::way_of_bodies(double dt) const {
  return dt * (bodies.longest_way(1) + dt * scene.simulation.gravity.norm());
}

std::size_t Simulator::Impl::body_index(int index) const {
  const auto i = static_cast<std::size_t>(index);
  const std::string& name = scene.colliders.at(i).name;
  if (!bodies.is_body(i)) {
    throw InvalidValue({"colliders", name}, "a collider without mass", "one with `mass`, a body");
  }
  return i;
}

void Simulator::Impl::check_driven(std::size_t index) const {
  const std::string& name = scene.colliders.at(index).name;
  if (bodies.is_body(index)) {
    throw InvalidValue({"colliders", name}, "a rigid body", "a collider without `mass`");
  }
}

}  // namespace clothsim
