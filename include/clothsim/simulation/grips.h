#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clothsim/constraints/body_attachments.h"
#include "clothsim/constraints/holders.h"
#include "clothsim/model/cloth.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// Bounds on the force of a grip.
struct GripForces {
  std::optional<double> tear_force;  // [N]
  std::optional<double> strength;    // [N]
};

/// Points of a cloth and rigid bodies that move with a tf frame, such as a hand; or points that
/// pull on a rigid body.
struct Grip {
  struct Held {
    int point;
    Vector3 offset;  // in the tf frame [m]
  };
  struct HeldBody {
    std::size_t leader;  // its collider
    Pose offset;         // in the tf frame
  };
  std::vector<Held> held;
  std::vector<HeldBody> bodies;
  Pose pose;                         // of the tf frame, at the end of the next frame of simulation
  std::optional<double> tear_force;  // beyond which the grip lets go [N]; empty: never
  std::optional<double> strength;    // largest pull [N]; empty: default_strength()
  std::optional<std::size_t> on_body;  // leader of the body that the points pull on; empty: the
                                       // grip is that of a tf frame
  Wrench wrench;   // of the cloth on the tf frame, about its origin: mean of the last step
  double lag = 0;  // largest distance of a point from its place in the tf frame [m]
};

/// All grips of a simulation, by the name of their tf frame or body. Each point of a tf frame moves
/// in a straight line through each frame of simulation.
class Grips {
 public:
  const std::map<std::string, Grip>& all() const { return all_; }
  bool empty() const { return all_.empty(); }

  /// Attaches points to a tf frame, or to the body of that name with this leader. Throws
  /// InvalidValue with the keys {"points", "3"}, {"tear_force"}, {"strength"} and changes nothing:
  /// for no points, a point that is not of the cloth, that is given twice or that `is_held`
  /// already, and for a force out of range.
  void attach(const std::string& frame, const Pose&, std::optional<std::size_t> body,
              const std::vector<int>& points, const GripForces&,
              const std::function<bool(int)>& is_held, const Points& positions);

  /// Throws InvalidValue with the key {"points", "3"} for a point that is not attached.
  void detach(const std::vector<int>& points);

  /// Holds a body, now at `of_body`, with a tf frame, now at `pose`.
  void attach_body(std::size_t leader, const Pose& of_body, const std::string& frame,
                   const Pose& pose);
  void detach_body(std::size_t leader);

  /// The tf frame that holds a body; null: none.
  const std::string* frame_of_body(std::size_t leader) const;

  void move(const std::string& frame, const Pose& pose) { all_.at(frame).pose = pose; }

  void clear() { all_.clear(); }

  /// Calls visit(number of the grip, point, target [m]) for all points of tf frames, in an order
  /// that is constant while nothing is attached or detached.
  template <typename Visit>
  void for_each_held(Visit&& visit) const {
    int number = 0;
    for (const auto& [frame, grip] : all_) {
      if (grip.on_body) continue;
      for (const Grip::Held& held : grip.held) visit(number, held.point, place(grip, held));
      ++number;
    }
  }

  /// The points of bodies, in a constant order as well.
  std::vector<BodyAttachments::Attachment> on_bodies() const;

  /// Sets wrenches and lags of tf frames after a step of dt [s]. `first`: number in `holders` of
  /// the first point of the grips.
  void measure(const Cloth&, double dt, const Holders& holders, std::size_t first,
               const State& before, const State& after);
  /// The same of bodies, and their poses.
  void measure(double dt, const BodyAttachments&, const std::vector<MovingCollider>&,
               const Points& positions);

  /// The points of the grips whose force exceeds their tear force.
  std::vector<int> torn() const;

  /// For an archive, such as cereal's, that writes or reads its arguments.
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
