#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/constraints/collider_contacts.h"
#include "clothsim/constraints/self_contacts.h"
#include "clothsim/constraints/strain_limit.h"
#include "clothsim/dynamics/air.h"
#include "clothsim/dynamics/integrator.h"
#include "clothsim/dynamics/spectrum.h"
#include "clothsim/model/checks.h"
#include "clothsim/model/grid.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/work_budget.h"
#include "clothsim/shapes/moving_collider.h"
#include "clothsim/simulation/energy_watch.h"
#include "clothsim/simulation/grips.h"
#include "clothsim/simulation/method_choice.h"
#include "clothsim/simulation/simulator.h"
#include "clothsim/simulation/substeps.h"

namespace clothsim {

/// The method that `auto` goes on with after a frame failed: its energy never rises.
inline constexpr const char* refuge = ImplicitEuler::name;

/// Where points may be, on each axis [m].
inline constexpr double farthest = place_range.max;

/// Passes over the constraints in a substep, at most: met only in a shock.
inline constexpr int max_passes = 200;

/// How a scene with `cloth` is integrated, and by what.
struct Method {
  Method(const SimulationSpec& spec, const Cloth& cloth, const std::vector<ColliderSpec>& colliders)
      : choice(choose_method(spec, cloth, colliders)),
        integrator(make_integrator(choice.method, spec.method_parameters)),
        omega_max(omega_max_bound(cloth)) {}

  /// Substeps of a frame from `positions`, `at_speed` at least.
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

/// The method to go on with after a frame failed, in as few steps as it can: what constraints ask
/// for may be what failed.
inline Method last_resort(SimulationSpec spec, const Cloth& cloth,
                          const std::vector<ColliderSpec>& colliders, const Reasons& reasons) {
  spec.method = refuge;
  Method method(spec, cloth, colliders);
  method.choice.reasons = reasons;
  method.choice.min_substeps = 1;
  return method;
}

/// Changes of a pass up to which constraints count as solved, as displacements in its step [m].
struct Precision {
  double stretch = 0;      // of springs
  double touch = 0;        // of what colliders touch
  double fold = 0;         // of the cloth on itself
  double unseen_fold = 0;  // that a pass leaves out
};

/// What one try of a frame goes by.
struct FrameContext {
  double dt = 0;           // [s]
  double h = 0;            // of the substep at hand [s]
  double left = 0;         // of it, with the substep at hand [s]
  double motion_step = 0;  // what all but the springs ask for [s]
  // Of substeps that go on with what an earlier one found, see simulator_search.cpp.
  int planned_steps = 0;                // those that what is sought in this one is for, with it
  int steps_left = 0;                   // those that are left of it
  double since = 0;                     // it was sought, with the one at hand [s]
  double gone = 0;                      // by a point and a collider since then, at most [m]
  double may_go = 0;                    // as much until it is sought anew [m]
  double collider_speed = 0;            // fastest that may be met until then [m/s]
  Precision closeness = {};             // that they are solved to
  bool is_apart = false;                // nothing is looked for at colliders
  double allowed_way = 0;               // of points, where it is [m]
  double approach_speed = 0;            // of what it may touch against the cloth [m/s]
  bool is_fast = false;                 // with that, springs may be parted within the frame
  double stretch = 0;                   // worst as it began, where colliders ask for it
  Vector3 wind{0, 0, 0};                // [m/s], where there is air
  double external_acceleration = 0;     // most that forces from outside give a point [m/s^2]
  bool recovers = false;                // colliders have pushed out what was in them
  bool projection_unconverged = false;  // before all springs were within their limit
  bool gives_way = false;               // the strain limit, in any substep
};

/// How a try of a frame ended.
enum class Outcome {
  good,
  went_too_far,  // points, in a frame without a look at colliders
  failed         // in a state that cannot be, or with the budget spent
};

struct Simulator::Impl {
  explicit Impl(const Scene&);

