#pragma once

#include <cstddef>
#include <vector>

#include "clothsim/constraints/body_collisions.h"
#include "clothsim/constraints/contact_step.h"
#include "clothsim/constraints/rigid_bodies.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"

namespace clothsim {

/// Points of the cloth that are attached to rigid bodies: the point's velocity is that of its place
/// on the body. The rows of all points on a body are solved at once, whatever their masses, for the
/// motion of the body that keeps the momentum of all of them. The point then is put at
/// its place, from which the displacements of a step lead by rounding or, with methods of first
/// order, by the square of the step; a correction by velocities would feed energy to light cloth.
class BodyAttachments {
 public:
  struct Attachment {
    int point;         // index in the cloth
    std::size_t body;  // collider that leads it
    Vector3 place;     // in the leader's frame [m]
  };

  /// Attaches these alone. Impulses of points that stay on their body are kept.
  void attach(const std::vector<Attachment>&);

  bool empty() const { return rows_.empty(); }
  bool holds(int point) const;

  /// Begins a frame: clears the sums below.
  void begin_frame();

  /// The places of attached points within `reach` [m] of other colliders: there the cloth touches
  /// them with the mass of its body. `start`: positions of the points before the step.
  std::vector<BodyTouch> touches(const Cloth&, const std::vector<MovingCollider>&,
                                 const Points& start, double reach) const;

  /// To be called with the bodies after their free motion and the points after their forces.
  /// Applies the impulses of the last step.
  void prepare(const Cloth&, const ContactStep&, const std::vector<MovingCollider>&, State&);
  /// One pass. Returns the largest change of a relative velocity [m/s].
  double solve_pass(RigidBodies&, Points& velocities);
  /// Puts the points at their places.
  void project(const std::vector<MovingCollider>&, Points& positions) const;
  /// Whether corrections of positions leave the points where they are: their inverse masses are 0,
  /// else as in a step.
  void fix(bool fixed, Cloth&) const;
  /// Adds the impulses of a step of h [s] to the sums.
  void end_step(const Cloth&, double h, const Points& velocities);

  /// Impulse of the cloth on the body through the attachment `number` in the frame [N s].
  const Vector3& frame_impulse(std::size_t number) const { return rows_[number].frame_impulse; }
  /// Distance of its point from its place [m].
  double distance(std::size_t number, const std::vector<MovingCollider>&,
                  const Points& positions) const;
  /// Bound on the work [J] of the bodies on the cloth in the frame.
  double work() const;

  void reset();
  void write(MemoryWriter&) const;
  void read(MemoryReader&);

 private:
  /// The rows of a body.
  struct Block {
    std::size_t first;  // in rows_
    std::size_t end;
    Eigen::Matrix<double, 6, 6> gain;  // change of the body's motion by the points' momentum, both
                                       // linear and angular, that it lacks
  };
  struct Row {
    Attachment attachment;
    Vector3 impulse{0, 0, 0};        // on the point in the last step [N s]
    Vector3 x{0, 0, 0};              // its place on the body [m]
    double inv_mass = 0;             // of the point [1/kg]
    Vector3 frame_impulse{0, 0, 0};  // sum, of the cloth on the body [N s]
    double work = 0;                 // in the frame, at most [J]
  };

  void set_gain(Block&, const RigidMotion&) const;

  std::vector<Row> rows_;      // those of a body one after another
  std::vector<Block> blocks_;  // by body
  double h_ = 0;               // of the last step [s]
};

}  // namespace clothsim
