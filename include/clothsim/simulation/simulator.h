#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/constraints/untangle.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/scene/scene.h"
#include "clothsim/shapes/collider.h"
#include "clothsim/simulation/grips.h"
#include "clothsim/simulation/method_choice.h"
#include "clothsim/simulation/reasons.h"

namespace clothsim {

/// Pose and velocities of a rigid body.
struct BodyMotion {
  Pose pose;                 // of the shape in the world
  Vector3 velocity;          // of the centre of mass [m/s]
  Vector3 angular_velocity;  // in the world [rad/s]
};

/// Results of one call of step(), which computes one frame in substeps.
struct StepReport {
  std::string method;
  int substeps = 0;
  std::optional<double> predicted_error;  // see MethodChoice
  Reasons reasons;                        // for the method and its substeps
  int recoveries = 0;                     // repetitions of the frame after a failure
  int sweeps = 0;            // passes over strain limit and contacts, summed over the substeps
  int corrections = 0;       // passes that projected springs still over the limit, summed as well
  double worst_stretch = 0;  // largest l / L0 - 1 over the springs, at the frame's end
  double violation = 0;      // largest of these beyond the strain limit of its cloth
  int contacts = 0;          // points on colliders plus self contacts, last substep
  double added_mass = 0;     // largest inertia added for tension in a substep / cloth's mass
  int ran_out = 0;           // substeps in which the method stopped before its tolerance
  int held_back = 0;         // points truncated by the guard, summed over the substeps
  int pinched = 0;           // largest number in a substep of points without room between two
                             // colliders
  int pinched_point = -1;    // one of them
  int slipping = 0;          // pinched points that the strain limit pulls loose, last substep
  int crossings = 0;         // pairs of triangles, see Simulator::given_crossings()
  int lagging = 0;           // points that slip behind the pin or grip that holds them
};

/// State of a pin or a grip over the last frame.
struct HolderReport {
  std::string name;  // of the grip's tf frame, or "pin [column, row]"
  int first_point;   // first of its points, an index in the cloth
  double strength;   // largest pull [N]
  double force;      // sum over its points of the mean pull's magnitude in the frame [N]
  double lag;        // largest distance of a point from its place [m]; 0 where it sticks
};

/// The simulation of a scene. Owns its state and advances it frame by frame. Not thread-safe.
class Simulator {
 public:
  /// Throws InvalidValue.
  explicit Simulator(const Scene&);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// Advances one frame of 1 / frames_per_second. A frame with numbers that are not finite, or with
  /// more energy than work can explain, is taken back. With method `auto` it is repeated with
  /// implicit Euler, which stays until reset() or set(). If that fails, too, or with another
  /// method, throws Diverged and keeps the last good frame. A frame that exceeds its budget of
  /// operations also throws Diverged. The budget is one visit to each point in each pass of each
  /// possible substep; for the first frame after set_state() it is about a second's work at 50 x 50
  /// points. An exception from a substep, as of a library that cannot be loaded, keeps the frame
  /// before, too.
  StepReport step();

  /// step() calls `is_interrupted` between substeps, in its own thread. If it returns true, step()
  /// throws Interrupted and keeps the state of the frame before; the next step() continues from
  /// there as after set_state() without a memory. An empty function, the default, is not called.
  void set_interrupt(std::function<bool()> is_interrupted);

  /// Back to the scene's start at time 0, with the present live values.
  void reset();

  /// Sets the live values of the scene as loaded; nothing moves. Throws as set() does.
  void reset_values();

  /// Replaces the scene, with the effect of a new simulator, except that topology_seq() counts on
  /// and that the settings of set_interrupt() and measure_wrenches() stay. Throws InvalidValue and
  /// changes nothing where the scene is refused.
  void load(const Scene&);

  /// The data on which the next frames depend besides state(): warm-start impulses, a method's
  /// history, the change of method after a failed frame. To be passed to set_state().
  std::vector<double> memory() const;

