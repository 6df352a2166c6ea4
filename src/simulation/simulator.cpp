#include "clothsim/simulation/simulator.h"

#include <utility>

#include "clothsim/geometry/intersections.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/make_cloth.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

Diverged too_much_work(double time, const StepReport& report) {
  return Diverged("the frame after t = " + std::to_string(time) +
                  " s asks for more than can be solved: it was left after " +
                  std::to_string(report.substeps) + " substeps and " +
                  std::to_string(report.sweeps + report.corrections) + " passes");
}

Diverged no_cloth(double time, const StepReport& report) {
  const std::string retried =
      report.recoveries == 0 ? "" : " after " + std::to_string(report.recoveries) + " other tries";
  return Diverged("the state left the finite numbers or gained energy in the frame after t = " +
                  std::to_string(time) + " s, with method " + report.method + " and " +
                  std::to_string(report.substeps) + " substeps a frame" + retried);
}

}  // namespace

Simulator::Impl::Impl(const Scene& s) : scene(s), scene_values(live_values(s)) {
  validate(scene);
  workers = Workers(scene.simulation.threads);
  cloth = make_cloth(scene.cloth, scene.simulation.gravity.norm());
  build_strain_limit();
  for (const ColliderSpec& spec : scene.colliders) colliders.emplace_back(spec);
  bodies = RigidBodies(scene.colliders);
  reset();
  check_feasible(scene.simulation, cloth,
                 scene.cloth.parts.empty() ? std::vector<std::string>{"cloth", "ks"}
                                           : std::vector<std::string>{"cloths"});
}

StepReport Simulator::Impl::step() {
  const double dt = 1 / scene.simulation.frames_per_second;
  const State last_good = state;
  frame_context = {dt};
  if (!touches()) collider_contacts.reset();  // colliders may have been disabled
  if (!knows_offset) begin_offset();
  allow_work(dt);
  StepReport report = step_with_retries(last_good);

  snap_to_targets();
  is_given = disturbed = false;
  if (!grips.empty()) finish_grips(dt, last_good);
  if (measures_wrenches) finish_colliders(dt);
  state.time = last_good.time + dt;
  report.contacts = collider_contacts.count();
  if (self_contacts) report.contacts += self_contacts->count();
  if (given_crossings > 0) {
    report.crossings = given_crossings = count_intersections(cloth, state.positions);
  }
  if (given_crossings > 0) {
    report.reasons.add(Reason::crosses_itself,
                       std::to_string(given_crossings) + " pairs of triangles");
  }
  report.lagging = holders.slipping();
  return report;
}

StepReport Simulator::Impl::step_with_retries(const State& last_good) {
  const std::vector<MovingCollider> last_colliders = colliders;
  const Holders last_holders = holders;
  const RigidBodies last_bodies = bodies;
  const std::vector<ColliderExit> last_exits = collider_contacts.exits();
  const bool was_disturbed = disturbed;
  const double last_offset = cloth.offset;
  const auto take_back = [&] {
    state = last_good;
    colliders = last_colliders;
    holders = last_holders;
    bodies = last_bodies;
    follow_holders();
    disturbed = was_disturbed;
    cloth.offset = last_offset;
    forget_constraints();
    collider_contacts.set_exits(last_exits);
    energy_watch.restart();
  };
  bool may_be_apart = true;
  for (StepReport report;;) {
    Outcome outcome;
    try {
      outcome = frame(may_be_apart, last_good, report);
    } catch (...) {  // Interrupted, or a library or memory that is lacking
      take_back();
      throw;
    }
    if (outcome == Outcome::good) return report;
    take_back();
    if (outcome == Outcome::went_too_far) {
      may_be_apart = false;
      continue;
    }
    if (budget.is_spent()) {
      forget();
      throw too_much_work(state.time, report);
    }
    if (!recover()) {
      forget();
      throw no_cloth(state.time, report);
    }
    ++report.recoveries;
  }
}

void Simulator::Impl::snap_to_targets() {
  holders.end_frame(state);
  for (std::size_t i = 0; i < pin_targets.size(); ++i) {
    if (holders.sticks(i)) state.velocities.row(pin_point(i)).setZero();
  }
  for (std::size_t k = 0; k < colliders.size(); ++k) {
    bodies.is_body(k) ? colliders[k].begin_step() : colliders[k].snap_to_target();
    if (bodies.leads(k) && bodies.is_held(k)) bodies.set_held(k, colliders[k].pose(), true);
  }
}

bool Simulator::Impl::recover() {
  const SimulationSpec& spec = scene.simulation;
  if (spec.method != "auto" || method->choice.method == fallback_method) return false;
  const Reasons failed(Reason::method_failed, method->choice.method);
  method = last_resort(spec, cloth, scene.colliders, failed);
  return true;
}

