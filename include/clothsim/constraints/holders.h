#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/dynamics/cells.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// A point of the cloth that a holder, a pin or a grip, brings to its target.
struct Hold {
  int point;   // index in the cloth
  int holder;  // number of the holder, which may hold several points
};

/// The holders of a cloth, pins and grips, each with a strength S [N], and the points they hold. A
/// parameter `hold` is a number in the list of hold(), `point` an index in the cloth.
///
/// A point sticks while its load is below its share P of the strength S: it is kinematic, of
/// infinite mass. Above that it slips: it has its own mass, and the holder pulls it towards its
/// target with the force P. Once the load is lower, the holder brings the point back, and it sticks
/// again at its target. A part f P acts as Coulomb friction, so that a slip comes to rest. The
/// force F on the point and its velocity follow one monotone law:
///
///   F = P                 while the point moves away,
///   F from (1 - f) P to P while it stays behind its target, at rest relative to the holder,
///   F up to (1 - f) P     while it comes back, at a speed of (distance / return_time) at most.
///
/// A held point that is moved against a collider slips, too, so that the collider stops it.
class Holders {
 public:
  /// Holds these points, with the holders' `strengths` [N]. Points that were held before keep their
  /// state; others stick where they are. A holder without a strength gets ten times its `weight`
  /// of `weights`, of its cloth and the bodies [N], enough for a robot that lifts, shakes and
  /// swings it, plus the force that stretches all springs of its points to their strain limit, or
  /// by a tenth where there is none: the loads of a light and stiff cloth exceed its weight.
  void hold(const std::vector<Hold>&, const std::vector<std::optional<double>>& strengths,
            const Cloth&, const Scalars& weights, const Points& positions);

  bool empty() const { return points_.empty(); }
  bool holds(int point) const;
  /// The holder of each point of the cloth, -1 for a free one.
  std::vector<int> holder_of_points(const Cloth&) const;

  /// Sets Cloth::held, and the inverse masses of held points: 0 for those that stick, 1 / mass for
  /// those that slip.
  void apply(Cloth&) const;

  /// Begins a frame of dt [s] in which the points move to `targets` [m], in the order of hold().
  void begin_frame(const std::vector<Vector3>& targets, double dt, State&);
  /// Puts points that stick at their targets, to the last bit.
  void end_frame(State&) const;
  /// Puts a point at its target [m] at once, where it sticks.
  void place(std::size_t hold, const Vector3& target, State&);

  /// To be called as a substep of h [s] begins, with the colliders at their poses of its end.
  /// Points that are pressed against a collider slip. Returns whether the set of points that stick
  /// has changed.
  bool begin_substep(double h, const Cloth&, const std::vector<MovingCollider>&,
                     const Points& positions);

  /// Sets the velocities at which slipping points should return, and applies the impulses of the
  /// last step.
  void warm_start(const Cloth&, const ContactStep&, State&);
  /// One pass over slipping points. Returns the largest change of a velocity [m/s].
  double solve_pass(Points& velocities);

  /// After a substep of h [s]: lets points slip, or stick again. Returns whether any did.
  /// `impulses`: of the cloth on each point that sticks [N s], N x 3.
  bool update_slipping(const Cloth&, double h, const Vector3& gravity, const Points& impulses,
                       State&);

  /// Adds the impulses [N s] of springs and bends in a substep of h [s] to the rows of points that
  /// stick.
  void add_spring_impulses(const Cloth&, double h, const State&, Points& impulses) const;
  /// Adds the impulses [N s] of constraints at the end of a substep of h [s] to the rows of all
  /// held points.
  void add_end_impulses(const Cloth&, double h, const Points& at_end, Points& impulses) const;
  /// Sets the rows of all held points to zero.
  void clear_rows(Points& impulses) const;

  bool any_sticks() const { return slipping_ < points_.size(); }
  bool any_slips() const { return slipping_ > 0; }
  int slipping() const { return static_cast<int>(slipping_); }

