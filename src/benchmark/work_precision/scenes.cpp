#include "scenes.h"

#include <yaml-cpp/yaml.h>

#include "clothsim/scene/scene_yaml.h"

namespace clothsim::work_precision {

Scene shipped_scene(const std::string& name, int side) {
  YAML::Node yaml = load_scene_file(std::string(CLOTHSIM_SCENES_DIR) + "/" + name + ".yaml");
  Scene scene = read_scene(yaml);
  ClothSpec& cloth = scene.cloth;
  for (Pin& pin : cloth.pinned) {
    if (pin.column == cloth.columns - 1) pin.column = side - 1;
    if (pin.row == cloth.rows - 1) pin.row = side - 1;
  }
  cloth.columns = cloth.rows = side;
  return scene;
}

Scene corner_drop(int side) {
  Scene scene = shipped_scene("pinned2", side);
  scene.cloth.material.strain_limit.reset();
  return scene;
}

Scene fold(int side) {
  Scene scene = shipped_scene("self_collision", side);
  constexpr int shipped = 50;  // points a side
  scene.cloth.thickness *= double{shipped - 1} / (side - 1);
  scene.cloth.self_collision = SelfCollision::surface;
  return scene;
}

Scene sphere_drop(int side) {
  Scene scene = shipped_scene("sphere", side);
  scene.cloth.material.strain_limit.reset();
  return scene;
}

namespace {

/// A cloth held along one edge, without strain limit: it swings down in one piece.
Scene edge_swing(int side) {
  Scene scene = corner_drop(side);
  scene.cloth.pinned.clear();
  for (int column = 0; column < side; ++column) scene.cloth.pinned.push_back({column, 0, ""});
  return scene;
}

/// Just enough drag to hang still in three seconds. The rest shape does not depend on it [1/s].
constexpr double resting_damping = 8;

/// pinned2 with its strain limit.
Scene drape(int side) {
  Scene scene = shipped_scene("pinned2", side);
  scene.cloth.material.damping = resting_damping;
  return scene;
}

/// A strip of three columns, held at one end: with the stiffness of steel, the explicit step is far
/// below the step for the swing.
Scene ribbon(double ks) {
  constexpr int rows = 51;
  Scene scene = corner_drop(rows);
  ClothSpec& cloth = scene.cloth;
  cloth.columns = 3;
  cloth.width = 0.04;
  cloth.pinned = {{0, 0, ""}, {1, 0, ""}, {2, 0, ""}};
  cloth.material.ks = ks;
  return scene;
}

/// Without drag it would swing for ever; its frames are long, and its shape at rest is compared.
Scene settle(int side) {
  Scene scene = corner_drop(side);
  scene.cloth.material.damping = 0;
  scene.simulation.frames_per_second = 5;
  return scene;
}

}  // namespace

std::vector<Trial> trials(bool quick) {
  constexpr Compared all = Compared::all_frames;
  if (quick) return {{"edge_swing", edge_swing(8), 18, all, true, 1, true}};
  Scene bare_fold = shipped_scene("self_collision", 25);  // contact only
  bare_fold.cloth.material.strain_limit.reset();
  return {
      {"edge_swing", edge_swing(25), 45, all, true, 4, true},
      {"corner_drop", corner_drop(25), 45, all, true, 4, false},
      {"corner_drop_50", corner_drop(50), 45, all, true, 1, false},
      {"ribbon", ribbon(5e7), 45, all, true, 16, false, {}, 1e-6},
      {"stiff_ribbon", ribbon(1e9), 15, all, true, 16, false},
      {"settle", settle(12), 60, Compared::rest_shape, false, 8, false, resting_damping},
      {"drape", drape(20), 270, Compared::rest_shape, false, 2, false},
      {"sphere_drop", sphere_drop(25), 54, all, false, 2, false},
      {"self_fold", bare_fold, 45, all, false, 2, false},
  };
}

}  // namespace clothsim::work_precision
