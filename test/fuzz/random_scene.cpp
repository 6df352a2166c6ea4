#include "fuzz/random_scene.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "algebra.h"
#include "clothsim/dynamics/integrator.h"
#include "fuzz/draw.h"
#include "meshes.h"

namespace clothsim::test {
namespace {

const char* const shape_names[] = {"sphere", "plane", "capsule", "box", "cylinder", "mesh"};

Material random_material(Draw& draw) {
  Material material;
  material.ks = draw.decades(50, 1e5);
  material.density = draw.decades(0.1, 500);
  material.damping = draw.happens(0.1) ? 0 : draw.decades(0.1, 30);
  material.strain_limit = draw.happens(0.1) ? 0 : draw.decades(0.01, 0.5);
  if (draw.happens(0.15)) material.strain_limit.reset();
  if (draw.happens(0.1)) material.springs[1] = material.springs[2] = false;
  return material;
}

/// Sometimes zero: each value of a fabric may be.
double or_zero(Draw& draw, double value) { return draw.happens(0.1) ? 0 : value; }

/// For cells `ratio` times as wide as high. The shear stiffness is below that of stretch, as in
/// woven cloth.
Fabric random_fabric(Draw& draw, double ratio) {
  Fabric fabric;
  double max_shear = 1e4;
  for (const int i : {0, 1}) {
    double& stretch = fabric.stretch_stiffness[i];
    stretch = or_zero(draw, draw.decades(10, 1e4));
    const double added = i == 0 ? ratio * ratio : 1 / (ratio * ratio);
    if (stretch > 0) max_shear = std::min(max_shear, stretch / added);
  }
  fabric.shear_stiffness = or_zero(draw, draw.decades(0.001, 0.999) * max_shear);
  for (double& bending : fabric.bending_stiffness)
    bending = or_zero(draw, draw.decades(1e-7, 1e-2));
  fabric.internal_damping = {or_zero(draw, draw.decades(1e-7, 1e-3)),
                             or_zero(draw, draw.decades(1e-5, 0.1))};
  return fabric;
}

/// Wind, gusts, both or none.
void add_wind(Draw& draw, SimulationSpec& simulation) {
  if (draw.happens(0.4)) simulation.wind = draw.decades(0.1, 30) * draw.direction();
  if (draw.happens(0.2)) simulation.gusts = draw.decades(0.1, 10);
}

ClothSpec random_cloth(Draw& draw, int most) {
  ClothSpec cloth;
  cloth.columns = static_cast<int>(draw.decades(2, most + 1));
  cloth.rows = static_cast<int>(draw.decades(2, most + 1));
  if (draw.happens(0.05)) cloth.columns = 1;  // a rope
  const double cell = draw.decades(0.02, 0.1);
  cloth.width = cell * std::max(1, cloth.columns - 1);
  cloth.height = cell * draw.decades(0.5, 2) * (cloth.rows - 1);
  if (draw.happens(0.5)) cloth.orientation = Orientation::vertical;
  cloth.material = random_material(draw);
  cloth.thickness = draw.decades(0.001, 0.4 * cell);
  cloth.self_collision = static_cast<SelfCollision>(draw.whole(0, 3));
  if (cloth.columns == 1 && cloth.self_collision == SelfCollision::surface) {
    cloth.self_collision = SelfCollision::points;
  }
  cloth.friction = draw.even(0, 1);
  return cloth;
}

/// No pins, corners, an edge, or any points.
std::vector<Pin> random_pins(Draw& draw, const ClothSpec& cloth) {
  const int last_column = cloth.columns - 1, last_row = cloth.rows - 1;
  std::vector<Pin> pins;
  const auto add = [&](int column, int row) {
    const bool is_new = std::none_of(pins.begin(), pins.end(), [&](const Pin& pin) {
      return pin.column == column && pin.row == row;
    });
    if (is_new) pins.push_back({column, row, ""});
  };
  switch (draw.whole(0, 4)) {
    case 0:
      break;
    case 1:
      add(0, last_row);
      add(last_column, last_row);
      break;
    case 2:
      for (const int column : {0, last_column}) {
        for (const int row : {0, last_row}) add(column, row);
      }
      break;
    case 3:
      for (int column = 0; column <= last_column; ++column) add(column, last_row);
      break;
    default:
      for (int i = draw.whole(1, 4); i > 0; --i) {
        const int column = draw.whole(0, last_column);
        add(column, draw.whole(0, last_row));
      }
  }
  return pins;
}

/// At any speed, and over three times `size` [m] at most.
Motion random_motion(Draw& draw, double size) {
  Motion motion;
  if (draw.happens(0.3)) return motion;
  const double speed = draw.decades(0.01, 10);
  motion.velocity = speed * draw.direction();
  if (draw.happens(0.3)) motion.turn = draw.decades(0.1, 20) * draw.direction();
  motion.duration = std::min(driven_for, draw.decades(0.03, 3) * size / speed);
  motion.returns = draw.happens(0.5);
  return motion;
}

/// One of the first `kinds`.
Shape random_shape(Draw& draw, double size, int kinds) {
  const double width = size * draw.decades(0.02, 0.3), length = size * draw.decades(0.2, 2);
  switch (draw.whole(0, kinds - 1)) {
    case 0:
      return Sphere{size * draw.decades(0.03, 0.5)};
    case 1:
      return Plane{draw.happens(0.3)};
    case 2:
      return Capsule{length, width};
    case 3:
      return Cuboid{{length, width, size * draw.decades(0.05, 1)}};
    case 4:
      return Cylinder{draw.happens(0.5) ? length : width, draw.happens(0.5) ? length / 2 : width};
    default:
      return mesh_shape(draw.happens(0.5) ? torus_soup(length / 2, width / 2, 16, 8)
                                          : step_soup(length));
  }
}

/// Beside the cloth, sometimes in it.
ColliderSpec random_collider(Draw& draw, const ClothSpec& cloth, int index, int kinds) {
  const double size = std::max(cloth.width, cloth.height);
  ColliderSpec collider;
  collider.name = "collider" + std::to_string(index);
  collider.shape = random_shape(draw, size, kinds);
  collider.friction = draw.happens(0.2) ? 0 : draw.even(0, 2);
  const bool is_upright = cloth.orientation == Orientation::vertical;
  const Vector3 across = is_upright ? Vector3::UnitY() : Vector3::UnitZ();
  const Vector3 up = is_upright ? Vector3::UnitZ() : Vector3::UnitY();
  const Vector3 middle = cloth.origin + draw.even(0, 1) * cloth.width * Vector3::UnitX() +
                         draw.even(0, 1) * cloth.height * up;
  if (std::holds_alternative<Plane>(collider.shape)) {
    const Vector3 tilt = 0.3 * draw.direction();
    collider.pose.position = cloth.origin - draw.decades(1e-3, 1) * size * Vector3::UnitZ() -
                             tilt.norm() * size * Vector3::UnitZ();
    collider.pose.orientation = turn_between(Vector3::UnitZ(), Vector3::UnitZ() + tilt);
    return collider;
  }
  const double radius = bounding_radius(collider.shape);
  const double away = draw.happens(0.15) ? 0 : 1.01 * radius + draw.decades(1e-3, 0.5) * size;
  collider.pose.position = middle + (draw.happens(0.5) ? away : -away) * across;
  collider.pose.orientation = draw.orientation();
  return collider;
}

SimulationSpec random_simulation(Draw& draw) {
  SimulationSpec simulation;
  if (draw.happens(0.2)) simulation.gravity = draw.even(0, 15) * draw.direction();
  if (draw.happens(0.3)) simulation.frames_per_second = draw.whole(30, 240);
  if (draw.happens(0.2)) simulation.method = draw.one_of(method_names());
  simulation.seed = static_cast<std::uint64_t>(draw.whole(1, 1000));
  return simulation;
}

std::string text_of_springs(const Material& material) {
  std::ostringstream out;
  out.precision(3);
  if (!material.fabric) {
    out << "ks " << material.ks;
    return out.str();
  }
  const auto& [stretch, shear, bending, damping, poisson] = *material.fabric;
  out << "stretch " << stretch[0] << " " << stretch[1] << ", shear " << shear << ", bending "
      << bending[0] << " " << bending[1] << ", internal damping " << damping[0] << " " << damping[1]
      << ", poisson " << poisson;
  return out.str();
}

double reach_of(const Shape& shape) {
  const double radius = bounding_radius(shape);
  return std::isfinite(radius) ? radius : 0;
}

}  // namespace

Pose Motion::at(double time, const Pose& start) const {
  double t = std::min(time, duration);
  if (returns) t = duration / M_PI * std::sin(M_PI * t / duration);
  const double angle = turn.norm() * t;
  Pose pose = start;
  pose.position += velocity * t;
  if (angle > 0) pose.orientation = Eigen::AngleAxisd(angle, turn.normalized()) * start.orientation;
  return pose;
}

RandomScene random_scene(std::uint64_t seed, int most) {
  // Seeds below keep the scenes from before there were cylinders and meshes.
  constexpr std::uint64_t with_all_shapes = 100000;
  const int kinds = seed < with_all_shapes ? 4 : 6;
  Draw draw(seed);
  RandomScene random;
  Scene& scene = random.scene;
  scene.cloth = random_cloth(draw, most);
  scene.cloth.pinned = random_pins(draw, scene.cloth);
  const double size = std::max(scene.cloth.width, scene.cloth.height);
  scene.simulation = random_simulation(draw);
  const int colliders = draw.happens(scene.cloth.pinned.empty() ? 0.5 : 0.2) ? 0 : draw.whole(1, 4);
  for (int i = 0; i < colliders; ++i) {
    scene.colliders.push_back(random_collider(draw, scene.cloth, i, kinds));
    random.colliders.push_back(random_motion(draw, size));
    // A plane that turns sweeps all space.
    if (std::holds_alternative<Plane>(scene.colliders.back().shape)) {
      random.colliders.back().turn.setZero();
    }
  }
  const Motion together = random_motion(draw, size);
  const bool each_by_itself = draw.happens(0.3);
  const bool pins_move = draw.happens(0.6);
  for (std::size_t i = 0; i < scene.cloth.pinned.size(); ++i) {
    Motion motion = pins_move ? (each_by_itself ? random_motion(draw, size) : together) : Motion{};
    motion.turn.setZero();
    random.pins.push_back(motion);
  }
  if (scene.cloth.pinned.empty() && draw.happens(0.5)) {
    random.velocity = draw.decades(0.1, 10) * draw.direction();
    random.spin = draw.decades(0.1, 20) * draw.direction();
  }
  return random;
}

RandomScene random_fabric_scene(std::uint64_t seed, int most) {
  RandomScene random = random_scene(seed, most);
  Draw draw(seed + 1);
  ClothSpec& cloth = random.scene.cloth;
  Material& material = cloth.material;
  const double du = cloth.width / std::max(1, cloth.columns - 1);
  const double dv = cloth.height / std::max(1, cloth.rows - 1);
  material.fabric = random_fabric(draw, du / dv);
  material.density = draw.decades(0.03, 1);
  material.drag = {or_zero(draw, draw.decades(0.1, 3)), or_zero(draw, draw.decades(0.001, 0.3))};
  if (draw.happens(0.7)) material.damping = 0;
  if (draw.happens(0.7)) material.strain_limit.reset();
  cloth.thickness = draw.decades(1e-4, 0.2 * std::min(du, dv));
  add_wind(draw, random.scene.simulation);
  if (draw.happens(0.3)) material.fabric->poisson = draw.even(-0.9, 0.9);
  return random;
}

std::string RandomScene::text() const {
  const ClothSpec& cloth = scene.cloth;
  const Material& material = cloth.material;
  std::ostringstream out;
  out.precision(3);
  out << cloth.columns << " x " << cloth.rows << " of " << cloth.width << " x " << cloth.height
      << " m, " << text_of_springs(material) << ", density " << material.density << ", damping "
      << material.damping << ", limit ";
  if (material.strain_limit) {
    out << *material.strain_limit;
  } else {
    out << "off";
  }
  out << ", self " << self_collision_names[static_cast<std::size_t>(cloth.self_collision)] << ", "
      << scene.simulation.method << ", " << pins.size() << " pins";
  if (scene.simulation.wind) out << ", wind " << scene.simulation.wind->norm();
  if (scene.simulation.gusts > 0) out << ", gusts " << scene.simulation.gusts;
  const auto moves = [](const Motion& motion) { return motion.moves(); };
  if (std::any_of(pins.begin(), pins.end(), moves)) out << " moved";
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    out << ", " << shape_names[scene.colliders[i].shape.index()];
    if (colliders[i].moves()) out << " moved";
  }
  if (!velocity.isZero()) out << ", thrown";
  return out.str();
}

double RandomScene::max_drive_speed() const {
  double max_speed =
      velocity.norm() + spin.norm() * std::hypot(scene.cloth.width, scene.cloth.height);
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const double reach = reach_of(scene.colliders[i].shape);
    max_speed =
        std::max(max_speed, colliders[i].velocity.norm() + colliders[i].turn.norm() * reach);
  }
  const SimulationSpec& simulation = scene.simulation;
  const double wind = simulation.wind.value_or(Vector3::Zero()).norm();
  max_speed = std::max(max_speed, wind + std::sqrt(3) * simulation.gusts);
  for (const Motion& pin : pins) max_speed = std::max(max_speed, pin.velocity.norm());
  return max_speed;
}

bool RandomScene::may_be_pulled() const {
  const bool pins_part = std::any_of(pins.begin(), pins.end(), [&](const Motion& pin) {
    return pin.velocity != pins.front().velocity || pin.returns != pins.front().returns;
  });
  return pins_part || (!pins.empty() && !colliders.empty()) || colliders.size() > 1;
}

}  // namespace clothsim::test
