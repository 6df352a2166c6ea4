// Points of the cloth that are attached to frames, and its wrenches on frames and colliders.

#include <algorithm>
#include <set>
#include <string>
#include <variant>

#include "clothsim/dynamics/drag.h"
#include "simulator_impl.h"

namespace clothsim {

namespace {

constexpr Range radius_range{0, 1e6, "m"};

/// By holder: the mass of the cloth [kg], of several of those that it holds.
Scalars held_masses(const std::vector<Hold>& holds, std::size_t holders,
                    const std::vector<ClothPart>& parts, const Cloth& cloth) {
  const auto count = static_cast<Eigen::Index>(holders);
  if (parts.empty()) return Scalars::Constant(count, cloth.mass.sum());
  Scalars masses = Scalars::Zero(count);
  for (const ClothPart& part : parts) {
    std::set<int> of_part;
    for (const auto& [point, holder] : holds) {
      const int own = point - part.first_point;
      if (own >= 0 && own < part.num_points()) of_part.insert(holder);
    }
    const double mass = cloth.mass.segment(part.first_point, part.num_points()).sum();
    for (const int holder : of_part) masses[holder] += mass;
  }
  return masses;
}

}  // namespace

void Simulator::Impl::hold_pins(Cloth& cloth) {
  for (int i = 0; i < cloth.num_points(); ++i) cloth.inv_mass[i] = 1 / cloth.mass[i];
  for (const int pin : cloth.pinned) cloth.inv_mass[pin] = 0;
}

void Simulator::Impl::hold_points() {
  std::vector<Hold> holds;
  std::vector<std::optional<double>> strengths;
  for (std::size_t i = 0; i < scene.cloth.pinned.size(); ++i) {
    holds.push_back({pin_point(i), static_cast<int>(strengths.size())});
    const std::optional<double>& own = scene.cloth.pinned[i].strength;
    strengths.push_back(own ? own : scene.cloth.pin_strength);
  }
  const int first_grip = static_cast<int>(strengths.size());
  grips.for_each_held([&](int grip, int point, const Vector3&) {
    holds.push_back({point, first_grip + grip});
  });
  for (const auto& [frame, grip] : grips.all()) {
    if (!grip.on_body) strengths.push_back(grip.strength);
  }
  attachments.attach(grips.on_bodies());
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    if (bodies.leads(k)) bodies.hold(k, grips.frame_of_body(k) != nullptr);
  }
  const double gravity = std::max(scene.simulation.gravity.norm(), min_gravity);
  const Scalars masses = held_masses(holds, strengths.size(), scene.cloth.parts, cloth);
  holders.hold(holds, strengths, cloth, gravity * (masses.array() + bodies.mass()).matrix(),
               state.positions);
  leave_springs_to_holders();
  follow_holders();
  if (self_contacts) self_contacts->restart_detection();
  disturbed = true;
}

void Simulator::Impl::leave_springs_to_holders() {
  if (!strain_limit) return;
  std::vector<int> holder_of = holders.holder_of_points(cloth);
  for (const BodyAttachments::Attachment& a : grips.on_bodies()) {
    // Numbers of bodies follow those of pins and grips, of which there is at most one a point.
    holder_of[static_cast<std::size_t>(a.point)] = cloth.num_points() + static_cast<int>(a.body);
  }
  strain_limit->leave_to_holders(holder_of);
}

void Simulator::Impl::follow_holders() {
  for (int i = 0; i < cloth.num_points(); ++i) cloth.inv_mass[i] = 1 / cloth.mass[i];
  holders.apply(cloth);
  frame_context.steps_left = frame_context.planned_steps = 0;
}

std::vector<Vector3> Simulator::Impl::hold_targets() const {
  std::vector<Vector3> targets = pin_targets;
  grips.for_each_held([&](int, int, const Vector3& place) { targets.push_back(place); });
  return targets;
}

void Simulator::Impl::update_holders(double h) {
  attachments.end_step(cloth, h, state.velocities);
  if (holders.any_sticks()) {
    if (const Xpbd* solver = std::get_if<Xpbd>(&method->integrator)) {
      solver->add_reactions(cloth, h, impulses);  // of the springs as far as it solved them
    } else {
      holders.add_spring_impulses(cloth, h, state, impulses);
    }
    if (strain_limit || self_contacts) {
      Points at_end = Points::Zero(cloth.num_points(), 3);
      if (strain_limit) strain_limit->add_impulses(at_end);
      if (self_contacts) self_contacts->add_impulses(at_end);
      holders.add_end_impulses(cloth, h, at_end, impulses);
    }
  }
  if (holders.update_slipping(cloth, h, scene.simulation.gravity, impulses, state))
    follow_holders();
}

void Simulator::Impl::finish_grips(double dt, const State& before) {
  grips.measure(cloth, dt, holders, pin_targets.size(), before, state);
  grips.measure(dt, attachments, colliders, state.positions);
  const std::vector<int> torn = grips.torn();
  if (torn.empty()) return;
  grips.detach(torn);
  hold_points();
}

