#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/constraints/body_contacts.h"
#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/constraints/lagged_contact.h"
#include "clothsim/constraints/rigid_bodies.h"
#include "clothsim/constraints/self_contacts.h"
#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/air.h"
#include "clothsim/dynamics/integrator.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/grid.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/shapes/moving_collider.h"
#include "clothsim/simulation/energy_watch.h"
#include "clothsim/simulation/grips.h"
#include "clothsim/simulation/method_choice.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/simulation/substeps.h"
#include "frame_context.h"

namespace clothsim {

/// The method of `auto` after a failed frame: implicit Euler never increases the energy.
inline constexpr const char* fallback_method = ImplicitEuler::name;

/// Largest coordinate of points on each axis [m].
inline constexpr double farthest = place_range.max;

/// Largest number of passes over the constraints in a substep: reached only in a shock.
inline constexpr int max_passes = 200;

/// The choice for a scene with `cloth`, and its integrator.
struct Method {
  Method(const SimulationSpec& spec, const Cloth& cloth, const std::vector<ColliderSpec>& colliders)
      : choice(choose_method(spec, cloth, colliders)),
        integrator(make_integrator(choice.method, spec.method_parameters)),
        omega_max(omega_max_bound(cloth)) {}

  /// Substeps of a frame from `positions`, at least `at_speed`: the number that its motion needs.
  int substeps(const SimulationSpec& spec, const Cloth& cloth, const Points& positions,
               int at_speed = 1, const Workers& workers = {}) const {
    if (spec.substeps) return *spec.substeps;
    return count_substeps(cloth, spec.gravity, positions, stability_limit(),
                          1 / spec.frames_per_second, std::max(choice.min_substeps, at_speed),
                          workers, omega_max);
  }

  double stability_limit() const {
    return std::visit([](const auto& m) { return m.stability_limit; }, integrator);
  }

  MethodChoice choice;
  Integrator integrator;
  double omega_max;  // at least that of springs of any stretch [rad/s]
};

/// The method after a failed frame, with as few substeps as it can take: substeps that are short
/// for the constraints may be the cause of the failure.
inline Method last_resort(SimulationSpec spec, const Cloth& cloth,
                          const std::vector<ColliderSpec>& colliders, const Reasons& reasons) {
  spec.method = fallback_method;
  Method method(spec, cloth, colliders);
  method.choice.reasons = reasons;
  method.choice.min_substeps = 1;
  return method;
}

struct Simulator::Impl {
  explicit Impl(const Scene&);

  void reset() {
    const State first = start_state(scene.cloth, cloth, scene.simulation.seed);
    state = first;  // into the same memory
    pin_targets.resize(scene.cloth.pinned.size());
    for (std::size_t i = 0; i < pin_targets.size(); ++i) {
      pin_targets[i] = state.positions.row(pin_point(i)).transpose();
    }
    start_colliders();
    grips.clear();
    holders = {};
    hold_points();
    attach_to_bodies();
    collider_wrenches.assign(colliders.size(), {});
    external_forces.resize(0, 3);
    last_substep = 0;
    forget();
    disturbed = is_given = false;
    given_crossings = 0;
  }

  /// The cloth as in the scene, without grips and with its full offset: the method is chosen for
  /// it, so that the choice does not depend on the time of the call.
  Cloth without_grips() const {
    Cloth free = cloth;
    hold_pins(free);
    free.offset = free.full_offset;
    return free;
  }

  /// Drops the history of the method and of constraints.
  void forget() {
    method.emplace(scene.simulation, without_grips(), scene.colliders);
    forget_constraints();
    put_on_all();
    knows_offset = false;
    self_contacts = make_self_contacts(cloth);  // and the tracked pairs in it
    energy_watch.restart();
  }

  /// Takes the method for the present scene. Keeps the current one where it is the same, unless
  /// `anew`.
  void choose(bool anew);

  void forget_constraints() {
    if (strain_limit) strain_limit->reset();
    collider_contacts.reset();
    lagged_contact.reset();
    body_contacts.reset();
    attachments.reset();
    if (self_contacts) self_contacts->reset();
  }

  void build_strain_limit() {
    strain_limit.reset();
    if (!cloth.strain_limit || cloth.springs.empty()) return;
    strain_limit.emplace(cloth, &budget);
    leave_springs_to_holders();
    cloth_with_tension_mass = cloth;
  }

