#include "fuzz/random_bodies.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "bodies.h"
#include "clothsim/shapes/mass_properties.h"
#include "fuzz/draw.h"

namespace clothsim::test {
namespace {

class Maker {
 public:
  explicit Maker(std::uint64_t seed) : draw_(seed) { made_.scene.simulation.seed = seed; }

  BodyScene make() {
    made_.setting = static_cast<Setting>(draw_.whole(0, 2));
    const bool hangs = made_.setting == Setting::hung;
    add_cloth(hangs);
    add_ground();
    const bool may_hold = draw_.happens(0.3);
    if (hangs) hang(!may_hold);
    if (!hangs && draw_.happens(0.25)) {  // a body beside the cloth with some points of its edge
      const std::size_t k = add_body(draw_.even(0.05, 0.2));
      put(k, {-cloth_.width / 2 - reach_of(k), 0, height_ + reach_of(k)});
      const int first = draw_.whole(1, cloth_.rows - 2);
      attach(k, {0, first}, {0, 1}, draw_.whole(1, cloth_.rows - 1 - first));
    }
    for (int k = draw_.whole(1, hangs ? 2 : 4); k > 0; --k) add_loose(!may_hold);
    if (may_hold) hold();
    made_.text = text_.str();
    return made_;
  }

 private:
  void add_cloth(bool hangs) {
    ClothSpec& c = cloth_;
    c.columns = c.rows = draw_.whole(6, 20);
    c.width = c.height = draw_.even(0.4, 1.2);
    c.material.ks = draw_.decades(100, 3000);
    c.material.density = draw_.decades(0.1, 1);
    c.material.damping = draw_.decades(0.5, 5);
    c.material.strain_limit.reset();
    if (draw_.happens(0.5)) c.material.strain_limit = draw_.decades(0.05, 0.3);
    c.self_collision = static_cast<SelfCollision>(draw_.whole(0, 2));
    c.thickness = draw_.decades(0.001, 0.2 * c.width / (c.columns - 1));
    height_ = draw_.even(0.5, 1);
    if (made_.setting == Setting::laid && draw_.happens(0.5)) height_ = 0;
    if (hangs) height_ = 1.2;
    top_ = height_;
    c.origin = {-c.width / 2, hangs ? 0 : -c.width / 2, height_ + surface_offset};
    if (hangs) c.orientation = Orientation::vertical;
    if (made_.setting == Setting::trampoline) pin(0), pin(c.rows - 1);
    text_ << (hangs              ? "hung "
              : c.pinned.empty() ? "laid "
                                 : "pinned ")
          << c.columns << " of " << c.width << " m, ks " << c.material.ks << ", "
          << c.material.density << " kg/m^2, limit " << c.material.strain_limit.value_or(0) << "; ";
  }

  void pin(int r) {
    for (const int column : {0, cloth_.columns - 1}) cloth_.pinned.push_back({column, r, "", {}});
  }

  /// A floor, and a table below a cloth that lies higher.
  void add_ground() {
    const double friction = draw_.even(0, 1), width = cloth_.width * draw_.even(0.5, 2);
    colliders_.push_back({"floor", Plane{}, {}, friction, ""});
    if (made_.setting != Setting::laid || height_ == 0) return;
    colliders_.push_back({"table", Cuboid{{width, width, 0.2}}, {}, friction, ""});
    colliders_[1].pose.position.z() = height_ - 0.1;
  }

  Shape box(double size) {
    return Cuboid{size * draw_.in_box(Vector3::Constant(0.25), Vector3::Constant(1.4))};
  }

  Shape shape(double size) {
    const double length = size * draw_.even(0.3, 1.5), radius = size * draw_.even(0.2, 0.7);
    const int kind = draw_.whole(0, 4);
    if (kind == 0) return Sphere{size};
    if (kind == 1) return Capsule{length, radius};
    return kind == 2 ? Shape(Cylinder{length, radius}) : box(size);
  }

  /// Adds a body at the origin, a box with a further box at times. `share`: of the cloth's width.
  std::size_t add_body(double share) {
    const double size = share * cloth_.width;
    const double ratio = draw_.decades(1e-3, draw_.happens(0.9) ? 300 : 1000);
    const double mass = ratio * cloth_.material.density * cloth_.width * cloth_.width;
    const std::size_t k = colliders_.size();
    ColliderSpec spec = body(shape(size), {0, 0, 0}, mass, draw_.even(0, 1));
    spec.name = "body" + std::to_string(k);
    spec.pose.orientation = draw_.orientation();
    spec.body->damping = draw_.even(0.5, 3);
    text_ << spec.name << " of " << ratio << ", shape " << spec.shape.index() << "; ";
    colliders_.push_back(spec);
    if (!std::holds_alternative<Cuboid>(spec.shape) || draw_.happens(0.5)) return k;
    spec.part_of = std::exchange(spec.name, spec.name + "b");
    spec.body.reset();
    spec.shape = box(size);
    spec.pose = spec.pose * Pose{0.6 * size * draw_.direction(), draw_.orientation()};
    colliders_.push_back(spec);
    return k;
  }