  /// Continues from `state`; colliders and pins stay where they are. With the memory that belongs
  /// to the state, the run continues to the same bits; without a memory, it continues as after a
  /// reset. Throws InvalidValue and changes nothing for a wrong number of points, numbers that are
  /// not finite, positions beyond 1e12 m, velocities of 1000 m/s or more, a pin farther than 1 um
  /// from its place, and the memory of another cloth or method.
  void set_state(const State& state, const std::vector<double>& memory = {});

  /// Number of pairs of triangles that still cross after the last frame, with self collision
  /// `surface`; 0 with any other. The guard prevents new crossings: these come from a state that
  /// was set, or from before `surface` was switched on. With ClothSpec::untangle, only those that
  /// could not be resolved.
  int given_crossings() const;

  /// Resolves crossings of the cloth with itself, see clothsim::untangle(); velocities stay. If
  /// anything has moved, continues as after set_state() without a memory.
  Untangled untangle();

  /// A copy of everything that moves, also of colliders, pins and attached points. After restore()
  /// a run continues to the same bits. Live values stay as they are; where springs, the method or
  /// the kind of self collision have changed since save(), positions and velocities are restored,
  /// but not the impulses and the history of the method. Throws InvalidValue and changes nothing
  /// for a copy of another cloth or of other colliders.
  struct Saved;
  std::shared_ptr<const Saved> save() const;
  void restore(const Saved&);

  /// Memory of a copy [bytes], except for a few hundred.
  static std::size_t bytes_of(const Saved&);

  /// Change values between frames. Throw InvalidValue, with keys as in validate(LiveSpec), and
  /// change nothing if a value is refused. Another thickness or kind of self collision clears the
  /// impulses of self contact; features that are too near with it are pushed apart.
  void set(const LiveSpec&);
  void set(const Material&, const SimulationSpec&);
  void set_material(const Material&);
  void set_simulation(const SimulationSpec&);

  /// Sets the mean wind [m/s] alone. Throws InvalidValue with keys {"wind", "0"} and so on.
  void set_wind(const Vector3& wind);

  /// Sets `forces` [N], N x 3, a row for each point, in addition to gravity, from the next frame on
  /// until another call or reset(). No rows: no forces. The force on a held point does not move the
  /// point: it loads the pin or grip. Throws InvalidValue and changes nothing: with the key
  /// {"forces"} for a wrong number of rows, with {"forces", "3", "0"} for numbers that are not
  /// finite or beyond 1e6 N.
  void set_forces(const Points& forces);
  const Points& forces() const;  // no rows: none

  /// Tension [N] of each spring, in the order of cloth().springs, negative under compression:
  /// k (l - L) with internal damping in the present state, plus the pull of the strain limit in the
  /// last substep. Diagonals of a fabric's grid have that of the limit alone, as cells resist
  /// shear. Of a mesh: of each edge, by the membranes of both triangles.
  std::vector<double> tensions() const;

  // The functions below that take a pose or a position throw InvalidValue and change nothing beyond
  // 1e12 m, for numbers that are not finite, and for an orientation that is no unit quaternion.
  // They throw std::out_of_range for an index or a tf frame that does not exist.

  /// Moves collider `index` (of scene().colliders) to `target` during the next frame, in a straight
  /// line with constant angular velocity. Without a call it stays.
  void move_collider(int index, const Pose& target);

  /// Puts collider `index` at `pose` at once, without a velocity from the change. Cloth inside it
  /// is then pushed out gently.
  void place_collider(int index, const Pose& pose);

  /// Whether collider `index` has the mass of a rigid body; its parts have not. move_collider() and
  /// place_collider() throw InvalidValue for a body and its parts, the next functions for any other
  /// collider.
  bool is_body(int index) const;
  BodyMotion body_motion(int index) const;

  /// Puts a body at `pose` at once, with these velocities: of its centre of mass [m/s], and angular
  /// in the world [rad/s]. Throws InvalidValue beyond velocity_range and angular_velocity_range,
  /// and with the key {"pose"} for a pose that its joint does not allow.
  void set_body(int index, const Pose& pose, const Vector3& velocity,
                const Vector3& angular_velocity);