  int pin_point(std::size_t pin) const {
    const Pin& p = scene.cloth.pinned[pin];
    return p.row * scene.cloth.columns + p.column;
  }

  /// Drops the method's history with another material.
  void forget_history() {
    if (auto* bdf2 = std::get_if<Bdf2>(&method->integrator)) bdf2->forget();
  }

  void write(MemoryWriter&) const;
  /// Whether the numbers are a memory of such a cloth, scene and method.
  bool fits(const std::vector<double>& memory) const;
  /// Throws InvalidValue and changes nothing where the numbers are not those of such a scene.
  void read(const std::vector<double>&);
  /// The method in a memory, which may have changed after a failed frame.
  Method read_method(MemoryReader&) const;
  void set_state(const State&, const std::vector<double>& memory);
  /// Counts the crossings of a state that was set, or resolves them where the scene asks for it.
  void look_for_crossings();
  Untangled untangle();

  /// Holds the pins alone.
  static void hold_pins(Cloth&);
  /// To be called when other points are attached.
  void hold_points();
  /// Attaches points to a tf frame, or to the body of that name.
  void attach(const std::string& frame, const Pose&, const std::vector<int>& points,
              const GripForces&);
  /// Springs between two points of one holder are no matter of the strain limit.
  void leave_springs_to_holders();
  /// To be called when held points start to slip or to stick: their inverse masses change.
  void follow_holders();
  /// Targets of pins and grips at the frame's end [m], in the order of holders.
  std::vector<Vector3> hold_targets() const;
  /// After a substep of h [s]: lets held points slip, or stick again.
  void update_holders(double h);
  /// Adds the impulses of a substep of h [s] to `collider_impulses`.
  void add_collider_impulses(double h);
  /// Computes the wrenches of colliders after a frame of dt [s].
  void finish_colliders(double dt);
  /// Measures the loads of grips after a frame of dt [s], and detaches those beyond their tear
  /// force.
  void finish_grips(double dt, const State& before);

  /// Throws where `auto` cannot choose a step for a cloth, naming the value at `key`.
  void check_feasible(const SimulationSpec&, const Cloth& with,
                      const std::vector<std::string>& key) const;
  /// Drops self contacts of another kind, thickness or mass.
  void renew_self_contacts(const Cloth& last, const Cloth& now);
  /// Sets the velocities of colliders for a frame of another length.
  void renew_targets() {
    for (std::size_t k = 0; k < colliders.size(); ++k) {
      if (bodies.is_body(k)) continue;
      colliders[k].set_target(colliders[k].target(), 1 / scene.simulation.frames_per_second);
    }
  }
  /// Sets the friction of the scene.
  void set_collider_friction();

  /// Attaches the points that the scene attaches to bodies.
  void attach_to_bodies();
  /// The leader of the body of that name.
  std::optional<std::size_t> body_named(const std::string& name) const;
  /// Moves a collider, or all of a body, to a target in the next frame.
  void move_body(std::size_t leader, const Pose& target);
  /// Puts all colliders of a body at the places that belong to a pose of its leader.
  void place_body(std::size_t leader, const Pose&);
  void put_elsewhere(std::size_t leader, const Pose&);  // and cloth may be in it then
  void put_on_all();                                    // cloth may be in any collider
  void start_colliders();
  /// Gives the colliders of bodies, which were restored, the velocities of the memory; else the
  /// bodies those of their colliders.
  void restore_velocities(bool of_memory);
  /// Moves the bodies freely through a substep of h [s], and detects their contacts.
  void begin_bodies(double h);
  /// Solves the contacts of the bodies where the cloth touches nothing.
  void solve_bodies_alone();
  void end_bodies();
  /// Throw InvalidValue for a collider that is no body, or that is one.
  std::size_t body_index(int index) const;
  void check_driven(std::size_t index) const;
  bool has_good_bodies() const;
  /// Substeps of a frame of dt [s] in which no body passes through another collider.
  int substeps_of_bodies(double dt) const;
  /// Bound on the displacement of a body's surface in dt [s], with collisions on its way [m].
  double displacement_of_bodies(double dt) const;