  std::size_t count() const { return points_.size(); }
  double strength(int holder) const { return strengths_[static_cast<std::size_t>(holder)]; }
  /// The largest strength of a holder [N].
  double strongest() const { return *std::max_element(strengths_.begin(), strengths_.end()); }
  int point(std::size_t hold) const { return points_[hold].hold.point; }
  bool sticks(std::size_t hold) const { return !points_[hold].slips; }
  /// Impulse [N s] of the cloth on the holder through this point in the frame, without that of the
  /// point's own acceleration.
  const Vector3& frame_impulse(std::size_t hold) const { return points_[hold].frame_impulse; }
  /// Sum over a holder's points of the magnitude of its mean force [N] in the frame of dt [s].
  double force(int holder, double dt) const;
  /// Distance of the point from its target [m], after end_frame().
  double lag(std::size_t hold, const Points& positions) const {
    return points_[hold].slips ? (points_[hold].target - row(positions, point(hold))).norm() : 0;
  }
  /// Bound on the work [J] of holders in the frame on the points that slip now.
  double work() const;

  /// The state, as memory_size() numbers. `read` throws InvalidValue for data that is not from
  /// `write`.
  std::size_t memory_size() const;
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  struct Point {
    Hold hold;
    Vector3 start;   // place as the frame begins, or as the point sticks again [m]
    Vector3 target;  // place as the frame ends [m]
    bool slips = false;
    bool is_pressed = false;   // against a collider
    double max_force = 0;      // largest force of the holder on it [N]
    double time = 0;           // h shortened by drag [s]: impulse at a substep's end / force
    double begun = 0;          // time in the frame when it was at `start` [s]
    Vector3 impulse{0, 0, 0};  // on the point in the last substep [N s]
    Vector3 want{0, 0, 0};     // wanted velocity towards the target [m/s]
    Vector3 carried{0, 0, 0};  // velocity of the holder [m/s]
    Vector3 given{0, 0, 0};    // impulse of the cloth on the holder in the substep [N s]
    Vector3 frame_impulse{0, 0, 0};
    double work = 0;  // in the frame, at most [J]
    double mass = 0;  // [kg]
  };

  /// A pair of points, one of them held: a spring with the force k (l - L) u, a bend with the force
  /// `bend` d, or both, with their damping. d leads from the held point to the other one.
  struct Spring {
    std::size_t point;  // in points_
    int other;
    double stiffness;    // [N/m]
    double rest_length;  // [m]
    double bend;         // [N/m]
  };

  /// A triangle of a mesh with a held corner.
  struct HeldCorner {
    std::size_t point;  // in points_
    std::size_t triangle;
    std::size_t corner;
  };

  /// A cell of a fabric with a held corner.
  struct HeldCell {
    std::size_t point;  // in points_
    Cell cell;
    std::size_t corner;
  };

  void list_springs(const Cloth&);
  void list_cells(const Cloth&);
  void add_pulls_at_limit(const Cloth&, Scalars& pulls) const;
  void list_corners(const Cloth&);
  Vector3 place_now(const Point&) const;
  Vector3 velocity_now(const Point&) const;
  static void release(Point&, double max_force, const Vector3& impulse);
  bool release_overloaded(const std::vector<std::size_t>& of_holder, double strength, double h);
  void count_slipping();

  std::vector<Point> points_;
  std::vector<double> strengths_;
  std::vector<Spring> springs_;
  std::vector<HeldCorner> corners_;
  std::vector<HeldCell> cells_;
  std::vector<std::vector<std::size_t>> of_holder_;  // points_ by holder
  std::size_t slipping_ = 0;
  double stick_distance_ = 0;  // [m]
  double h_ = 0;               // of the last substep with slipping points [s]
  double dt_ = 1;              // of the frame [s]
  double elapsed_ = 0;         // of the frame, with the current substep [s]
};

}  // namespace clothsim
