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

/// What one frame did.
struct StepReport {
  std::string method;
  int substeps = 0;
  std::optional<double> predicted_error;  // see MethodChoice
  Reasons reasons;                        // for the method and its substeps
  int recoveries = 0;                     // times the frame was taken back and tried again
  int sweeps = 0;            // passes over strain limit and contacts, summed over the substeps
  int corrections = 0;       // passes that shortened springs still over the limit, likewise
  double worst_stretch = 0;  // largest l / L0 - 1 over the springs, at the frame's end
  int contacts = 0;          // points on colliders plus those of self contact, last substep
  double added_mass = 0;     // inertia that tension adds, of the cloth's mass, most in a substep
  int ran_out = 0;           // substeps whose method stopped iterating before its tolerance
  int held_back = 0;         // moves of points cut short lest the cloth cross itself
  int pinched = 0;           // points that two colliders leave no room, most in a substep
  int pinched_point = -1;    // one of them
  int slipping = 0;          // of the pinched that friction could hold: pulled out, last substep
  int crossings = 0;         // pairs of triangles, see Simulator::given_crossings()
  int lagging = 0;           // points behind the places of the pins and grips that hold them
};

/// How a pin or a grip holds on, over the last step.
struct HolderReport {
  std::string name;  // of the grip's frame, or "pin [column, row]"
  int first_point;   // of its points
  double strength;   // [N] that it can pull with
  double force;      // [N] that it pulls with, the mean over the step
  double lag;        // [m] of the point that is farthest behind its place; 0 where it sticks
};

/// Owns all state of a scene and advances it frame by frame. Not thread-safe.
class Simulator {
 public:
  /// Throws InvalidValue.
  explicit Simulator(const Scene&);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;

  /// Advances one frame, 1 / frames_per_second. A frame that ends in numbers that are not finite,
  /// or with more energy than was put in, is taken back. What the scene leaves to `auto` is then
  /// tried again: with a strain limit that yields, if it was not met; with implicit
  /// Euler, from here on until the next reset() or set(). If nothing is left to try, throws
  /// Diverged and keeps the last good frame; so it does after a budget of work that is counted, not
  /// timed: after set_state() a second's at 50 x 50 points, until a frame has succeeded; then that
  /// of all passes of all substeps that there may be.
  StepReport step();

  /// Has step() ask between substeps, in its own thread, whether it is to break off. If so it
  /// throws Interrupted and keeps the frame before; the next one goes on from there as after
  /// set_state() without a memory. None, the default, asks nobody.
  void set_interrupt(std::function<bool()> is_interrupted);

  /// Back to the scene's start at time 0, with the present live values.
  void reset();

  /// Live values as the scene came with them; nothing moves. Throws as set() does.
  void reset_values();

  /// Starts anew with another scene, as a new simulator would but that topology_seq() counts on.
  /// Throws InvalidValue and goes on as before where the scene is refused.
  void load(const Scene&);

  /// What the next frames depend on beside state(): impulses that constraints keep, a method's
  /// history, what was changed after a frame failed. Numbers to hand back to set_state().
  std::vector<double> memory() const;

  /// Goes on from `state`; colliders and pins stay where they are. With the memory that came with
  /// the state, to the same bits as then; without, as after a reset. Throws InvalidValue and
  /// changes nothing for another number of points, numbers that are not finite, positions beyond
  /// 1e12 m, velocities of 1000 m/s or more, a pin farther than 1 um from where it is, and the
  /// memory of another cloth or method.
  void set_state(const State& state, const std::vector<double>& memory = {});

  /// Pairs of triangles that cross since a state was set, or since surfaces were to keep apart, as
  /// of the last frame: with self collision of surfaces, which keeps apart what does not cross. Of
  /// a scene that asks for it (ClothSpec::untangle) they are taken apart then: these are left.
  int given_crossings() const;

  /// Takes the cloth apart where it crosses itself, see clothsim::untangle(); velocities stay. Goes
  /// on as after set_state() without a memory, where it has moved anything.
  Untangled untangle();

  /// A copy of all that moves, colliders, pins and attached points too, to come back to and go on
  /// to the same bits. Live values stay as they are; where springs, the
  /// method or the kind of self collision have changed since, goes on as after a reset. Throws
  /// InvalidValue and changes nothing for a copy of another cloth or of other colliders.
  struct Saved;
  std::shared_ptr<const Saved> save() const;
  void restore(const Saved&);

  /// What a copy takes of memory, but for a few hundred bytes.
  static std::size_t bytes_of(const Saved&);

