// The reader of SDF, a library of its own that links to nothing of clothsim_core: libsdformat takes
// 60 ms to load, which a scene without SDF does not pay.

#include <cmath>
#include <sdf/sdf.hh>
#include <set>
#include <sstream>
#include <stdexcept>

#include "clothsim/scene/sdf.h"

namespace clothsim {
namespace {

/// Why a part cannot be used.
using Fault = std::runtime_error;

/// SDF writes ranges without an end with numbers from here on.
constexpr double unlimited = 1e12;

Vector3 vector(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }

Pose pose_of(const ignition::math::Pose3d& pose) {
  const auto& q = pose.Rot();
  return {vector(pose.Pos()), Eigen::Quaterniond(q.W(), q.X(), q.Y(), q.Z()).normalized()};
}

void refuse_first(const sdf::Errors& errors) {
  if (errors.empty()) return;
  throw SdfRefusal{errors[0].Message(), "an SDF without errors"};
}

Pose pose_in(const sdf::SemanticPose& pose, const std::string& frame) {
  ignition::math::Pose3d found;
  refuse_first(pose.Resolve(found, frame));
  return pose_of(found);
}

double size(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return value;
  std::ostringstream fault;
  fault << name << " is " << value << ", not above 0";
  throw Fault(fault.str());
}

/// Meshes of the model lie beside its file: a model's folder has its name.
std::string file_of(const std::string& uri) {
  const std::string scheme = "model://";
  return uri.compare(0, scheme.size(), scheme) == 0 ? "../" + uri.substr(scheme.size()) : uri;
}

void read_geometry(const sdf::Geometry& geometry, Urdf::Collision& collision) {
  if (const sdf::Box* box = geometry.BoxShape()) {
    const Vector3 sides = vector(box->Size());
    size("the least side of <box>", sides.minCoeff());
    collision.geometry = Cuboid{sides};
  } else if (const sdf::Sphere* sphere = geometry.SphereShape()) {
    collision.geometry = Sphere{size("radius of <sphere>", sphere->Radius())};
  } else if (const sdf::Cylinder* cylinder = geometry.CylinderShape()) {
    collision.geometry = Cylinder{size("length of <cylinder>", cylinder->Length()),
                                  size("radius of <cylinder>", cylinder->Radius())};
  } else if (const sdf::Capsule* capsule = geometry.CapsuleShape()) {
    collision.geometry = Capsule{size("length of <capsule>", capsule->Length()),
                                 size("radius of <capsule>", capsule->Radius())};
  } else if (const sdf::Mesh* mesh = geometry.MeshShape()) {
    if (!mesh->Submesh().empty()) throw Fault("it is a part of a mesh, not a whole one");
    collision.geometry = Urdf::Mesh{file_of(mesh->Uri()), vector(mesh->Scale())};
  } else {
    throw Fault("it is no box, sphere, cylinder, capsule or mesh");
  }
}

std::optional<Urdf::Inertial> inertial_of(const sdf::Link& link) {
  // The defaults, 1 kg and 1 kg m^2, are nobody's.
  if (!link.Element()->HasElement("inertial")) return {};
  const sdf::ElementPtr element = link.Element()->GetElement("inertial");
  if (!element->HasElement("mass") || !element->HasElement("inertia")) return {};
  const auto& given = link.Inertial();
  Urdf::Inertial inertial;
  inertial.origin = pose_of(given.Pose());
  inertial.mass = given.MassMatrix().Mass();
  const auto moments = given.MassMatrix().Moi();
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned j = 0; j < 3; ++j) inertial.inertia(i, j) = moments(i, j);
  }
  return inertial;
}

Urdf::Link link_of(const sdf::Link& given, bool is_static) {
  Urdf::Link link;
  link.name = given.Name();
  if (!is_static) link.inertial = inertial_of(given);
  for (std::uint64_t i = 0; i < given.CollisionCount(); ++i) {
    const sdf::Collision& each = *given.CollisionByIndex(i);
    Urdf::Collision collision;
    collision.origin = pose_in(each.SemanticPose(), link.name);
    try {
      read_geometry(*each.Geom(), collision);
    } catch (const Fault& fault) {
      collision.fault = fault.what();
    }
    link.collisions.push_back(collision);
  }
  return link;
}

std::string type_of(sdf::JointType type) {
  switch (type) {
    case sdf::JointType::FIXED:
      return "fixed";
    case sdf::JointType::PRISMATIC:
      return "prismatic";
    case sdf::JointType::REVOLUTE:
      return "revolute";
    case sdf::JointType::CONTINUOUS:
      return "continuous";
    case sdf::JointType::BALL:
      return "ball";
    case sdf::JointType::UNIVERSAL:
      return "universal";
    case sdf::JointType::SCREW:
      return "screw";
    case sdf::JointType::GEARBOX:
      return "gearbox";
    default:
      return "of two axes";
  }
}

