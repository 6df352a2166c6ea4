#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// Puts a point that a frame brought from where it was `before` to `target` [m] there to the last
/// bit. One that was held back on its way stays where it is.
void arrive_at(const Vector3& target, int point, const State& before, State&);

/// Points of a cloth that a frame carries about, as a hand does.
struct Grip {
  struct Held {
    int point;
    Vector3 offset;  // in the frame [m]
  };
  std::vector<Held> held;
  Pose pose;                         // of the frame, at the end of the next frame of simulation
  std::optional<double> tear_force;  // [N] beyond which it lets go; empty: never
  Wrench wrench;  // that the cloth put on the frame, about its origin: mean of the last step
};

/// The points within `radius` [m] of `position` that nothing holds, ascending. Throws InvalidValue
/// with the key {"radius"} where there is none, and for a radius that is no number from 0 to 1e6.
std::vector<int> free_points_near(const Cloth&, const Points& positions, const Vector3& position,
                                  double radius);

/// All grips of a simulation, by the name of their frame. Held points are of infinite mass and move
/// in a straight line through each frame of simulation.
class Grips {
 public:
  const std::map<std::string, Grip>& all() const { return all_; }
  bool empty() const { return all_.empty(); }

  /// Throws InvalidValue with the keys {"points", "3"}, {"tear_force"} and changes nothing: for a
  /// point that is none of the cloth's, or is held already.
  void attach(const std::string& frame, const Pose&, const std::vector<int>& points,
              std::optional<double> tear_force, const Cloth&, const Points& positions);

  /// Throws InvalidValue with the key {"points", "3"} for a point that is not attached.
  void detach(const std::vector<int>& points);

  void move(const std::string& frame, const Pose& pose) { all_.at(frame).pose = pose; }

  void clear() { all_.clear(); }

  /// Takes the mass of held points from the cloth.
  void hold(Cloth&) const;

  /// Gives held points the velocities that bring them where they must be in dt [s].
  void set_out(double dt, State&) const;

  /// Puts held points there, to the last bit, but for those held back on their way.
  void arrive(const State& before, State&) const;

  /// Sets wrenches after a step of dt [s] in which the cloth gave its points `impulses` [N s], N
  /// x 3.
  void weigh(const Cloth&, const Vector3& gravity, double dt, const Points& impulses,
             const State& before, const State& after);

  /// Adds what springs and bends give the held points in h [s] in `state`.
  void add_spring_impulses(const Cloth&, double h, const State&, Points& impulses) const;

  /// The points of grips that pull harder than they hold.
  std::vector<int> torn() const;

  /// For an archive that writes or reads its arguments.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(all_);
  }

 private:
  Vector3 place(const Grip& grip, const Grip::Held& held) const {
    return grip.pose.position + grip.pose.orientation * held.offset;
  }

  std::map<std::string, Grip> all_;
};

}  // namespace clothsim
