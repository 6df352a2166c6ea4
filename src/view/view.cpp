#include "clothsim/view/view.h"

#include <algorithm>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

template <typename Named>
std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) names.push_back(one.name);
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

void check_names(const View& view, const Scene& scene) {
  const auto check = [](const auto& looks, const std::string& key, const std::string& object,
                        const std::vector<std::string>& names, const std::string& none) {
    for (const auto& entry : looks) {
      if (std::count(names.begin(), names.end(), entry.first) > 0) continue;
      throw InvalidValue({key, entry.first}, object + " that the scene does not have",
                         names.empty() ? none : "one of " + join(names));
    }
  };
  check(view.cloths, "cloths", "a cloth", names_of(scene.cloth.parts),
        "none: the look of one is `cloth`");
  check(view.colliders, "colliders", "a collider", names_of(scene.colliders),
        "none, as the scene has none");
}

View without_missing_names(View view, const Scene& scene) {
  const auto leave_out = [](auto& looks, const std::vector<std::string>& names) {
    for (auto entry = looks.begin(); entry != looks.end();) {
      const bool known = std::count(names.begin(), names.end(), entry->first) > 0;
      entry = known ? std::next(entry) : looks.erase(entry);
    }
  };
  leave_out(view.cloths, names_of(scene.cloth.parts));
  leave_out(view.colliders, names_of(scene.colliders));
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
  for (const auto& entry : view.cloths) {
    inside("cloths", [&] {
      inside(entry.first, [&] { ready.cloths[entry.first] = make_shading(entry.second, images); });
    });
  }
  inside("collider", [&] { ready.collider = prepare(view.collider, images); });
  for (const auto& entry : view.colliders) {
    inside("colliders", [&] {
      inside(entry.first, [&] { ready.colliders[entry.first] = prepare(entry.second, images); });
    });
  }
  return ready;
}

}  // namespace clothsim