  /// Radius about the origin of the last body that holds its shapes, and a little more [m].
  double reach_of(std::size_t k) {
    const ColliderSpec &first = colliders_[k], &last = colliders_.back();
    const double way = (last.pose.position - first.pose.position).norm();
    return std::max(bounding_radius(first.shape), way + bounding_radius(last.shape)) + 2e-3;
  }

  /// Puts the last body at a place.
  void put(std::size_t k, const Vector3& at) {
    top_ = std::max(top_, at.z() + reach_of(k));
    for (; k < colliders_.size(); ++k) colliders_[k].pose.position += at;
  }

  /// A body above all others, or that flies against a hanging cloth.
  void add_loose(bool may_join) {
    const double wide = 0.35 * cloth_.width, drop = draw_.even(0, 0.5);
    const double x = draw_.even(-wide, wide), y = draw_.even(-wide, wide);
    const std::size_t k = add_body(draw_.even(0.05, 0.15));
    if (made_.setting == Setting::hung) {
      side_ = -side_;
      put(k, {x, side_ * (reach_of(k) + drop), height_ + draw_.even(0.3, 0.7) * cloth_.height});
      colliders_[k].body->velocity.y() = -side_ * draw_.even(0, 2);
    } else {
      put(k, {x, y, std::max(top_, height_ + drop) + reach_of(k)});
    }
    if (may_join && draw_.happens(0.3)) add_joint(k);
  }

  void add_joint(std::size_t k) {
    Joint joint{draw_.happens(0.5) ? Joint::Kind::slider : Joint::Kind::hinge};
    if (draw_.happens(0.5)) joint.axis = draw_.direction();
    joint.point = colliders_[k].pose.position + 0.3 * draw_.direction();
    joint.lower = -draw_.even(0, 1);
    joint.upper = draw_.even(0, 1);
    colliders_[k].body->joint = joint;
  }

  /// Attaches so many points of a line of the grid, or only its ends, to a body.
  void attach(std::size_t k, std::array<int, 2> point, std::array<int, 2> step, int count) {
    cloth_.attached.push_back({colliders_[k].name, {}, {}});
    const bool ends_alone = draw_.happens(0.5);
    for (int i = 0; i < count; ++i, point = {point[0] + step[0], point[1] + step[1]}) {
      if (!ends_alone || i == 0 || i == count - 1) cloth_.attached[0].points.push_back(point);
    }
  }

  /// The upper edge on a bar that a joint or a frame holds, or the lower one on a weight.
  void hang(bool may_join) {
    const bool is_bar = draw_.happens(0.6);
    const std::size_t k = add_body(draw_.even(0.1, 0.25));
    put(k, {0, 0, height_ + (is_bar ? cloth_.height + reach_of(k) : -reach_of(k))});
    attach(k, {0, is_bar ? cloth_.rows - 1 : 0}, {1, 0}, cloth_.columns);
    if (!is_bar) return pin(cloth_.rows - 1);
    if (may_join) return add_joint(k);
    made_.held = static_cast<int>(k);
  }

  /// A frame holds a body and moves it up. Joints would leave other bodies no room.
  void hold() {
    while (made_.held < 0 || !colliders_[static_cast<std::size_t>(made_.held)].body) {
      made_.held = draw_.whole(1, static_cast<int>(colliders_.size()) - 1);
    }
    made_.velocity = (draw_.even(0, 0.4) * draw_.direction());
    made_.velocity.z() = std::abs(made_.velocity.z());
    if (draw_.happens(0.5)) made_.turn = draw_.even(0, 3) * draw_.direction();
  }

  Draw draw_;
  BodyScene made_;
  std::ostringstream text_;
  ClothSpec& cloth_ = made_.scene.cloth;
  std::vector<ColliderSpec>& colliders_ = made_.scene.colliders;
  double height_ = 0, top_ = 0;  // of the cloth's lower edge and of all bodies [m]
  double side_ = 1;
};

}  // namespace

BodyScene random_body_scene(std::uint64_t seed) { return Maker(seed).make(); }

}  // namespace clothsim::test