Simulator::Simulator(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Simulator::~Simulator() = default;
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;

StepReport Simulator::step() { return impl_->step(); }
void Simulator::set_interrupt(std::function<bool()> is_interrupted) {
  impl_->is_interrupted = std::move(is_interrupted);
}

void Simulator::reset() { impl_->reset(); }

void Simulator::move_collider(int index, const Pose& target) {
  check_place(target);
  const auto i = static_cast<std::size_t>(index);
  impl_->check_driven(i);
  impl_->move_body(i, target * scene().colliders[i].offset);
}

void Simulator::place_collider(int index, const Pose& pose) {
  check_place(pose);
  const auto i = static_cast<std::size_t>(index);
  impl_->check_driven(i);
  impl_->put_elsewhere(i, pose * scene().colliders[i].offset);
  impl_->disturbed = true;
}

void Simulator::enable_collider(int index, bool enabled) {
  MovingCollider& collider = impl_->colliders.at(static_cast<std::size_t>(index));
  if (collider.enabled() == enabled) return;
  collider.enable(enabled);
  if (enabled) impl_->collider_contacts.put_on(static_cast<std::size_t>(index));
  impl_->disturbed = true;
}

void Simulator::set_body(int index, const Pose& pose, const Vector3& velocity,
                         const Vector3& angular_velocity) {
  check_place(pose);
  check_range("velocity", velocity, velocity_range);
  check_range("angular_velocity", angular_velocity, angular_velocity_range);
  const std::size_t i = impl_->body_index(index);
  if (impl_->bodies.is_held(i)) {
    throw InvalidValue({"body"}, scene().colliders[i].name + ", which a tf frame holds",
                       "a body that no tf frame holds");
  }
  if (impl_->bodies.distance_from_joint(i, pose) > written_rounding) {
    throw InvalidValue({"pose"}, "one that its joint does not allow", "one along the joint");
  }
  impl_->place_body(i, pose);
  impl_->bodies.set_velocity(i, velocity, angular_velocity, impl_->colliders);
  impl_->body_contacts.reset();
  impl_->disturbed = true;
}

void Simulator::attach_body(int index, const std::string& frame, const Pose& pose) {
  check_place(pose);
  const std::size_t i = impl_->body_index(index);
  if (const std::string* holder = impl_->grips.frame_of_body(i)) {
    throw InvalidValue({"body"}, scene().colliders[i].name + ", which " + *holder + " holds",
                       "a body that no tf frame holds");
  }
  if (impl_->body_named(frame)) {
    throw InvalidValue({"frame"}, frame + ", a rigid body", "a tf frame");
  }
  const Pose of_body = collider_pose(index);
  impl_->grips.attach_body(i, of_body, frame, pose);
  impl_->place_body(i, of_body);  // at rest until the frame moves
  impl_->hold_points();
  impl_->body_contacts.reset();
}

void Simulator::detach_body(int index) {
  const std::size_t i = impl_->body_index(index);
  if (!impl_->bodies.is_held(i)) {
    throw InvalidValue({"body"}, scene().colliders[i].name, "a body that a tf frame holds");
  }
  const BodyMotion motion = body_motion(index);
  impl_->grips.detach_body(i);
  impl_->hold_points();
  impl_->bodies.set_velocity(i, motion.velocity, motion.angular_velocity, impl_->colliders);
  impl_->body_contacts.reset();
}

bool Simulator::is_body(int index) const {
  return impl_->bodies.leads(static_cast<std::size_t>(index));
}

std::optional<std::string> Simulator::frame_of_body(int index) const {
  const std::string* frame = impl_->grips.frame_of_body(impl_->body_index(index));
  return frame ? std::optional(*frame) : std::nullopt;
}

std::optional<int> Simulator::body_named(const std::string& name) const {
  const std::optional<std::size_t> leader = impl_->body_named(name);
  return leader ? std::optional(static_cast<int>(*leader)) : std::nullopt;
}

BodyMotion Simulator::body_motion(int index) const {
  const std::size_t i = impl_->body_index(index);
  const RigidMotion& motion = impl_->bodies.motion(i);
  const Pose& pose = impl_->colliders[i].pose();
  const Vector3 center = to_world(pose, impl_->bodies.center_of(i));
  return {pose, motion.velocity_at(center), motion.angular_velocity};
}

void Simulator::move_pin(int index, const Vector3& target) {
  check_place(target);
  impl_->pin_targets.at(static_cast<std::size_t>(index)) = target;
}

void Simulator::place_pin(int index, const Vector3& position) {
  check_place(position);
  const auto pin = static_cast<std::size_t>(index);
  impl_->pin_targets.at(pin) = position;
  impl_->holders.place(pin, position, impl_->state);
  impl_->follow_holders();
  impl_->disturbed = true;
}

const Scene& Simulator::scene() const { return impl_->scene; }
const Cloth& Simulator::cloth() const { return impl_->cloth; }
const State& Simulator::state() const { return impl_->state; }
const Pose& Simulator::collider_pose(int index) const {
  return impl_->colliders.at(static_cast<std::size_t>(index)).pose();
}
bool Simulator::collider_enabled(int index) const {
  return impl_->colliders.at(static_cast<std::size_t>(index)).enabled();
}
double Simulator::frame_duration() const { return 1 / impl_->scene.simulation.frames_per_second; }
const MethodChoice& Simulator::choice() const { return impl_->method->choice; }
unsigned Simulator::topology_seq() const { return impl_->topology_seq; }

}  // namespace clothsim
