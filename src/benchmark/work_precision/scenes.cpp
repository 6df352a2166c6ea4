#include "scenes.h"

#include <yaml-cpp/yaml.h>

#include "clothsim/simulation/scene_yaml.h"

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

namespace {

/// A cloth held along one edge, without strain limit: it swings down in one piece.
Scene edge_swing(int side) {
  Scene scene = corner_drop(side);
  scene.cloth.pinned.clear();
  for (int column = 0; column < side; ++column) scene.cloth.pinned.push_back({column, 0, ""});
  return scene;
}

/// pinned2 with its strain limit, damped so that it comes to rest soon. The rest shape does not
/// depend on damping.
Scene drape(int side) {
  Scene scene = shipped_scene("pinned2", side);
  scene.cloth.material.damping = 15;
  return scene;
}

/// Without strain limit: contact alone.
Scene without_limit(Scene scene) {
  scene.cloth.material.strain_limit.reset();
  return scene;
}

}  // namespace

std::vector<Trial> trials(bool quick) {
  if (quick) return {{"edge_swing", edge_swing(8), 18, Compared::all_frames, true}};
  return {
      {"edge_swing", edge_swing(25), 45, Compared::all_frames, true},
      {"corner_drop", corner_drop(25), 45, Compared::all_frames, true},
      {"corner_drop_50", corner_drop(50), 45, Compared::all_frames, true},
      {"drape", drape(20), 270, Compared::rest_shape, false},
      {"sphere_drop", without_limit(shipped_scene("sphere", 25)), 54, Compared::all_frames, false},
      {"self_fold", without_limit(shipped_scene("self_collision", 25)), 45, Compared::all_frames,
       false},
  };
}

}  // namespace clothsim::work_precision