  /// From the next frame of simulation on, and until reset(), a body follows a tf frame, now at
  /// `pose`, with its present offset in it: see move_grip(). Throws InvalidValue for a body that a
  /// tf frame holds already, and for the name of a body as `frame`.
  void attach_body(int index, const std::string& frame, const Pose& pose);

  /// Lets a body go, with its velocity of the last frame. Throws InvalidValue for a body that no tf
  /// frame holds.
  void detach_body(int index);

  /// The tf frame that holds a body.
  std::optional<std::string> frame_of_body(int index) const;

  /// The index of the body of that name.
  std::optional<int> body_named(const std::string& name) const;

  /// Enables or disables collider `index`, until reset(). A disabled collider moves but has no
  /// contact. Cloth inside a collider as it is enabled is pushed out as after place_collider().
  void enable_collider(int index, bool enabled);

  /// Moves pin `index` (of scene().cloth.pinned) to `target` [m] during the next frame.
  void move_pin(int index, const Vector3& target);

  /// Puts pin `index` at `position` [m] at once, at rest.
  void place_pin(int index, const Vector3& position);

  /// From the next frame of simulation on, and until reset(), `points` follow a tf frame of that
  /// name, now at `pose`, with their present offsets in it, as long as their load is below the
  /// grip's strength: see Holders. If the mean force on the tf frame in one step() exceeds the tear
  /// force, all its points are released. If attach() is called again for a tf frame, the `forces`
  /// of the last call apply to all its points. If `frame` is the name of a rigid body, the points
  /// are attached to the body, which feels their pull; `pose` has no effect then. Throws
  /// InvalidValue with the keys {"points", "3"}, {"tear_force"} or {"strength"} and changes
  /// nothing: without points, for points that do not exist, given twice, pinned or attached.
  void attach(const std::string& frame, const Pose& pose, const std::vector<int>& points,
              const GripForces& forces = {});

  /// The free points within `radius` [m] of `position`, ascending. Throws InvalidValue with the key
  /// {"radius"} where there is none, and for a radius that is no number from 0 to 1e6.
  std::vector<int> free_points_near(const Vector3& position, double radius) const;

  /// Detaches points, which keep their velocity. Throws InvalidValue for a point that is not
  /// attached.
  void detach(const std::vector<int>& points);

  /// Moves the tf frame to `target` during the next frame of simulation, each of its points in a
  /// straight line, its bodies as by move_collider(), and along their joints. Throws InvalidValue
  /// where the points are attached to a body.
  void move_grip(const std::string& frame, const Pose& target);

  /// All holders: pins as in the scene, then grips by tf frame. Zero forces before the first
  /// step().
  std::vector<HolderReport> holders() const;

  /// By tf frame, with the wrench of the cloth in the last step().
  const std::map<std::string, Grip>& grips() const;

  /// Whether step() sums the wrenches of the cloth on the colliders, from the next frame on. Off by
  /// default, at no cost. No motion depends on it.
  void measure_wrenches(bool asks);
  bool measures_wrenches() const;

  /// By collider of scene().colliders, in the axes of the world: mean force [N] of the cloth on it
  /// in the last step(), and mean torque [N m] about its own origin, which moves with it. A cloth
  /// at rest presses with its weight. Included are the impulses on velocities, normal and friction,
  /// of points, edges and faces. Not included are projections of positions and, at pinched points,
  /// the pressure of both colliders on each other. Zero unless measured, and after reset().
  const std::vector<Wrench>& collider_wrenches() const;

  /// The same on a body, with all of its colliders and the points that are attached to it, about
  /// the origin of its frame. Throws InvalidValue for any other collider.
  Wrench body_wrench(int index) const;

  const Scene& scene() const;  // with the present material and simulation values
  const Cloth& cloth() const;

  /// Its arrays stay at their addresses as long as the simulator exists, except after load().
  const State& state() const;

  const Pose& collider_pose(int index) const;
  bool collider_enabled(int index) const;
  double frame_duration() const;  // [s]

  /// The method of the next frame: the chosen one, or implicit Euler after a failed frame.
  const MethodChoice& choice() const;

  /// Counts up whenever the springs or the points of cloth() change.
  unsigned topology_seq() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
