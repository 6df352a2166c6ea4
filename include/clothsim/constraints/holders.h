#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "clothsim/constraints/contact_step.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/shapes/moving_collider.h"

namespace clothsim {

/// A point that a holder, a pin or a grip, brings to its target.
struct Hold {
  int point;
  int holder;  // number of the holder, which points may share
};

/// What holds the points of a cloth, each holder with a strength.
///
/// A point sticks as long as the cloth pulls with less than its holder can give: it is kinematic,
/// of infinite mass. Beyond that it slips: it has its mass again, and the holder pulls it towards
/// its target with all of its share of the strength. Once the cloth pulls with less, the holder
/// brings the point back, and it sticks again where it has arrived. In between, a band of the
/// strength rubs as Coulomb friction does, so that a slip comes to rest. All of it is one monotone
/// law of force and velocity:
///
///   F = S                 while the point leaves,
///   F from (1 - f) S to S while it stays behind its target, at rest relative to the holder,
///   F up to (1 - f) S     while it comes back, at a speed of (distance / return_time) at most.
///
/// A held point that is moved against a collider slips, too: the collider is the stronger of both.
class Holders {
 public:
  /// Holds these points, of holders with `strengths` [N]. Points that were held before go on as
  /// they are; others stick where they are. A holder that names no strength bears ten times the
  /// weight of the cloth, as a robot that lifts, shakes and swings it does, and what stretches all
  /// springs of its points to their strain limit, or by a tenth where there is none: a cloth that
  /// is light and stiff is pulled with more than its weight.
  void hold(const std::vector<Hold>&, const std::vector<std::optional<double>>& strengths,
            const Cloth&, double gravity, const Points& positions);

  bool empty() const { return points_.empty(); }
  bool holds(int point) const;

  /// Takes the mass of the points that stick from the cloth, and gives others theirs.
  void apply(Cloth&) const;

  /// Sets out for `targets` [m], as hold() has the points, to be reached in dt [s].
  void begin_frame(const std::vector<Vector3>& targets, double dt, State&);
  /// Puts points that stick at their targets, to the last bit.
  void end_frame(State&) const;
  /// Puts a point at once where it is to be [m], and has it stick there.
  void place(std::size_t hold, const Vector3& target, State&);

  /// To be called as a substep of h [s] begins, with colliders as they will be at its end. Has
  /// points slip that are pressed against these. Whether what sticks has changed.
  bool begin_substep(double h, const Cloth&, const std::vector<MovingCollider>&,
                     const Points& positions);

  /// Finds what pulls on slipping points, and gives them their last impulses.
  void warm_start(const Cloth&, const ContactStep&, State&);
  /// One pass over slipping points. Returns the largest change of a velocity [m/s].
  double solve_pass(Points& velocities);

  /// After a substep of h [s]: what the cloth has given each point that sticks, `impulses` [N s],
  /// N x 3. `scale`: by which the impulses of solve_pass() are larger as forces through the
  /// substep. Lets points slip, and stick again. Whether what sticks has changed.
  bool judge(const Cloth&, double h, double scale, const Vector3& gravity, const Points& impulses,
             State&);

  /// Adds impulses [N s] of springs and bends of h [s] to points that stick.
  void add_spring_impulses(const Cloth&, double h, const State&, Points& impulses) const;
  /// Zeroes the rows of points that stick.
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
  /// Impulse [N s] that the cloth put on the holder through this point in the frame, without that
  /// of the point's own acceleration.
  const Vector3& frame_impulse(std::size_t hold) const { return points_[hold].frame_impulse; }
  /// Of the holder, the forces [N] on all its points in a step of dt [s], by amount.
  double force(int holder, double dt) const;
  /// How far the point is from its target [m], after end_frame().
  double lag(std::size_t hold, const Points& positions) const {
    return points_[hold].slips ? (points_[hold].target - row(positions, point(hold))).norm() : 0;
  }
  /// Work [J] that holders have done in the frame, at most, on the points that slip now.
  double work() const;

  /// As so many numbers. `read` throws InvalidValue for what was not written.
  std::size_t memory_size() const;
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  struct Point {
    Hold hold;
    Vector3 start;   // where it was to be as the frame began [m]
    Vector3 target;  // and is to be as it ends [m]
    bool slips = false;
    bool is_pressed = false;   // against a collider
    double max_force = 0;      // that it may be pulled with [N]
    double begun = 0;          // when it was at `start`, in the frame [s]
    Vector3 impulse{0, 0, 0};  // on the point in the last substep [N s]
    Vector3 want{0, 0, 0};     // velocity towards the target [m/s]
    Vector3 carried{0, 0, 0};  // velocity of the holder [m/s]
    Vector3 given{0, 0, 0};    // impulse of the cloth on the holder in the substep [N s]
    Vector3 frame_impulse{0, 0, 0};
    double work = 0;  // in the frame, at most [J]
    double mass = 0;  // [kg]
  };

  /// A spring of a held point: k (l - L) u and w d, with their damping.
  struct Spring {
    std::size_t point;  // in points_
    int other;
    double stiffness;    // [N/m]
    double rest_length;  // [m]
    double bend;         // [N/m]
  };

  void list_springs(const Cloth&);
  Vector3 place_now(const Point&) const;
  Vector3 velocity_now(const Point&) const;
  static void release(Point&, double max_force, const Vector3& impulse);
  bool give_way(const std::vector<std::size_t>& of_holder, double strength, double h);
  void count_slipping();

  std::vector<Point> points_;
  std::vector<double> strengths_;
  std::vector<Spring> springs_;
  std::vector<std::vector<std::size_t>> of_holder_;  // points_ by holder
  std::size_t slipping_ = 0;
  double stick_distance_ = 0;  // [m]
  double h_ = 0;               // of the last substep with slipping points [s]
  double time_ = 0;            // in which a force gives such impulses, less with drag [s]
  double dt_ = 1;              // of the frame [s]
  double elapsed_ = 0;         // of it, with the substep at hand [s]
};

}  // namespace clothsim
