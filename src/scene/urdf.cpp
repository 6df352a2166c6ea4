#include "clothsim/scene/urdf.h"

#include <tinyxml2.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "clothsim/model/checks.h"
#include "clothsim/scene/scene.h"

namespace clothsim {
namespace {

using tinyxml2::XMLElement;

/// What is wrong with one collision.
using Fault = std::runtime_error;

std::string quoted(const char* text) {
  return text ? '"' + shortened(text, longest_shown) + '"' : "nothing";
}

/// `count` finite numbers with blanks between them, of an attribute.
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

/// Of <origin>, if there is one: roll, pitch and yaw about fixed axes.
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

Urdf::Link read_link(const XMLElement& element) {
  Urdf::Link link;
  const char* name = element.Attribute("name");
  if (!name || !*name) throw InvalidValue({}, "a link without a name", "a name for each link");
  link.name = name;
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

struct Joint {
  std::string parent;
  Pose origin;
};

/// Where joints hang from, by child.
std::map<std::string, Joint> read_joints(const XMLElement& robot,
                                         const std::set<std::string>& links) {
  std::map<std::string, Joint> joints;
  for (const XMLElement* each = robot.FirstChildElement("joint"); each;
       each = each->NextSiblingElement("joint")) {
    const std::string joint = "the joint " + quoted(each->Attribute("name"));
    std::array<std::string, 2> ends;
    for (const std::size_t end : {0, 1}) {
      const char* role = end == 0 ? "parent" : "child";
      const XMLElement* element = each->FirstChildElement(role);
      const char* link = element ? element->Attribute("link") : nullptr;
      if (!link || links.count(link) == 0) {
        throw InvalidValue({}, joint + " with " + role + ' ' + quoted(link), "one of the links");
      }
      ends[end] = link;
    }
    Joint read{ends[0], {}};
    try {
      read.origin = origin_of(*each);
    } catch (const Fault& fault) {
      throw InvalidValue({}, joint + ": " + fault.what(), "a place");
    }
    if (!joints.emplace(ends[1], read).second) {
      throw InvalidValue({}, joint + ", a second one with the child " + quoted(ends[1].c_str()),
                         "one joint to each link");
    }
  }
  return joints;
}

Pose pose_of(const std::string& link, const std::map<std::string, Joint>& joints) {
  Pose pose;
  std::size_t steps = 0;
  for (auto joint = joints.find(link); joint != joints.end();
       joint = joints.find(joint->second.parent)) {
    pose = joint->second.origin * pose;
    if (++steps > joints.size()) {
      throw InvalidValue({}, "joints around in a circle at the link " + quoted(link.c_str()),
                         "a tree of links");
    }
  }
  pose.orientation.normalize();
  return pose;
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
  if (!robot) throw InvalidValue({}, "XML without <robot>", "a URDF");
  Urdf urdf;
  const char* name = robot->Attribute("name");
  urdf.name = name && *name ? name : "robot";
  std::set<std::string> names;
  for (const XMLElement* each = robot->FirstChildElement("link"); each;
       each = each->NextSiblingElement("link")) {
    urdf.links.push_back(read_link(*each));
    if (names.insert(urdf.links.back().name).second) continue;
    throw InvalidValue({}, "two links called " + quoted(urdf.links.back().name.c_str()),
                       "a name of its own for each link");
  }
  const std::map<std::string, Joint> joints = read_joints(*robot, names);
  for (Urdf::Link& link : urdf.links) link.pose = pose_of(link.name, joints);
  return urdf;
}

}  // namespace clothsim
