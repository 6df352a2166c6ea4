#include "clothsim/view/view.h"

#include <algorithm>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

std::vector<std::string> collider_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const ColliderSpec& collider : scene.colliders) names.push_back(collider.name);
  return names;
}

ColliderView prepare(const ColliderLook& look, ImageStore& images) {
  ColliderView view;
  view.shading = make_shading(look.look, images);
  view.segments = look.segments;
  view.extent = look.extent;
  validate(view);
  return view;
}

}  // namespace

void check_colliders(const View& view, const Scene& scene) {
  const std::vector<std::string> names = collider_names(scene);
  for (const auto& entry : view.colliders) {
    if (std::count(names.begin(), names.end(), entry.first) > 0) continue;
    throw InvalidValue({"colliders", entry.first}, "a collider that the scene does not have",
                       names.empty() ? "none, as the scene has none" : "one of " + join(names));
  }
}

View without_missing_colliders(View view, const Scene& scene) {
  const std::vector<std::string> names = collider_names(scene);
  for (auto entry = view.colliders.begin(); entry != view.colliders.end();) {
    const bool known = std::count(names.begin(), names.end(), entry->first) > 0;
    entry = known ? std::next(entry) : view.colliders.erase(entry);
  }
  return view;
}

PreparedView prepare(const View& view, ImageStore& images) {
  PreparedView ready;
  ready.camera = view.camera;
  ready.camera.pose = look_at(view.eye, view.target);
  validate(ready.camera);
  ready.light = view.light;
  inside("light", [&] { validate(ready.light); });
  ready.background.color = view.background;
  validate(ready.background);
  if (!view.sky.empty()) ready.background.sky = images.cube_map(view.sky, "sky");

  inside("cloth", [&] { ready.cloth = make_shading(view.cloth, images); });
  inside("collider", [&] { ready.collider = prepare(view.collider, images); });
  for (const auto& entry : view.colliders) {
    inside("colliders", [&] {
      inside(entry.first, [&] { ready.colliders[entry.first] = prepare(entry.second, images); });
    });
  }
  return ready;
}

}  // namespace clothsim
