#include "clothsim/simulation/grips.h"

#include <algorithm>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene.h"

namespace clothsim {

void Grips::attach(const std::string& frame, const Pose& pose, std::optional<std::size_t> body,
                   const std::vector<int>& points, const GripForces& forces,
                   const std::function<bool(int)>& is_held, const Points& positions) {
  if (forces.tear_force) check_range("tear_force", *forces.tear_force, tear_force_range);
  if (forces.strength) check_range("strength", *forces.strength, strength_range);
  if (body && forces.strength) {
    throw InvalidValue({"strength"}, to_text(*forces.strength),
                       "none, as " + frame + " is a rigid body");
  }
  if (points.empty()) throw InvalidValue({"points"}, "none", "one or more");
  std::set<int> given;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int point = points[i];
    const auto refuse = [&](const std::string& what, const std::string& expected) {
      throw InvalidValue({"points", std::to_string(i)}, std::to_string(point) + what, expected);
    };
    if (point < 0 || point >= positions.rows()) {
      refuse("", "a number from 0 to " + std::to_string(positions.rows() - 1));
    }
    if (is_held(point)) refuse(", which is held already", "a point that is free");
    if (!given.insert(point).second) refuse(" again", "each point once");
  }

  Grip& grip = all_[frame];
  grip.pose = pose;
  grip.on_body = body;
  grip.tear_force = forces.tear_force;
  grip.strength = forces.strength;
  for (const int point : points) {
    const Vector3 position = positions.row(point).transpose();
    grip.held.push_back({point, pose.orientation.conjugate() * (position - pose.position)});
  }
}

void Grips::detach(const std::vector<int>& points) {
  std::set<int> attached;
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) attached.insert(held.point);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (attached.count(points[i]) == 0) {
      throw InvalidValue({"points", std::to_string(i)}, std::to_string(points[i]),
                         "a point that is attached");
    }
  }

  const std::set<int> free(points.begin(), points.end());
  for (auto entry = all_.begin(); entry != all_.end();) {
    std::vector<Grip::Held>& held = entry->second.held;
    held.erase(std::remove_if(held.begin(), held.end(),
                              [&](const Grip::Held& h) { return free.count(h.point) > 0; }),
               held.end());
    const bool is_idle = held.empty() && entry->second.bodies.empty();
    entry = is_idle ? all_.erase(entry) : std::next(entry);
  }
}

void Grips::attach_body(std::size_t leader, const Pose& of_body, const std::string& frame,
                        const Pose& pose) {
  Grip& grip = all_[frame];
  grip.pose = pose;
  const Eigen::Quaterniond back = pose.orientation.conjugate();
  grip.bodies.push_back({leader, {to_local(pose, of_body.position), back * of_body.orientation}});
}

void Grips::detach_body(std::size_t leader) {
  for (auto entry = all_.begin(); entry != all_.end();) {
    std::vector<Grip::HeldBody>& bodies = entry->second.bodies;
    bodies.erase(std::remove_if(bodies.begin(), bodies.end(),
                                [&](const Grip::HeldBody& b) { return b.leader == leader; }),
                 bodies.end());
    const bool is_idle = entry->second.held.empty() && bodies.empty();
    entry = is_idle ? all_.erase(entry) : std::next(entry);
  }
}

const std::string* Grips::frame_of_body(std::size_t leader) const {
  for (const auto& [frame, grip] : all_) {
    for (const Grip::HeldBody& body : grip.bodies) {
      if (body.leader == leader) return &frame;
    }
  }
  return nullptr;
}

/// The force of a point is the mean load on its holder. A point that sticks also passes on the
/// force of its own acceleration: F = sum of p / dt - m dv / dt.
void Grips::measure(const Cloth& cloth, double dt, const Holders& holders, std::size_t first,
                    const State& before, const State& after) {
  for (auto& [frame, grip] : all_) {
    if (grip.on_body) continue;
    grip.wrench = {};
    grip.lag = 0;
    for (const Grip::Held& held : grip.held) {
      const int i = held.point;
      Vector3 force = holders.frame_impulse(first) / dt;
      if (holders.sticks(first)) {
        force -= cloth.mass[i] / dt * (row(after.velocities, i) - row(before.velocities, i));
      }
      grip.wrench.add(row(after.positions, i) - grip.pose.position, force);
      grip.lag = std::max(grip.lag, holders.lag(first, after.positions));
      ++first;
    }
  }
}

std::vector<BodyAttachments::Attachment> Grips::on_bodies() const {
  std::vector<BodyAttachments::Attachment> attachments;
  for (const auto& [frame, grip] : all_) {
    for (const Grip::Held& held : grip.held) {
      if (grip.on_body) attachments.push_back({held.point, *grip.on_body, held.offset});
    }
  }
  return attachments;
}

void Grips::measure(double dt, const BodyAttachments& attachments,
                    const std::vector<MovingCollider>& colliders, const Points& positions) {
  std::size_t number = 0;
  for (auto& [frame, grip] : all_) {
    if (!grip.on_body) continue;
    grip.pose = colliders[*grip.on_body].pose();
    grip.wrench = {};
    grip.lag = 0;
    for (const Grip::Held& held : grip.held) {
      grip.wrench.add(row(positions, held.point) - grip.pose.position,
                      attachments.frame_impulse(number) / dt);
      grip.lag = std::max(grip.lag, attachments.distance(number, colliders, positions));
      ++number;
    }
  }
}

std::vector<int> Grips::torn() const {
  std::vector<int> points;
  for (const auto& [frame, grip] : all_) {
    if (!grip.tear_force || grip.wrench.force.norm() <= *grip.tear_force) continue;
    for (const Grip::Held& held : grip.held) points.push_back(held.point);
  }
  return points;
}

}  // namespace clothsim