  void reset() {
    const State first = start_state(scene.cloth, cloth, scene.simulation.seed);
    state = first;  // into the same memory
    pin_targets.resize(scene.cloth.pinned.size());
    for (std::size_t i = 0; i < pin_targets.size(); ++i) {
      pin_targets[i] = state.positions.row(pin_point(i)).transpose();
    }
    grips.clear();
    holders = {};
    hold_points();
    for (std::size_t i = 0; i < colliders.size(); ++i) {
      colliders[i].place(scene.colliders[i].pose * scene.colliders[i].offset);
      colliders[i].enable(scene.colliders[i].enabled);
    }
    collider_wrenches.assign(colliders.size(), {});
    external_forces.resize(0, 3);
    last_substep = 0;
    forget();
    disturbed = is_given = false;
    given_crossings = 0;
  }

  /// The cloth as the scene has it, without what is attached: the method is chosen for that, so
  /// that the choice does not depend on when it was made.
  Cloth without_grips() const {
    Cloth free = cloth;
    hold_pins(free);
    return free;
  }

  /// Drops what methods and constraints remember of earlier steps.
  void forget() {
    method.emplace(scene.simulation, without_grips(), scene.colliders);
    forget_constraints();
    self_contacts = make_self_contacts(cloth);  // with what it knows of where features were
    energy_watch.restart();
  }

  /// Takes the method that the scene asks for now. Goes on with the present one where it is the
  /// same, unless it is to be `anew`.
  void choose(bool anew) {
    const Cloth free = without_grips();
    const MethodChoice choice = choose_method(scene.simulation, free, scene.colliders);
    if (anew || choice.method != method->choice.method) {
      method.emplace(scene.simulation, free, scene.colliders);
    } else {
      method->choice = choice;
      method->omega_max = omega_max_bound(free);
    }
  }

  void forget_constraints() {
    if (strain_limit) strain_limit->reset();
    collider_contacts.reset();
    if (self_contacts) self_contacts->reset();
  }

  void build_strain_limit() {
    strain_limit.reset();
    if (!cloth.strain_limit || cloth.springs.empty()) return;
    strain_limit.emplace(cloth, &budget);
    cloth_with_tension_mass = cloth;
  }

  int pin_point(std::size_t pin) const {
    const Pin& p = scene.cloth.pinned[pin];
    return p.row * scene.cloth.columns + p.column;
  }

  /// Drops what the method remembers of another material.
  void forget_history() {
    if (auto* bdf2 = std::get_if<Bdf2>(&method->integrator)) bdf2->forget();
  }

  void write(MemoryWriter&) const;
  /// Whether the numbers are a memory of such a cloth, scene and method.
  bool fits(const std::vector<double>& memory) const;
  /// Throws InvalidValue and changes nothing where the numbers are not those of such a scene.
  void read(const std::vector<double>&);
  void set_state(const State&, const std::vector<double>& memory);
  /// Counts what crosses in a state that was given, or takes it apart where the scene asks for it.
  void look_for_crossings();
  Untangled untangle();

  /// Holds the pins alone.
  static void hold_pins(Cloth&);
  /// To be called when other points are attached.
  void hold_points();
  /// To be called when points that are held stick or slip: each of which has another mass then.
  void follow_holders();
  /// Where pins and grips are to be as the frame ends [m], as holders have them.
  std::vector<Vector3> hold_targets() const;
  /// After a substep of h [s]: what holds on, what gives way.
  void judge_holders(double h);
  /// Adds to `collider_impulses` what a substep of h [s] gave.
  void add_collider_impulses(double h);
  /// Weighs what colliders carry after a frame of dt [s].
  void finish_colliders(double dt);
  /// Measures what grips carry after a frame of dt [s], and lets go what has torn off.
  void finish_grips(double dt, const State& before);

  /// Throws where `auto` cannot choose a step for a cloth, naming the value that `key` leads to.
  void check_feasible(const SimulationSpec&, const Cloth& with,
                      const std::vector<std::string>& key) const;
  /// Drops what self contact knows of another kind of contact, thickness or mass.
  void renew_self_contacts(const Cloth& last, const Cloth& now);
  /// To that of the scene.
  void set_collider_friction();

