#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "clothsim/model/checks.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// The links of a robot with their collision geometries and masses, as in a URDF.
struct Urdf {
  struct Mesh {
    std::string file;        // as in the URDF
    Vector3 scale{1, 1, 1};  // [m] per unit of the file
  };
  struct Collision {
    Pose origin;  // in the link's frame
    std::variant<Sphere, Cuboid, Cylinder, Capsule, Mesh> geometry;
    std::string fault;  // why it cannot be used; empty: usable
  };
  struct Inertial {
    Pose origin;                        // of the centre of mass, in the link's frame
    double mass = 0;                    // [kg]
    Matrix3 inertia = Matrix3::Zero();  // about it, in the axes of `origin` [kg m^2]
  };
  struct Link {
    std::string name;
    Pose pose;  // in the root's frame, all joints at 0
    std::vector<Collision> collisions;
    std::optional<Inertial> inertial;
    std::string inertial_fault;  // why it cannot be used; empty: usable, or none
  };

  struct Mimic {
    std::string joint;  // the joint that this one follows
    double multiplier = 1;
    double offset = 0;
  };
  struct Joint {
    std::string name;
    std::string type;  // as in the URDF
    std::string parent;
    std::string child;
    Pose origin;            // in the parent's frame
    Vector3 axis{1, 0, 0};  // in the joint's frame
    std::optional<Range> limit;
    std::optional<Mimic> mimic;
    std::string fault;  // why it cannot be moved; empty: movable, if its type is

    /// Other types are fixed.
    bool moves() const { return type == "revolute" || type == "continuous" || type == "prismatic"; }
  };

  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
};

/// Reads the links, their collisions and the tree of joints from the text of a URDF or of an SDF.
/// An error in one collision, or in the motion of a joint, goes into its `fault`. Throws
/// InvalidValue, without a key, for text that is neither, links without a name or with equal names,
/// joints to unknown links or in a cycle.
Urdf read_urdf(const std::string& text);

}  // namespace clothsim