void read_axis(const sdf::Joint& given, Urdf::Joint& joint) {
  if (!given.Axis()) throw SdfRefusal{"joint " + joint.name + " without <axis>", "an axis"};
  ignition::math::Vector3d axis;
  refuse_first(given.Axis()->ResolveXyz(axis, given.Name()));
  joint.axis = vector(axis).normalized();
  const double lower = given.Axis()->Lower(), upper = given.Axis()->Upper();
  if (lower <= -unlimited && upper >= unlimited) {
    if (joint.type == "revolute") joint.type = "continuous";
  } else if (joint.type != "continuous") {
    joint.limit = {lower, upper, joint.type == "prismatic" ? "m" : "rad"};
  }
}

/// Adds a joint, and a link of its name where its frame is not that of its child.
void add_joint(const sdf::Joint& given, const sdf::Model& model, Urdf& urdf) {
  Urdf::Joint joint;
  joint.name = given.Name();
  joint.type = type_of(given.Type());
  refuse_first(given.ResolveParentLink(joint.parent));
  std::string child;
  refuse_first(given.ResolveChildLink(child));
  if (child == "world") throw SdfRefusal{"the world as a child of " + joint.name, "a link"};
  const bool is_in_world = joint.parent == "world";
  joint.origin = pose_in(given.SemanticPose(), is_in_world ? "__model__" : joint.parent);
  if (joint.moves()) read_axis(given, joint);
  const Pose to_child = pose_in(model.LinkByName(child)->SemanticPose(), joint.name);
  joint.child = child;
  if (to_child.position != Vector3::Zero() || to_child.orientation.vec() != Vector3::Zero()) {
    Urdf::Link frame;
    frame.name = joint.name;
    joint.child = frame.name;
    urdf.links.push_back(frame);
    Urdf::Joint rest;
    rest.name = joint.name + " to " + child;
    rest.type = "fixed";
    rest.parent = frame.name;
    rest.child = child;
    rest.origin = to_child;
    urdf.joints.push_back(rest);
  }
  urdf.joints.push_back(joint);
}

/// Joins the links that no joint leads to with the world.
void join_roots(const sdf::Model& model, Urdf& urdf) {
  std::set<std::string> children{"world"};
  for (const Urdf::Joint& joint : urdf.joints) children.insert(joint.child);
  for (const Urdf::Link& link : urdf.links) {
    if (children.count(link.name) > 0) continue;
    Urdf::Joint joint;
    joint.name = "world to " + link.name;
    joint.type = model.Static() ? "fixed" : "floating";
    joint.parent = "world";
    joint.child = link.name;
    joint.origin = pose_in(model.LinkByName(link.name)->SemanticPose(), "__model__");
    urdf.joints.push_back(joint);
  }
}

Urdf urdf_of(const std::string& text) {
  sdf::Console::Instance()->SetQuiet(true);  // errors are thrown
  sdf::Root root;
  refuse_first(root.LoadSdfString(text));
  const sdf::Model* model = root.Model();
  if (!model || root.WorldCount() > 0) throw SdfRefusal{"an SDF without <model>", "a model"};
  if (!model->PlacementFrameName().empty() || !model->PoseRelativeTo().empty()) {
    throw SdfRefusal{"a model placed by another frame", "a <pose> of the model itself"};
  }
  if (model->ModelCount() > 0) {
    throw SdfRefusal{"a model inside the model " + model->Name(), "links and joints alone"};
  }
  Urdf urdf;
  urdf.name = model->Name();
  urdf.links.emplace_back().name = "world";
  for (std::uint64_t i = 0; i < model->LinkCount(); ++i) {
    urdf.links.push_back(link_of(*model->LinkByIndex(i), model->Static()));
  }
  for (std::uint64_t i = 0; i < model->JointCount() && !model->Static(); ++i) {
    add_joint(*model->JointByIndex(i), *model, urdf);
  }
  join_roots(*model, urdf);
  const Pose placed = pose_of(model->RawPose());
  for (Urdf::Joint& joint : urdf.joints) {
    if (joint.parent == "world") joint.origin = placed * joint.origin;
  }
  return urdf;
}

}  // namespace
}  // namespace clothsim

bool clothsim_read_sdf(const std::string& text, clothsim::Urdf& urdf,
                       clothsim::SdfRefusal& refusal) {
  try {
    urdf = clothsim::urdf_of(text);
    return true;
  } catch (const clothsim::SdfRefusal& error) {
    refusal = error;
  } catch (...) {  // assertions of libsdformat, which are no std::exception
    refusal = {"a text at which libsdformat fails", "an SDF"};
  }
  return false;
}
