#include "clothsim/scene/bodies_yaml.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>

#include "clothsim/scene/colliders_yaml.h"
#include "clothsim/shapes/mass_properties.h"

namespace clothsim {
namespace {

/// Moments of inertia [kg m^2]: [xx, yy, zz], or [xx, xy, xz, yy, yz, zz] as in a URDF.
Matrix3 read_inertia(const YAML::Node& node) {
  const bool is_list = node.IsSequence() && (node.size() == 3 || node.size() == 6);
  if (!is_list) {
    throw InvalidValue({}, describe(node), "[xx, yy, zz] or [xx, xy, xz, yy, yz, zz]");
  }
  if (node.size() == 3) return read_vector(node).asDiagonal();
  std::vector<double> m;
  read_list(node, [&](const YAML::Node& item) { m.push_back(read_number(item)); });
  Matrix3 inertia;
  inertia << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
  return inertia;
}

Joint read_joint(const YAML::Node& node) {
  Joint joint;
  bool has_kind = false;
  const auto read_kind = [&](const YAML::Node& value) {
    joint.kind = static_cast<Joint::Kind>(read_choice(value, {"slider", "hinge"}));
    has_kind = true;
  };
  read_map(node, {{"type", read_kind},
                  {"axis", [&](const YAML::Node& axis) { joint.axis = read_direction(axis); }},
                  {"point", into(joint.point)},
                  {"lower", into(joint.lower)},
                  {"upper", into(joint.upper)}});
  if (!has_kind) throw InvalidValue({"type"}, "nothing", "slider or hinge");
  return joint;
}

void check_joint(const Joint& joint) {
  check_range("point", joint.point, position_range);
  if (!(std::abs(joint.axis.norm() - 1) < written_rounding)) {
    throw InvalidValue({"axis"}, "a vector of length " + to_text(joint.axis.norm()), "length 1");
  }
  if (!(joint.lower <= 0)) {  // true for NaN
    throw InvalidValue({"lower"}, to_text(joint.lower), "at most 0, as the body starts at 0");
  }
  if (!(joint.upper >= 0)) {
    throw InvalidValue({"upper"}, to_text(joint.upper), "at least 0, as the body starts at 0");
  }
}

/// A solid's principal moments are positive, and none is larger than the sum of the others.
void check_inertia(const Matrix3& inertia) {
  const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia).eigenvalues();
  const bool is_solid = moments.allFinite() && moments[0] >= inertia_range.min &&
                        moments[2] <= inertia_range.max &&
                        moments[2] <= (1 + written_rounding) * (moments[0] + moments[1]);
  if (is_solid) return;
  throw InvalidValue({"inertia"},
                     "the principal moments " + to_text(moments[0]) + ", " + to_text(moments[1]) +
                         " and " + to_text(moments[2]),
                     "those of a solid: each above " + to_text(inertia_range.min) +
                         " kg m^2 and at most the sum of the other two");
}

}  // namespace

std::vector<Field> body_fields(BodySpec& body) {
  return {
      {"inertia", [&](const YAML::Node& node) { body.inertia = read_inertia(node); }},
      {"center_of_mass", [&](const YAML::Node& node) { body.center_of_mass = read_vector(node); }},
      {"damping", into(body.damping)},
      {"velocity", into(body.velocity)},
      {"angular_velocity", into(body.angular_velocity)},
      {"joint", [&](const YAML::Node& node) { body.joint = read_joint(node); }}};
}

void check_body(const ColliderSpec& collider) {
  const BodySpec& body = *collider.body;
  check_range("mass", body.mass, body_mass_range);
  if (std::holds_alternative<Plane>(collider.shape)) {
    throw InvalidValue({"mass"}, "that of a plane", "a solid");
  }
  const std::optional<MassProperties> even = mass_properties(collider.shape);
  if (body.center_of_mass) {
    check_range("center_of_mass", *body.center_of_mass, position_range);
  } else if (!even) {
    throw InvalidValue({"center_of_mass"}, "nothing", "one, as a sheet has no volume");
  }
  if (!even && !body.inertia) {
    throw InvalidValue({"inertia"}, "nothing", "one, as a sheet has no volume");
  }
  check_inertia(body.inertia.value_or(body.mass * even.value_or(MassProperties()).inertia));
  check_range("damping", body.damping, body_damping_range);
  check_range("velocity", body.velocity, velocity_range);
  check_range("angular_velocity", body.angular_velocity, angular_velocity_range);
  if (!collider.frame.empty()) {
    throw InvalidValue({"frame"}, collider.frame, "none, as the collider has a mass");
  }
  if (body.joint) inside("joint", [&] { check_joint(*body.joint); });
}

}  // namespace clothsim
