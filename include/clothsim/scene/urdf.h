#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// The links of a robot with their collision geometries, as a URDF has them.
struct Urdf {
  struct Mesh {
    std::string file;        // as the URDF names it
    Vector3 scale{1, 1, 1};  // metres a unit of the file
  };
  struct Collision {
    Pose origin;  // in the link's frame
    std::variant<Sphere, Cuboid, Cylinder, Capsule, Mesh> geometry;
    std::string fault;  // why it cannot be used; empty: it can
  };
  struct Link {
    std::string name;
    Pose pose;  // in the root's frame, all joints at 0
    std::vector<Collision> collisions;
  };

  struct Mimic {
    std::string joint;  // that it follows
    double multiplier = 1;
    double offset = 0;
  };
  struct Joint {
    std::string name;
    std::string type;  // as the URDF names it
    std::string parent;
    std::string child;
    Pose origin;            // in the parent's frame
    Vector3 axis{1, 0, 0};  // in the joint's frame
    std::optional<Range> limit;
    std::optional<Mimic> mimic;
    std::string fault;  // why it cannot be moved; empty: it can, if its type does

    /// Other types stay where they are.
    bool moves() const { return type == "revolute" || type == "continuous" || type == "prismatic"; }
  };

  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
};

/// Reads the text of a URDF, of which links, their collisions and the tree of joints count. What is
/// wrong with one collision, or with how a joint moves, is its fault; throws InvalidValue, without
/// a key, for what is no URDF: other text, links without a name or of one name, joints to no link
/// or around in a circle.
Urdf read_urdf(const std::string& text);

}  // namespace clothsim
