#include "clothsim/scene/urdf_bodies.h"

#include <gtest/gtest.h>

#include "clothsim/shapes/mass_properties.h"

namespace clothsim::urdf_bodies_test {
namespace {

std::string box(const std::string& size, const std::string& origin = "0 0 0") {
  return "<collision><origin xyz='" + origin + "'/><geometry><box size='" + size +
         "'/></geometry></collision>";
}

std::string inertial(double mass, const Vector3& moments, const std::string& origin = "0 0 0") {
  return "<inertial><origin xyz='" + origin + "'/><mass value='" + std::to_string(mass) +
         "'/><inertia ixx='" + std::to_string(moments.x()) + "' iyy='" +
         std::to_string(moments.y()) + "' izz='" + std::to_string(moments.z()) +
         "' ixy='0' ixz='0' iyz='0'/></inertial>";
}

std::string link(const std::string& name, const std::string& content) {
  return "<link name='" + name + "'>" + content + "</link>";
}

std::string joint(const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& content = "") {
  return "<joint name='to_" + child + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + content + "</joint>";
}

/// The colliders of a URDF whose root is at `root`, as bodies.
std::vector<ColliderSpec> bodies_of(const std::string& content, const Pose& root = {}) {
  const Urdf urdf = read_urdf("<robot name='thing'>" + content + "</robot>");
  std::vector<ColliderSpec> colliders;
  std::vector<const Urdf::Link*> links;
  for (const Urdf::Link& each : urdf.links) {
    for (const Urdf::Collision& collision : each.collisions) {
      ColliderSpec collider;
      collider.name = each.name + std::to_string(colliders.size());
      collider.frame = each.name;
      collider.pose = root * each.pose;
      collider.offset = collision.origin;
      collider.shape = std::get<Cuboid>(collision.geometry);
      colliders.push_back(collider);
      links.push_back(&each);
    }
  }
  std::vector<LinkCollider> all;
  for (std::size_t k = 0; k < links.size(); ++k) all.push_back({links[k], &colliders[k]});
  make_bodies(urdf, root, all);
  return colliders;
}

std::string refusal(const std::string& content) {
  try {
    bodies_of(content);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "none";
}

const Vector3 moments(0.01, 0.02, 0.025);

TEST(UrdfBodies, ALinkIsAFreeBodyWithItsMass) {
  const std::vector<ColliderSpec> mug =
      bodies_of(link("mug", inertial(0.3, moments, "0 0 0.05") + box("0.08 0.08 0.1", "0 0 0.05") +
                                box("0.02 0.02 0.06", "0.05 0 0.05")),
                {Vector3(1, 2, 3)});
  ASSERT_TRUE(mug[0].body);
  EXPECT_EQ(mug[0].body->mass, 0.3);
  EXPECT_LT(mug[0].body->center_of_mass->norm(), 1e-15);  // that of the first shape
  EXPECT_TRUE(mug[0].body->inertia->isApprox(Matrix3(moments.asDiagonal())));
  EXPECT_FALSE(mug[0].body->joint);
  EXPECT_EQ(mug[1].part_of, "mug0");
  EXPECT_FALSE(mug[1].body);
  EXPECT_EQ(mug[0].frame + mug[1].frame, "");
}

TEST(UrdfBodies, FixedLinksAddTheirMass) {
  // Two halves of a bar have the moments of the whole one. (Text has six digits after the point.)
  const Cuboid half{{2, 1, 1}}, whole{{4, 1, 1}};
  const Vector3 of_half = mass_properties(half)->inertia.diagonal();
  const std::vector<ColliderSpec> bar =
      bodies_of(link("left", inertial(2, 2 * of_half) + box("2 1 1")) +
                link("right", inertial(2, 2 * of_half) + box("2 1 1")) +
                joint("fixed", "left", "right", "<origin xyz='2 0 0' rpy='1.5707963268 0 0'/>"));
  EXPECT_EQ(bar[0].body->mass, 4);
  EXPECT_LT((*bar[0].body->center_of_mass - Vector3(1, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(bar[0].body->inertia->isApprox(4 * mass_properties(whole)->inertia, 1e-5));
  EXPECT_EQ(bar[1].part_of, "left0");
}

/// A cabinet with a drawer, which has a handle, and a door.
std::string cabinet() {
  return link("cabinet", box("0.5 0.5 1")) +
         link("drawer", inertial(1, moments) + box("0.4 0.4 0.2")) +
         link("handle", inertial(0.1, moments) + box("0.02 0.1 0.02")) +
         link("door", inertial(2, moments, "0.2 0 0") + box("0.4 0.02 0.5", "0.2 0 0")) +
         joint("prismatic", "cabinet", "drawer",
               "<origin xyz='0 0 0.3' rpy='0 0 1.5707963267948966'/><axis xyz='0 1 0'/>"
               "<limit lower='0' upper='0.35'/>") +
         joint("fixed", "drawer", "handle", "<origin xyz='0.2 0 0'/>") +
         joint("revolute", "cabinet", "door",
               "<origin xyz='-0.2 0.25 -0.2'/><axis xyz='0 0 1'/><limit lower='-1.5' upper='0'/>");
}

TEST(UrdfBodies, MovableJointsLeadToBodies) {
  const Pose root{Vector3(0, 1, 0.5)};
  const std::vector<ColliderSpec> colliders = bodies_of(cabinet(), root);
  EXPECT_FALSE(colliders[0].body);  // it stands
  ASSERT_TRUE(colliders[1].body && colliders[1].body->joint);
  const Joint& slider = *colliders[1].body->joint;
  EXPECT_EQ(slider.kind, Joint::Kind::slider);
  EXPECT_LT((slider.axis - Vector3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_EQ(slider.upper, 0.35);
  EXPECT_EQ(colliders[1].body->mass, 1.1);
  EXPECT_EQ(colliders[2].part_of, "drawer1");
  const Joint& hinge = *colliders[3].body->joint;
  EXPECT_EQ(hinge.kind, Joint::Kind::hinge);
  EXPECT_LT((hinge.point - Vector3(-0.2, 1.25, 0.3)).norm(), 1e-12);
  EXPECT_EQ(hinge.lower, -1.5);
}

TEST(UrdfBodies, StayOrFallByTheirRoot) {
  const std::string part = inertial(1, moments) + box("0.1 0.1 0.1");
  EXPECT_FALSE(bodies_of(link("world", part))[0].body);
  EXPECT_FALSE(bodies_of(link("shelf", box("0.1 0.1 0.1")))[0].body);
  const std::vector<ColliderSpec> floating =
      bodies_of(link("world", "") + link("cup", part) + joint("floating", "world", "cup"));
  EXPECT_TRUE(floating[0].body && !floating[0].body->joint);
}

TEST(UrdfBodies, AreRefusedWithTheReason) {
  const std::string part = inertial(1, moments) + box("0.1 0.1 0.1");
  const std::string two = link("base", box("1 1 1")) + link("a", part);
  const std::string axis = "<axis xyz='1 0 0'/>";
  EXPECT_EQ(refusal(two + link("b", part) + joint("continuous", "base", "a", axis) +
                    joint("continuous", "a", "b", axis)),
            "bodies: got joint to_b, whose parent a moves, expected movable joints on links that "
            "stay");
  EXPECT_EQ(
      refusal(two + joint("planar", "base", "a", axis)),
      "bodies: got joint to_a of type planar, expected a fixed, floating, prismatic, revolute "
      "or continuous joint");
  EXPECT_EQ(
      refusal(link("base", "") + link("a", box("1 1 1")) + joint("continuous", "base", "a", axis)),
      "bodies: got link a without <inertial>, expected a mass for each link that moves");
  EXPECT_EQ(refusal(two + joint("prismatic", "base", "a", axis + "<limit lower='1' upper='2'/>")),
            "bodies: got the limits of joint to_a, expected a range with 0, where it starts");
  const std::string bad =
      "<inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' "
      "ixz='0' iyz='0'/></inertial>";
  EXPECT_EQ(
      refusal(link("a", bad + box("1 1 1"))),
      "bodies: got link a: value of <mass> is -1, not above 0, expected an <inertial> without "
      "a fault");
}

}  // namespace
}  // namespace clothsim::urdf_bodies_test