  StepReport step();
  /// Tries a frame until it succeeds. Throws Diverged where nothing is left to try.
  StepReport step_with_retries(const State& last_good);
  /// One frame; whether it `may_be_apart` from colliders.
  Outcome frame(bool may_be_apart, const State& before, StepReport&);
  /// Pins and what is attached set out for where they must be at the frame's end.
  void begin_frame();
  /// Pins and colliders arrive there, to the last bit. Pins that slip, or that the cloth itself
  /// blocks, stop short.
  void snap_to_targets();
  /// Substeps that the frame begins with.
  int first_substeps();
  /// False where the state has left the finite numbers, or the budget is spent.
  bool take_substeps(int steps, const State& before, StepReport&);
  /// After a step of h [s] in which points were held back: do layers that no two colliders press
  /// together go farther than they are thick?
  /// That a point of the cloth may bear [N]: its weight, or the strength of a holder that slips.
  double strongest_pull() const;
  bool outruns_contacts(double h, const StepReport&) const;
  /// Why the frame was as it was.
  void tell_reasons(StepReport&) const;
  /// Can what has driven the frame explain its end?
  bool is_explained(const State& before, const StepReport&);
  /// Gets ready to try a failed frame again. False where nothing is left to try.
  bool recover();
  /// False where the state has left the finite numbers, or the budget is spent.
  bool substep(double h, StepReport&);
  /// Plans how many substeps of h [s] what is near now is for, with this one.
  void plan_detection(double h);
  /// How far points and colliders may go, together, before they meet what was not near [m]. Sets
  /// the speed of these colliders.
  double max_undetected();
  /// After one of h [s] that sought, and one that went on: do others?
  void end_detection(double h);
  void count_displacement(double h);
  bool may_skip_detection(double h) const;
  /// May others go on at all? Not where springs are at their limit, nor while colliders push out or
  /// pinch: steps follow what they ask of each other.
  bool is_settled() const;
  /// Fastest of a point with these velocities and a collider [m/s].
  double max_speed(const Points& velocities) const {
    return longest_row(velocities) + frame_context.collider_speed;
  }
  /// What contacts go by in a substep of h [s].
  ContactStep contact_step(double h, double displacement_factor, const SelfTouches&);
  /// `inert`: the cloth with the inertia of this step.
  void constrain(const Cloth& inert, double h, StepReport&);
  /// The same where the cloth can touch nothing, to `length` [m] of strain.
  void limit_alone(const Cloth& inert, double h, double displacement_factor, double length,
                   StepReport&);
  /// Goes on with what was near before: aims anew what pushes, and gives it its impulses.
  void refresh_contacts(const ContactStep&);
  /// Finds what touches, and gives it the last step's impulses.
  void prepare_contacts(const ContactStep&, StepReport&);
  /// How closely to solve a step of h [s], to a `tolerance` of strain and its `length` [m].
  Precision precision_of(double h, double tolerance, double length) const;
  /// Passes over all constraints until they change next to nothing.
  void solve(bool runs_detection, StepReport&);
  /// Passes over the strain limit in a substep, at most.
  int max_limit_passes() const;
  /// Takes from the frame's budget so many visits to each point.
  void spend(double visits_a_point) {
    budget.spend(static_cast<std::int64_t>(visits_a_point * cloth.num_points()));
  }
  /// Gives the points what air does in h [s].
  void apply_wind(double h);
  /// Gives the points, with the inertia of this step, what forces from outside do in h [s].
  void apply_external_forces(const Cloth& inert, double h);
  /// Most that these give a point [m/s^2].
  double max_external_acceleration() const;
  /// Most that these can have done in a frame of dt [s] [J].
  double work_of_external_forces(double dt, const State& before) const;