  StepReport step();
  /// Tries a frame until it succeeds. Throws Diverged where nothing is left to try.
  StepReport step_with_retries(const State& last_good);
  /// One frame; whether it `may_be_apart` from colliders.
  Outcome frame(bool may_be_apart, const State& before, StepReport&);
  /// Pins and grips start towards their targets at the frame's end.
  void begin_frame();
  /// Puts pins and colliders at their targets, to the last bit. Pins that slip, or that the cloth
  /// itself blocks, stop short.
  void snap_to_targets();
  /// Number of substeps at the frame's begin.
  int first_substeps();
  /// False where the state is no longer finite, or the budget is spent.
  bool take_substeps(int steps, const State& before, StepReport&);
  /// After a substep of h [s] in which the guard truncated points, without pinched ones: do layers
  /// move farther than their thickness in it?
  bool outruns_contacts(double h, const StepReport&) const;
  /// Adds the reasons that show at the frame's end.
  void tell_reasons(StepReport&) const;
  /// Can the work done in the frame explain its energy?
  bool is_explained(const State& before, const StepReport&);
  /// Prepares another try of a failed frame. False where nothing is left to try.
  bool recover();
  /// False where the state is no longer finite, or the budget is spent.
  bool substep(double h, StepReport&);
  /// The lagged impulses of contact in a step of h [s]; null where none act.
  const Points* begin_lagged_contact(double h);
  /// Plans the number of substeps of h [s] that use this detection, including this one.
  void plan_detection(double h);
  /// Displacement of points and colliders, together, before contact with features that were not
  /// detected [m]. Sets the speed of these colliders.
  double max_undetected();
  /// After a substep of h [s] with detection, and after one without: may the next one skip it?
  void end_detection(double h);
  void count_displacement(double h);
  bool may_skip_detection(double h) const;
  /// Not where springs are at their limit, nor while colliders push out or pinch: their impulses
  /// depend on the steps.
  bool is_settled() const;
  /// Largest relative speed of a point with these velocities and a collider [m/s].
  double max_speed(const Points& velocities) const {
    const double of_bodies = bodies.empty() ? 0 : bodies.fastest_surface();
    return longest_row(velocities) + std::max(frame_context.collider_speed, of_bodies);
  }
  ContactStep contact_step(double h, double displacement_factor, const SelfTouches&);
  /// Moves points by the changes of their velocities since the last call: x += impulse_time dv.
  void follow_velocities(double impulse_time);
  /// Corrects the violations that curvature and early ends of passes leave in the positions.
  void correct_positions(bool runs_detection, StepReport&);
  /// `inert`: the cloth with the inertia of this step.
  void constrain(const Cloth& inert, double h, StepReport&);
  /// The same where the cloth can touch nothing. `length`: as in tolerances_at().
  void limit_alone(const Cloth& inert, double h, double displacement_factor, double length,
                   StepReport&);
  /// Updates the known contacts without detection, and applies their impulses.
  void refresh_contacts(const ContactStep&);
  /// Detects contacts, and applies the impulses of the last step.
  void prepare_contacts(const ContactStep&, StepReport&);
  /// In a step of h [s], for a `tolerance` of strain. `length`: that times the shortest spring [m].
  PassTolerances tolerances_at(double h, double tolerance, double length) const;
  /// Passes over all constraints until changes are small.
  void solve(bool runs_detection, StepReport&);
  /// One pass over all contacts of colliders. Returns the largest change as a displacement [m].
  double solve_colliders();
  /// The same over points that slip behind their holders, and points on bodies.
  double solve_holders();
  /// Largest number of passes over the strain limit in a substep.
  int max_limit_passes() const;
  /// Takes `visits_a_point` visits to each point from the frame's budget.
  void spend(double visits_a_point) {
    budget.spend(static_cast<std::int64_t>(visits_a_point * cloth.num_points()));
  }
  /// Adds the impulses of air in h [s] to the velocities.
  void apply_wind(double h);
  /// Adds the impulses of external forces in h [s], with the inertia of this step.
  void apply_external_forces(const Cloth& inert, double h);
  /// Largest acceleration of a point by external forces [m/s^2].
  double max_external_acceleration() const;
  /// Bound on the work of external forces in a frame of dt [s], in J.
  double work_of_external_forces(double dt, const State& before) const;

