#include "clothsim/scene/kinematics.h"

#include <cmath>
#include <kdl/frames.hpp>
#include <kdl/tree.hpp>
#include <kdl/treefksolverpos_recursive.hpp>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

KDL::Vector to_kdl(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

KDL::Frame to_kdl(const Pose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return {KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()), to_kdl(pose.position)};
}

Pose from_kdl(const KDL::Frame& frame) {
  Pose pose;
  pose.position = {frame.p.x(), frame.p.y(), frame.p.z()};
  Eigen::Quaterniond& q = pose.orientation;
  frame.M.GetQuaternion(q.x(), q.y(), q.z(), q.w());
  q.normalize();
  return pose;
}

KDL::Joint to_kdl(const Urdf::Joint& joint) {
  if (!joint.moves()) return KDL::Joint(joint.name, KDL::Joint::Fixed);
  const auto type = joint.type == "prismatic" ? KDL::Joint::TransAxis : KDL::Joint::RotAxis;
  const KDL::Frame origin = to_kdl(joint.origin);
  return {joint.name, origin.p, origin.M * to_kdl(joint.axis), type};
}

}  // namespace

struct Kinematics::Impl {
  KDL::Tree tree{""};  // its root holds all links without a parent
  std::vector<std::string> links;
  struct Moving {
    unsigned index;      // in the tree
    std::string source;  // the joint that is set
    double multiplier;
    double offset;
  };
  std::vector<Moving> moving;

  /// Adds the links below `parent` to the tree.
  void add_children(const Urdf& urdf, const std::string& parent) {
    for (const Urdf::Joint& joint : urdf.joints) {
      if (joint.parent != parent) continue;
      tree.addSegment(KDL::Segment(joint.child, to_kdl(joint), to_kdl(joint.origin)), parent);
      links.push_back(joint.child);
      if (joint.moves()) add_moving(joint);
      add_children(urdf, joint.child);
    }
  }

  void add_moving(const Urdf::Joint& joint) {
    const unsigned index = tree.getSegment(joint.child)->second.q_nr;
    const Urdf::Mimic follows = joint.mimic.value_or(Urdf::Mimic{joint.name, 1, 0});
    moving.push_back({index, follows.joint, follows.multiplier, follows.offset});
  }
};

Kinematics::Kinematics(const Urdf& urdf) {
  const auto impl = std::make_shared<Impl>();
  for (const Urdf::Joint& joint : urdf.joints) {
    if (joint.fault.empty()) continue;
    throw InvalidValue({}, "the joint \"" + joint.name + "\": " + joint.fault,
                       "numbers of its motion");
  }
  for (const Urdf::Link& link : urdf.links) {
    bool hangs = false;
    for (const Urdf::Joint& joint : urdf.joints) hangs = hangs || joint.child == link.name;
    if (hangs) continue;
    impl->tree.addSegment(KDL::Segment(link.name, KDL::Joint("", KDL::Joint::Fixed)), "");
    impl->links.push_back(link.name);
    impl->add_children(urdf, link.name);
  }
  for (const Urdf::Joint& joint : urdf.joints) {
    if (joint.moves() && !joint.mimic) joints_.emplace(joint.name, joint.limit);
  }
  for (const Impl::Moving& each : impl->moving) {
    if (joints_.count(each.source) > 0) continue;
    throw InvalidValue({}, "a joint that mimics \"" + each.source + '"',
                       "one that can be moved and mimics none");
  }
  impl_ = impl;
}

void Kinematics::check(const JointValues& values) const {
  for (const auto& [name, value] : values) {
    const auto joint = joints_.find(name);
    if (joint == joints_.end()) {
      std::vector<std::string> known;
      for (const auto& [each, limit] : joints_) known.push_back(each);
      throw InvalidValue({name}, "a joint that cannot be set",
                         known.empty() ? "none" : "one of " + shortened(join(known), 1000));
    }
    if (!std::isfinite(value)) throw InvalidValue({name}, to_text(value), "a finite number");
    if (joint->second) check_range(name, value, *joint->second);
  }
}

std::map<std::string, Pose> Kinematics::poses(const JointValues& values) const {
  check(values);
  KDL::JntArray positions(impl_->tree.getNrOfJoints());
  for (const Impl::Moving& each : impl_->moving) {
    const auto value = values.find(each.source);
    const double at = value == values.end() ? 0 : value->second;
    positions(each.index) = each.multiplier * at + each.offset;
  }
  KDL::TreeFkSolverPos_recursive solver(impl_->tree);
  std::map<std::string, Pose> poses;
  for (const std::string& link : impl_->links) {
    KDL::Frame frame;
    solver.JntToCart(positions, frame, link);
    poses.emplace(link, from_kdl(frame));
  }
  return poses;
}

}  // namespace clothsim
