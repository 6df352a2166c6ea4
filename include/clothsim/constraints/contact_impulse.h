#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "clothsim/model/memory.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Impulse that a surface gives to what touches it [N s]; of single points over their mass [m/s].
struct ContactImpulse {
  Vector3 normal{0, 0, 1};            // into free space
  Vector3 surface_velocity{0, 0, 0};  // [m/s]
  double slowest = 0;                 // least normal velocity off the surface allowed [m/s]
  double friction = 0;
  double most = std::numeric_limits<double>::infinity();          // of push
  double most_to_part = std::numeric_limits<double>::infinity();  // of push that parts, not stops
  double push = 0;                                                // along the normal, >= 0
  Vector3 drag{0, 0, 0};  // against sliding, at most friction * push

  /// Brings it up to date where the cloth touches with `velocity` [m/s], and moves like a
  /// `mass`: an impulse changes that velocity by itself over it. Returns the change.
  Vector3 update(const Vector3& velocity, double mass) {
    const Vector3 v = velocity - surface_velocity;

    // Off the surface, or towards it no faster than the gap allows.
    const double rate = normal.dot(v);
    double new_push = push + mass * (slowest - rate);
    if (slowest > 0) new_push = std::min(new_push, std::max(push - mass * rate, most_to_part));
    new_push = std::clamp(new_push, 0.0, most);

    // Against sliding, as far as Coulomb's cone reaches.
    Vector3 new_drag = drag - mass * (v - rate * normal);
    const double strongest = friction * new_push;
    const double length2 = new_drag.squaredNorm();
    if (length2 > strongest * strongest) new_drag *= strongest / std::sqrt(length2);

    const Vector3 change = (new_push - push) * normal + new_drag - drag;
    push = new_push;
    drag = new_drag;
    return change;
  }

  /// Makes it `scale` times as large, in the directions of now.
  void resume(double scale) {
    push *= scale;
    drag *= scale;
    drag -= normal.dot(drag) * normal;
  }

  /// Has resume() go on with that of the last step.
  void keep(const ContactImpulse& last) {
    push = last.push;
    drag = last.drag;
  }

  Vector3 total() const { return push * normal + drag; }

  /// Lets it push with that much at most, now too.
  void weaken(double strongest) {
    most = std::min(most, strongest);
    if (push > most) resume(most / push);
  }

  /// Lets it push no more.
  void let_go() {
    slowest = -std::numeric_limits<double>::infinity();
    push = friction = 0;
    drag.setZero();
  }

  /// What the next step resumes: the impulse, not the surface.
  void write(MemoryWriter& memory) const {
    memory.add(push);
    memory.add(drag);
  }
  void read(MemoryReader& memory) {
    push = std::max(0.0, memory.number());
    drag = memory.vector();
  }
};

}  // namespace clothsim
