#include "clothsim/scene/urdf.h"

#include <tinyxml2.h>

#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene.h"
#include "clothsim/scene/sdf.h"

namespace clothsim {
namespace {

using tinyxml2::XMLElement;

/// An error in one collision or joint.
using Fault = std::runtime_error;

std::string quoted(const char* text) {
  return text ? '"' + shortened(text, longest_shown) + '"' : "nothing";
}

/// `count` finite numbers with blanks between them, from an attribute.
std::vector<double> numbers(const XMLElement& element, const char* attribute, std::size_t count) {
  const char* text = element.Attribute(attribute);
  std::istringstream stream(text ? text : "");
  stream.imbue(std::locale::classic());
  std::vector<double> found;
  for (double number = 0; stream >> number;) found.push_back(number);
  bool good = stream.eof() && found.size() == count;
  for (const double number : found) good = good && std::isfinite(number);
  if (good) return found;
  throw Fault(std::string(attribute) + " of <" + element.Name() + "> is " + quoted(text) +
              ", not " + std::to_string(count) +
              (count == 1 ? " finite number" : " finite numbers"));
}

Vector3 vector(const XMLElement& element, const char* attribute) {
  const std::vector<double> found = numbers(element, attribute, 3);
  return {found[0], found[1], found[2]};
}

double size(const XMLElement& element, const char* attribute) {
  const double value = numbers(element, attribute, 1)[0];
  if (value > 0) return value;
  throw Fault(std::string(attribute) + " of <" + element.Name() + "> is " + to_text(value) +
              ", not above 0");
}

/// The pose in <origin>, if there is one: roll, pitch and yaw about fixed axes.
Pose origin_of(const XMLElement& element) {
  Pose pose;
  const XMLElement* origin = element.FirstChildElement("origin");
  if (!origin) return pose;
  if (origin->Attribute("xyz")) pose.position = vector(*origin, "xyz");
  if (origin->Attribute("rpy")) {
    const Vector3 angles = vector(*origin, "rpy");
    pose.orientation = Eigen::AngleAxisd(angles.z(), Vector3::UnitZ()) *
                       Eigen::AngleAxisd(angles.y(), Vector3::UnitY()) *
                       Eigen::AngleAxisd(angles.x(), Vector3::UnitX());
  }
  return pose;
}

void read_geometry(const XMLElement& element, Urdf::Collision& collision) {
  const XMLElement* geometry = element.FirstChildElement("geometry");
  const XMLElement* kind = geometry ? geometry->FirstChildElement() : nullptr;
  if (!kind) throw Fault("it has no geometry");
  const std::string name = kind->Name();
  if (name == "box") {
    const Vector3 sides = vector(*kind, "size");
    if (!(sides.minCoeff() > 0)) throw Fault("size of <box> is not above 0");
    collision.geometry = Cuboid{sides};
  } else if (name == "sphere") {
    collision.geometry = Sphere{size(*kind, "radius")};
  } else if (name == "cylinder") {
    collision.geometry = Cylinder{size(*kind, "length"), size(*kind, "radius")};
  } else if (name == "capsule") {
    collision.geometry = Capsule{size(*kind, "length"), size(*kind, "radius")};
  } else if (name == "mesh") {
    Urdf::Mesh mesh;
    const char* file = kind->Attribute("filename");
    if (!file || !*file) throw Fault("<mesh> has no filename");
    mesh.file = file;
    if (kind->Attribute("scale")) mesh.scale = vector(*kind, "scale");
    collision.geometry = mesh;
  } else {
    throw Fault("<" + shortened(name, longest_shown) +
                "> is no box, sphere, cylinder, capsule or mesh");
  }
}

/// The <inertial> of a link, if it has a mass.
std::optional<Urdf::Inertial> read_inertial(const XMLElement& element) {
  const XMLElement* given = element.FirstChildElement("inertial");
  const XMLElement* mass = given ? given->FirstChildElement("mass") : nullptr;
  const XMLElement* inertia = given ? given->FirstChildElement("inertia") : nullptr;
  if (!mass || !inertia) return {};
  Urdf::Inertial inertial;
  inertial.origin = origin_of(*given);
  inertial.mass = size(*mass, "value");
  const auto moment = [&](const char* name) { return numbers(*inertia, name, 1)[0]; };
  const double xy = moment("ixy"), xz = moment("ixz"), yz = moment("iyz");
  inertial.inertia << moment("ixx"), xy, xz, xy, moment("iyy"), yz, xz, yz, moment("izz");
  return inertial;
}

Urdf::Link read_link(const XMLElement& element) {
  Urdf::Link link;
  const char* name = element.Attribute("name");
  if (!name || !*name) throw InvalidValue({}, "a link without a name", "a name for each link");
  link.name = name;
  try {
    link.inertial = read_inertial(element);
  } catch (const Fault& fault) {
    link.inertial_fault = fault.what();
  }
  for (const XMLElement* each = element.FirstChildElement("collision"); each;
       each = each->NextSiblingElement("collision")) {
    Urdf::Collision collision;
    try {
      collision.origin = origin_of(*each);
      read_geometry(*each, collision);
    } catch (const Fault& fault) {
      collision.fault = fault.what();
    }
    link.collisions.push_back(collision);
  }
  return link;
}

/// A number in an element below a joint; `otherwise` where it is missing.
double number_or(const XMLElement& element, const char* attribute, double otherwise) {
  return element.Attribute(attribute) ? numbers(element, attribute, 1)[0] : otherwise;
}

/// Axis, limit and mimic of a joint, as far as present. Throws Fault.
void read_motion(const XMLElement& element, Urdf::Joint& joint) {
  if (const XMLElement* axis = element.FirstChildElement("axis")) {
    if (axis->Attribute("xyz")) joint.axis = vector(*axis, "xyz");
    if (joint.axis.norm() == 0) throw Fault("xyz of <axis> is 0");
    joint.axis.normalize();
  }
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit && joint.type != "continuous") {
    const char* unit = joint.type == "prismatic" ? "m" : "rad";
    joint.limit = {number_or(*limit, "lower", 0), number_or(*limit, "upper", 0), unit};
  }
  if (const XMLElement* mimic = element.FirstChildElement("mimic")) {
    const char* source = mimic->Attribute("joint");
    if (!source) throw Fault("<mimic> has no joint");
    joint.mimic = {source, number_or(*mimic, "multiplier", 1), number_or(*mimic, "offset", 0)};
  }
}

Urdf::Joint read_joint(const XMLElement& element, const std::set<std::string>& links) {
  const auto text_of = [](const char* text) { return std::string(text ? text : ""); };
  Urdf::Joint joint;
  joint.name = text_of(element.Attribute("name"));
  joint.type = text_of(element.Attribute("type"));
  const std::string known_as = "the joint " + quoted(element.Attribute("name"));
  for (const auto& [role, end] : {std::pair("parent", &joint.parent), {"child", &joint.child}}) {
    const XMLElement* below = element.FirstChildElement(role);
    const char* link = below ? below->Attribute("link") : nullptr;
    if (!link || links.count(link) == 0) {
      throw InvalidValue({}, known_as + " with " + role + ' ' + quoted(link), "one of the links");
    }
    *end = link;
  }
  try {
    joint.origin = origin_of(element);
  } catch (const Fault& fault) {
    throw InvalidValue({}, known_as + ": " + fault.what(), "a place");
  }
  try {
    if (joint.moves()) read_motion(element, joint);
  } catch (const Fault& fault) {
    joint.fault = fault.what();
  }
  return joint;
}

/// Joints by child.
std::map<std::string, const Urdf::Joint*> by_child(const std::vector<Urdf::Joint>& joints) {
  std::map<std::string, const Urdf::Joint*> found;
  for (const Urdf::Joint& joint : joints) {
    if (found.emplace(joint.child, &joint).second) continue;
    throw InvalidValue({},
                       "the joint " + quoted(joint.name.c_str()) +
                           ", a second one with the child " + quoted(joint.child.c_str()),
                       "one joint to each link");
  }
  return found;
}

Pose pose_of(const std::string& link, const std::map<std::string, const Urdf::Joint*>& joints) {
  Pose pose;
  std::size_t steps = 0;
  for (auto joint = joints.find(link); joint != joints.end();
       joint = joints.find(joint->second->parent)) {
    pose = joint->second->origin * pose;
    if (++steps > joints.size()) {
      throw InvalidValue({}, "joints around in a circle at the link " + quoted(link.c_str()),
                         "a tree of links");
    }
  }
  pose.orientation.normalize();
  return pose;
}

Urdf read_robot(const XMLElement& robot) {
  Urdf urdf;
  const char* name = robot.Attribute("name");
  urdf.name = name && *name ? name : "robot";
  std::set<std::string> names;
  for (const XMLElement* each = robot.FirstChildElement("link"); each;
       each = each->NextSiblingElement("link")) {
    urdf.links.push_back(read_link(*each));
    if (names.insert(urdf.links.back().name).second) continue;
    throw InvalidValue({}, "two links called " + quoted(urdf.links.back().name.c_str()),
                       "a name of its own for each link");
  }
  for (const XMLElement* each = robot.FirstChildElement("joint"); each;
       each = each->NextSiblingElement("joint")) {
    urdf.joints.push_back(read_joint(*each, names));
  }
  return urdf;
}

}  // namespace

Urdf read_urdf(const std::string& text) {
  if (text.size() > max_file_size) {
    throw InvalidValue({}, std::to_string(text.size()) + " bytes",
                       "at most " + std::to_string(max_file_size));
  }
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    throw InvalidValue({}, shortened(document.ErrorStr(), 200), "the XML of a URDF");
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  const bool is_sdf = document.FirstChildElement("sdf");
  if (!robot && !is_sdf) {
    throw InvalidValue({}, "XML without <robot> and <sdf>", "a URDF or an SDF");
  }
  Urdf urdf = is_sdf ? read_sdf(text) : read_robot(*robot);
  const std::map<std::string, const Urdf::Joint*> joints = by_child(urdf.joints);
  for (Urdf::Link& link : urdf.links) link.pose = pose_of(link.name, joints);
  return urdf;
}

}  // namespace clothsim
