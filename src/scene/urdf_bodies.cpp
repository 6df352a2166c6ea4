#include "clothsim/scene/urdf_bodies.h"

#include <algorithm>
#include <map>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Mass, centre and moments of inertia of links that move together, in the world.
struct Inertial {
  double mass = 0;                    // [kg]
  Vector3 center{0, 0, 0};            // [m]
  Matrix3 inertia = Matrix3::Zero();  // about the centre [kg m^2]
};

/// Moments of inertia of a point mass at `arm` [m] from the origin [kg m^2].
Matrix3 moments_of(double mass, const Vector3& arm) {
  return mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
}

void add(const Inertial& part, Inertial& sum) {
  const double mass = sum.mass + part.mass;
  const Vector3 center = (sum.mass * sum.center + part.mass * part.center) / mass;
  sum.inertia += part.inertia + moments_of(sum.mass, sum.center - center) +
                 moments_of(part.mass, part.center - center);
  sum.mass = mass;
  sum.center = center;
}

/// Which links of a URDF move together.
class Groups {
 public:
  explicit Groups(const Urdf& urdf) : urdf_(urdf) {
    for (const Urdf::Joint& joint : urdf.joints) {
      by_child_[joint.child] = &joint;
      has_movable_ = has_movable_ || joint.moves() || joint.type == "floating";
    }
    for (const Urdf::Link& link : urdf.links) links_[link.name] = &link;
  }

  /// The first link of those that move with a link; null for one that stays. Throws InvalidValue.
  const Urdf::Link* leader_of(const Urdf::Link& link) const {
    const Urdf::Joint* joint = joint_of(link);
    if (!joint) {
      return has_movable_ || link.name == "world" || !link.inertial ? nullptr : &link;
    }
    const Urdf::Link* parent = leader_of(*links_.at(joint->parent));
    if (joint->type == "fixed") return parent;
    if (!joint->fault.empty() || !(joint->moves() || joint->type == "floating")) {
      throw InvalidValue({"bodies"}, "joint " + joint->name + " of type " + joint->type,
                         "a fixed, floating, prismatic, revolute or continuous joint");
    }
    if (parent) {
      throw InvalidValue({"bodies"},
                         "joint " + joint->name + ", whose parent " + joint->parent + " moves",
                         "movable joints on links that stay");
    }
    return &link;
  }

  /// The joint that leads to a link; null for the root.
  const Urdf::Joint* joint_of(const Urdf::Link& link) const {
    const auto joint = by_child_.find(link.name);
    return joint == by_child_.end() ? nullptr : joint->second;
  }

  const Urdf::Link& link(const std::string& name) const { return *links_.at(name); }

  /// The sum over all links that move with a leader.
  Inertial inertial_of(const Urdf::Link& leader, const Pose& root) const {
    Inertial sum;
    for (const Urdf::Link& link : urdf_.links) {
      if (!link.inertial || leader_of(link) != &leader) continue;
      const Pose pose = root * link.pose * link.inertial->origin;
      const Matrix3 turn = pose.orientation.toRotationMatrix();
      add({link.inertial->mass, pose.position, turn * link.inertial->inertia * turn.transpose()},
          sum);
    }
    if (sum.mass > 0) return sum;
    throw InvalidValue({"bodies"}, "link " + leader.name + " without <inertial>",
                       "a mass for each link that moves");
  }

 private:
  const Urdf& urdf_;
  std::map<std::string, const Urdf::Joint*> by_child_;
  std::map<std::string, const Urdf::Link*> links_;
  bool has_movable_ = false;
};

Joint joint_in_world(const Urdf::Joint& joint, const Pose& parent) {
  const Pose pose = parent * joint.origin;
  Joint result;
  result.kind = joint.type == "prismatic" ? Joint::Kind::slider : Joint::Kind::hinge;
  result.axis = (pose.orientation * joint.axis).normalized();
  result.point = pose.position;
  if (!joint.limit) return result;
  if (!(joint.limit->min <= 0 && joint.limit->max >= 0)) {
    throw InvalidValue({"bodies"}, "the limits of joint " + joint.name,
                       "a range with 0, where it starts");
  }
  result.lower = joint.limit->min;
  result.upper = joint.limit->max;
  return result;
}

}  // namespace

void make_bodies(const Urdf& urdf, const Pose& root, const std::vector<LinkCollider>& colliders) {
  const Groups groups(urdf);
  for (const Urdf::Link& link : urdf.links) {
    const bool is_lone_root = !groups.joint_of(link) && urdf.joints.empty();
    if (link.inertial_fault.empty() || !(is_lone_root || groups.leader_of(link))) continue;
    throw InvalidValue({"bodies"}, "link " + link.name + ": " + link.inertial_fault,
                       "an <inertial> without a fault");
  }
  std::map<const Urdf::Link*, std::string> names;  // of leading colliders, by leading link
  for (const auto& [link, collider] : colliders) {
    collider->frame.clear();
    const Urdf::Link* leader = groups.leader_of(*link);
    if (!leader) continue;
    const auto [name, is_first] = names.emplace(leader, collider->name);
    if (!is_first) {
      collider->part_of = name->second;
      continue;
    }
    const Inertial inertial = groups.inertial_of(*leader, root);
    const Pose frame = collider->pose * collider->offset;
    const Matrix3 turn = frame.orientation.toRotationMatrix();
    BodySpec& body = collider->body.emplace();
    body.mass = inertial.mass;
    body.center_of_mass = to_local(frame, inertial.center);
    body.inertia = turn.transpose() * inertial.inertia * turn;
    const Urdf::Joint* joint = groups.joint_of(*leader);
    if (joint && joint->moves()) {
      body.joint = joint_in_world(*joint, root * groups.link(joint->parent).pose);
    }
  }
}

}  // namespace clothsim