void Simulator::Impl::add_collider_impulses(double h) {
  const Scalars masses = cloth.mass.cwiseProduct(impulses_as_forces(cloth, h));
  collider_contacts.add_impulses(colliders, masses, state.positions, collider_impulses);
}

void Simulator::Impl::finish_colliders(double dt) {
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    collider_wrenches[i].force = collider_impulses[i].force / dt;
    collider_wrenches[i].torque = collider_impulses[i].torque / dt;
  }
}

void Simulator::attach(const std::string& frame, const Pose& pose, const std::vector<int>& points,
                       const GripForces& forces) {
  check_place(pose);
  impl_->attach(frame, pose, points, forces);
}

void Simulator::Impl::attach(const std::string& frame, const Pose& pose,
                             const std::vector<int>& points, const GripForces& forces) {
  const std::optional<std::size_t> body = body_named(frame);
  const auto is_held = [&](int point) { return holders.holds(point) || attachments.holds(point); };
  grips.attach(frame, body ? colliders[*body].pose() : pose, body, points, forces, is_held,
               state.positions);
  hold_points();
}

std::vector<int> Simulator::free_points_near(const Vector3& position, double radius) const {
  check_range("radius", radius, radius_range);
  std::vector<int> free;
  bool is_any_held = false;
  for (int i = 0; i < cloth().num_points(); ++i) {
    if ((row(state().positions, i) - position).norm() > radius) continue;
    const bool is_held = impl_->holders.holds(i) || impl_->attachments.holds(i);
    is_any_held = is_any_held || is_held;
    if (!is_held) free.push_back(i);
  }
  if (!free.empty()) return free;
  throw InvalidValue(
      {"radius"},
      to_text(radius) + (is_any_held ? " with none but points inside that are held already"
                                     : " with no point inside"),
      "one about a free point of the cloth");
}

std::vector<HolderReport> Simulator::holders() const {
  const Holders& holders = impl_->holders;
  std::vector<HolderReport> reports;
  int number = 0;
  const auto add = [&](const std::string& name, std::size_t first, std::size_t count) {
    const int holder = number++;
    if (count == 0) return;  // it holds bodies alone
    HolderReport report{name, holders.point(first), holders.strength(holder),
                        holders.force(holder, frame_duration()), 0};
    for (std::size_t i = first; i < first + count; ++i) {
      report.lag = std::max(report.lag, holders.lag(i, state().positions));
    }
    reports.push_back(report);
  };
  std::size_t next = 0;
  for (const Pin& pin : scene().cloth.pinned) {
    add("pin " + point_text(scene().cloth, pin.column, pin.row), next, 1);
    ++next;
  }
  for (const auto& [frame, grip] : grips()) {
    if (grip.on_body) continue;
    add(frame, next, grip.held.size());
    next += grip.held.size();
  }
  return reports;
}

void Simulator::detach(const std::vector<int>& points) {
  impl_->grips.detach(points);
  impl_->hold_points();
}

void Simulator::move_grip(const std::string& frame, const Pose& target) {
  check_place(target);
  const Grip& grip = impl_->grips.all().at(frame);
  if (grip.on_body) throw InvalidValue({"frame"}, frame + ", a rigid body", "a tf frame");
  impl_->grips.move(frame, target);
  for (const Grip::HeldBody& body : grip.bodies) {
    // A frame moves a body with a joint along the joint.
    impl_->move_body(body.leader, impl_->bodies.nearest_allowed(body.leader, target * body.offset));
  }
}

const std::map<std::string, Grip>& Simulator::grips() const { return impl_->grips.all(); }

void Simulator::measure_wrenches(bool asks) {
  impl_->measures_wrenches = asks;
  if (!asks) impl_->collider_wrenches.assign(impl_->colliders.size(), {});
}

bool Simulator::measures_wrenches() const { return impl_->measures_wrenches; }

const std::vector<Wrench>& Simulator::collider_wrenches() const { return impl_->collider_wrenches; }

Wrench Simulator::body_wrench(int index) const {
  const std::size_t leader = impl_->body_index(index);
  const Vector3& origin = impl_->colliders[leader].pose().position;
  Wrench sum;
  for (std::size_t k = 0; k < impl_->colliders.size(); ++k) {
    if (impl_->bodies.leader(k) != leader) continue;
    sum.add(impl_->colliders[k].pose().position - origin, impl_->collider_wrenches[k].force);
    sum.torque += impl_->collider_wrenches[k].torque;
  }
  const auto attached = grips().find(scene().colliders[leader].name);
  if (attached != grips().end() && attached->second.on_body) {
    sum.force += attached->second.wrench.force;
    sum.torque += attached->second.wrench.torque;
  }
  return sum;
}

}  // namespace clothsim