  /// Largest stretch of springs at the end of a substep of `h` [s], l / L0 - 1: the present one,
  /// plus that by colliders until then.
  double stretch_after(double h) const;
  bool has_air() const { return scene.simulation.wind || scene.simulation.gusts > 0; }
  /// Largest relative speed of the cloth and the wind of this frame [m/s].
  double air_speed() const { return frame_context.wind.norm() + longest_row(state.velocities); }
  /// Shortens the springs that are over their limit. Returns the passes taken, at most
  /// `pass_limit`.
  int project_springs(const Cloth&, int pass_limit, StepReport&);
  /// Projects the springs that are still over their limit.
  void project_positions(const Cloth&, StepReport&);
  /// Truncates displacements through the cloth itself, and projects springs beside truncated
  /// points.
  void guard(const ContactStep&, StepReport&);
  void project_beside_truncated(const ContactStep&, StepReport&);
  /// Sets the budget of a frame of dt [s], over all its tries. Newton's steps do not count: the
  /// method bounds their number itself.
  void allow_work(double dt);
  /// Substeps of a frame of dt [s] by the scene or its springs, whatever the state.
  double min_substeps(double dt) const;
  /// Whether steps of h [s] exceed the method's limit for the springs as they are.
  bool is_beyond_stability(double h) const;
  /// Do substeps follow tension?
  bool follows_tension() const;
  /// Substeps of `dt` [s] for the present tension, at least `min_steps`.
  int substeps_under_tension(double dt, int min_steps) const;
  /// Can the cloth touch anything in this frame?
  bool touches() const {
    return self_contacts || touches_others() || holders.any_slips() || !attachments.empty();
  }
  bool touches_others() const { return !frame_context.is_apart && has_colliders(); }
  /// Is no point pinned or attached?
  bool is_free() const { return holders.empty() && attachments.empty(); }
  bool has_colliders() const {
    return std::any_of(colliders.begin(), colliders.end(),
                       [](const MovingCollider& c) { return c.enabled(); });
  }
  /// Are all colliders out of reach in this frame? Sets allowed_displacement.
  bool is_out_of_reach();
  /// The cloth with the added inertia in a step of h [s].
  const Cloth& add_tension_mass(double h);
  void begin_offset();  // from colliders, by the state
  /// Does neither a collider nor a pin nor a grip move in this frame?
  bool is_still() const;
  /// Largest change of a point's speed by gravity, colliders and air in this frame [m/s].
  double speed_given() const;
  /// Largest relative speed of the cloth and a collider that it may reach in a frame [m/s].
  double contact_speed() const;

  Scene scene;
  LiveSpec scene_values;  // live values of the scene as loaded
  Cloth cloth;
  Cloth cloth_with_tension_mass;  // with added inertia; empty without strain limit
  State state;
  std::optional<Method> method;
  std::optional<StrainLimit> strain_limit;
  std::vector<MovingCollider> colliders;
  ColliderContacts collider_contacts;
  LaggedContact lagged_contact;
  RigidBodies bodies;  // of these colliders
  BodyContacts body_contacts;
  BodyAttachments attachments;
  std::optional<SelfContacts> self_contacts;
  Workers workers;
  std::vector<Vector3> pin_targets;
  Grips grips;
  Holders holders;  // of pins, then grips
  bool measures_wrenches = false;
  std::vector<Wrench> collider_impulses;  // of this frame [N s, N m s], where measured
  std::vector<Wrench> collider_wrenches;  // of the last frame
  EnergyWatch energy_watch;
  WorkBudget budget;  // left in the frame
  AirForces air;
  Points external_forces;                // [N], N x 3; no rows: none
  double last_substep = 0;               // [s]; 0: none since the last reset
  std::function<bool()> is_interrupted;  // empty: no calls
  unsigned topology_seq = 0;

  FrameContext frame_context;
  bool knows_offset = false;  // cloth.offset is that of the last frame
  bool disturbed = false;     // something jumped since the last frame
  bool is_given = false;      // the state was set: it may be arbitrary
  int given_crossings = 0;    // pairs of triangles of such a state that still cross
  Points detected_at;         // positions at a detection that later substeps use
  Points start;               // positions at the substep's start, where contact needs them
  Points start_velocities;    // the same [m/s]
  Points followed;            // velocities by which the points have moved, where contact needs them
  Points by_impulses;         // positions before projections, with self contact
  Points impulses;            // of the cloth on held points in a substep [N s]
};

}  // namespace clothsim