  /// Change values between frames. Throw InvalidValue and change nothing when refused, keys as of
  /// validate(LiveSpec). Another thickness or kind of self collision forgets the impulses of the
  /// cloth on itself, and pushes apart what is too near then.
  void set(const LiveSpec&);
  void set(const Material&, const SimulationSpec&);
  void set_material(const Material&);
  void set_simulation(const SimulationSpec&);

  /// Sets the mean wind [m/s] alone. Throws InvalidValue with keys {"wind", "0"} and so on.
  void set_wind(const Vector3& wind);

  /// Has `forces` [N], N x 3, act on the points besides gravity, from the next frame on until they
  /// are set anew or reset() ends them. No rows: none do. Of points that something holds, that
  /// feels them. Throws InvalidValue with the key {"forces", "3", "0"} and changes nothing: for
  /// another number of points, and for numbers that are not finite or beyond 1e6 N.
  void set_forces(const Points& forces);
  const Points& forces() const;  // no rows: none

  /// Tension [N] of each spring, in the order of cloth().springs, negative where it pushes: by
  /// Hooke's law with internal damping, where the springs are, and what the strain limit has them
  /// pull beyond that, as of the last substep.
  std::vector<double> tensions() const;

  // Poses and points to move to: throw InvalidValue and change nothing beyond 1e12 m, for numbers
  // that are not finite, and for an orientation that is no unit quaternion; std::out_of_range for
  // an index or a frame that there is not.

  /// Moves collider `index` (of scene().colliders) to `target` during the next frame, in a straight
  /// line with constant angular velocity. Without a call it stays.
  void move_collider(int index, const Pose& target);

  /// Puts collider `index` at `pose` at once; it has no velocity from it.
  void place_collider(int index, const Pose& pose);

  /// Turns collider `index` on or off, until reset(). Off, it follows where it is moved and touches
  /// nothing. Cloth that it is turned on in is pushed out as by place_collider().
  void enable_collider(int index, bool enabled);

  /// Moves pin `index` (of scene().cloth.pinned) to `target` [m] during the next frame.
  void move_pin(int index, const Vector3& target);

  /// Puts pin `index` at `position` [m] at once, at rest.
  void place_pin(int index, const Vector3& position);

  /// From the next frame on, `points` follow a frame of that name, now at `pose`, with the offsets
  /// that they have in it, as long as the cloth pulls with less than the grip's strength: see
  /// Holders. Beyond the tear force on the frame, the mean of one step(), it lets go of all its
  /// points; of calls for one frame the last one's forces hold. Until reset(). Throws InvalidValue
  /// with the keys {"points", "3"}, {"tear_force"} or {"strength"} and changes nothing: without
  /// points, for points that are none, given twice, pinned or attached.
  void attach(const std::string& frame, const Pose& pose, const std::vector<int>& points,
              const GripForces& forces = {});

  /// The points within `radius` [m] of `position` that nothing holds, ascending. Throws
  /// InvalidValue with the key {"radius"} where there is none, and for a radius that is no number
  /// from 0 to 1e6.
  std::vector<int> free_points_near(const Vector3& position, double radius) const;

  /// Lets points go, with the velocity they have. Throws InvalidValue for one that is not attached.
  void detach(const std::vector<int>& points);

  /// Moves the frame to `target` during the next frame of simulation, each of its points in a
  /// straight line.
  void move_grip(const std::string& frame, const Pose& target);

  /// All that hold points: pins as in the scene, then grips by frame. Zero forces before the first
  /// step().
  std::vector<HolderReport> holders() const;

  /// By frame, with what the cloth did to it in the last step().
  const std::map<std::string, Grip>& grips() const;

  /// Has step() sum up what the cloth does to the colliders, from the next frame on. Off at first:
  /// then nothing is spent on it. No motion depends on it.
  void measure_wrenches(bool asks);
  bool measures_wrenches() const;

  /// By collider of scene().colliders, in the world: mean force [N] of the cloth on it in the last
  /// step(), and torque [N m] about the origin of its frame, where that was meanwhile. A cloth at
  /// rest presses with its weight. Impulses on velocities count, normal and friction, of points,
  /// edges and faces; moves of positions do not, nor do pinched points tell how hard both jaws
  /// press. Zero where nobody asked, and after reset().
  const std::vector<Wrench>& collider_wrenches() const;

  const Scene& scene() const;  // with the present material and simulation values
  const Cloth& cloth() const;

  /// Its arrays stay where they are in memory as long as the simulator, but for load().
  const State& state() const;

  const Pose& collider_pose(int index) const;
  bool collider_enabled(int index) const;
  double frame_duration() const;  // [s]

  /// What the next frame is integrated by, as it was chosen or as a failed frame has left it.
  const MethodChoice& choice() const;

  /// Counts up whenever the springs or the points of cloth() change.
  unsigned topology_seq() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace clothsim