  /// How far springs may be stretched at the end of a substep of `h` [s], l / L0 - 1: as they are,
  /// and what colliders may part their ends by meanwhile.
  double stretch_after(double h) const;
  bool has_air() const { return scene.simulation.wind || scene.simulation.gusts > 0; }
  /// Fastest that the wind of this frame and the cloth move against each other [m/s].
  double air_speed() const { return frame_context.wind.norm() + longest_row(state.velocities); }
  /// Shortens the springs that are over their limit. Returns the passes taken, at most
  /// `pass_limit`.
  int project_springs(const Cloth&, int pass_limit, StepReport&);
  /// Shortens what is left over its limit.
  void project_positions(const Cloth&, StepReport&);
  /// Holds back what would cross itself, and repairs what hangs on that.
  void guard(const ContactStep&, StepReport&);
  void project_beside_truncated(const ContactStep&, StepReport&);
  /// Sets the budget of a frame of dt [s], with all that is tried but Newton's steps, of which the
  /// method has a most of its own.
  void allow_work(double dt);
  /// Substeps of a frame of dt [s] that the scene or its springs ask for, whatever the state.
  double min_substeps(double dt) const;
  /// Whether steps of h [s] leave the method's limit for the springs as they are.
  bool is_beyond_stability(double h) const;
  /// Do substeps follow tension?
  bool follows_tension() const;
  /// Substeps of `dt` [s] that the tension of now asks for, at least `min_steps`.
  int substeps_under_tension(double dt, int min_steps) const;
  /// Substeps of a frame that springs which part fast need, where their limit can hold them.
  int substeps_for_parting(double dt) const;
  /// Can the cloth touch anything in this frame?
  bool touches() const { return self_contacts || touches_others() || holders.any_slips(); }
  bool touches_others() const { return !frame_context.is_apart && has_colliders(); }
  /// Is no point pinned or attached?
  bool is_free() const { return holders.empty(); }
  bool has_colliders() const {
    return std::any_of(colliders.begin(), colliders.end(),
                       [](const MovingCollider& c) { return c.enabled(); });
  }
  /// Are all colliders out of reach of the cloth in this frame, while its points go no farther
  /// than they are allowed to, which this sets?
  bool is_out_of_reach();
  /// The cloth with the inertia that tension adds in a step of h [s].
  const Cloth& add_tension_mass(double h);
  /// A frame in which neither colliders move, nor pins or grips?
  bool is_still() const;
  /// What gravity, colliders and air may give a point in this frame, at most [m/s].
  double speed_given() const;
  /// Fastest that the cloth and a collider it may reach in a frame move against each other [m/s].
  double contact_speed() const;

  Scene scene;
  LiveSpec scene_values;  // live values as the scene came with them
  Cloth cloth;
  Cloth cloth_with_tension_mass;  // with the inertia that tension adds; empty without strain limit
  State state;
  std::optional<Method> method;
  std::optional<StrainLimit> strain_limit;
  std::vector<MovingCollider> colliders;
  ColliderContacts collider_contacts;
  std::optional<SelfContacts> self_contacts;
  Workers workers;
  std::vector<Vector3> pin_targets;
  Grips grips;
  Holders holders;  // of pins, then grips
  bool measures_wrenches = false;
  std::vector<Wrench> collider_impulses;  // of this frame [N s, N m s], where these are weighed
  std::vector<Wrench> collider_wrenches;  // of the last frame
  EnergyWatch energy_watch;
  WorkBudget budget;  // left of a frame's
  AirForces air;
  Points external_forces;                // forces on points from outside [N], N x 3; no rows: none
  double last_substep = 0;               // [s]; 0: none since the last reset
  std::function<bool()> is_interrupted;  // none: nobody asks
  unsigned topology_seq = 0;

  FrameContext frame_context;
  bool disturbed = false;   // by a jump since the last frame
  bool is_given = false;    // state that was set: it may be anything
  int given_crossings = 0;  // of triangles, left of such a state
  Points detected_at;       // positions when contacts were sought that others went on with
  Points start;             // positions at the substep's start, where contact needs them
  Points start_velocities;  // the same [m/s]
  Points followed;          // velocities that have moved the points, where contact needs them
  Points by_impulses;       // positions before repairs and push-outs, with self contact
  Points impulses;          // that points which are held had from others in a substep [N s]
};

}  // namespace clothsim
