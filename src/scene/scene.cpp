#include "clothsim/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "clothsim/model/checks.h"
#include "clothsim/scene/colliders_yaml.h"

namespace clothsim {
namespace {

constexpr Range gravity_range{-1e6, 1e6, "m/s^2"};
constexpr Range wind_range{-300, 300, "m/s"};
constexpr Range gusts_range{0, 300, "m/s"};
constexpr Range frames_per_second_range{1e-3, 1e6, "Hz"};
constexpr Range strain_tolerance_range{1e-9, 1, ""};
constexpr Range tolerance_range{1e-9, 1, ""};
constexpr Range linear_range{-1e6, 1e6, "m/s"};
constexpr Range angular_range{-1e6, 1e6, "rad/s"};

/// Throws InvalidValue unless it is the name of a collider with a mass.
void check_names_body(const std::string& name, const std::vector<ColliderSpec>& colliders) {
  std::vector<std::string> names;
  for (const ColliderSpec& collider : colliders) {
    if (!collider.body) continue;
    if (collider.name == name) return;
    names.push_back(collider.name);
  }
  throw InvalidValue({}, '"' + name + '"',
                     names.empty() ? "none, as no collider has a mass" : "one of " + join(names));
}

void validate(const std::vector<ColliderSpec>& colliders) {
  if (colliders.size() > max_colliders) {
    throw InvalidValue({}, std::to_string(colliders.size()) + " items",
                       "at most " + std::to_string(max_colliders));
  }
  std::map<std::string, size_t> seen;
  for (size_t i = 0; i < colliders.size(); ++i) {
    inside(std::to_string(i), [&] {
      validate(colliders[i]);
      const auto [first, is_new] = seen.emplace(colliders[i].name, i);
      if (!is_new) {
        throw InvalidValue({"name"}, '"' + colliders[i].name + "\" again",
                           "a name other than that of item " + std::to_string(first->second));
      }
    });
  }
}

void check_parts(const std::vector<ColliderSpec>& colliders) {
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    if (colliders[i].part_of.empty()) continue;
    inside(std::to_string(i),
           [&] { inside("part_of", [&] { check_names_body(colliders[i].part_of, colliders); }); });
  }
}

/// Runs `check` with the key of an entry of ClothSpec::attached.
template <typename Check>
void inside_attached(const ClothSpec& cloth, std::size_t entry, const Check& check) {
  std::size_t part = cloth.parts.size(), first = 0;
  while (part > 0 && cloth.parts[part - 1].first_attached > entry) --part;
  if (part > 0) first = cloth.parts[part - 1].first_attached;
  const auto in_list = [&] {
    inside("attached", [&] { inside(std::to_string(entry - first), check); });
  };
  if (part == 0) return inside("cloth", in_list);
  inside("cloths", [&] { inside(std::to_string(part - 1), in_list); });
}

void check_attached(const Scene& scene) {
  const ClothSpec& cloth = scene.cloth;
  std::set<std::array<int, 2>> held;
  for (const Pin& pin : cloth.pinned) held.insert({pin.column, pin.row});
  for (std::size_t i = 0; i < cloth.attached.size(); ++i) {
    inside_attached(cloth, i, [&] {
      const BodyPoints& attached = cloth.attached[i];
      inside("body", [&] { check_names_body(attached.body, scene.colliders); });
      if (attached.tear_force) check_range("tear_force", *attached.tear_force, tear_force_range);
      if (attached.points.empty()) throw InvalidValue({"points"}, "none", "one or more");
      for (std::size_t k = 0; k < attached.points.size(); ++k) {
        inside("points", [&] {
          inside(std::to_string(k), [&] {
            const std::array<int, 2>& point = attached.points[k];
            check_grid_point(cloth, point[0], point[1]);
            if (held.insert(point).second) return;
            throw InvalidValue({}, point_text(cloth, point[0], point[1]),
                               "a point that is neither pinned nor attached");
          });
        });
      }
    });
  }
}

constexpr Range time_range{0, 1e6, "s"};
constexpr Range radius_range{0, 1e6, "m"};

void check_frame_name(const std::string& key, const std::string& frame) {
  inside(key, [&] {
    if (frame.empty()) throw InvalidValue({}, "nothing", "the name of a frame");
    check_frame(frame);
  });
}

void check_points(const std::vector<int>& points, const Scene& scene) {
  const int count = scene.cloth.columns * scene.cloth.rows;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] >= 0 && points[i] < count) continue;
    throw InvalidValue({"points", std::to_string(i)}, std::to_string(points[i]),
                       "a point of the cloth, from 0 to " + std::to_string(count - 1));
  }
}

void validate(const KeyFrame& key, const Scene&) {
  check_frame_name("frame", key.frame);
  check(key.target);
}

void validate(const KeyFrameFile& file, const Scene&) {
  if (file.file.empty()) throw InvalidValue({"file"}, "nothing", "a CSV or NPZ file");
  check_frame_name("frame", file.frame);
}

void validate(const AttachPoints& attach, const Scene& scene) {
  check_frame_name("attach", attach.frame);
  check_points(attach.points, scene);
  check_range("radius", attach.radius, radius_range);
  if (!attach.body.empty()) {
    inside("body", [&] { check_names_body(attach.body, scene.colliders); });
    if (attach.tear_force || attach.strength) {
      throw InvalidValue({attach.tear_force ? "tear_force" : "strength"}, "a force",
                         "none with a body");
    }
    if (attach.points.empty() && attach.radius == 0) return;
    throw InvalidValue({"body"}, attach.body + " and points", "one of the two");
  }
  if (attach.points.empty() == (attach.radius == 0)) {
    throw InvalidValue({"points"},
                       attach.points.empty() ? "none and no radius" : "points and a radius",
                       "one of the two");
  }
  if (attach.tear_force) check_range("tear_force", *attach.tear_force, tear_force_range);
  if (attach.strength) check_range("strength", *attach.strength, strength_range);
}

void validate(const DetachPoints& detach, const Scene& scene) {
  check_frame_name("detach", detach.frame);
  check_points(detach.points, scene);
}

void validate(const SwitchCollider& change, const Scene& scene) {
  std::vector<std::string> names;
  for (const ColliderSpec& collider : scene.colliders) {
    if (collider.name == change.collider) return;
    names.push_back(collider.name);
  }
  throw InvalidValue(
      {change.enabled ? "enable" : "disable"}, '"' + change.collider + '"',
      names.empty() ? "none, as the scene has no colliders" : "one of " + join(names));
}

void validate(const ChangeValues& values, const Scene& scene) {
  LiveSpec live = live_values(scene);
  inside("set", [&] {
    values.change(live);
    if (live.simulation.frames_per_second != scene.simulation.frames_per_second) {
      throw InvalidValue({"frames_per_second"}, to_text(live.simulation.frames_per_second),
                         "no change: the times of motions are counted in frames");
    }
    validate(live);
  });
}

void validate_motions(const Scene& scene) {
  for (std::size_t i = 0; i < scene.motions.size(); ++i) {
    inside(std::to_string(i), [&] {
      const MotionEntry& entry = scene.motions[i];
      check_range("time", entry.time, time_range);
      std::visit([&](const auto& action) { validate(action, scene); }, entry.action);
    });
  }
}

}  // namespace

LiveSpec live_values(const Scene& scene) {
  const ClothSpec& cloth = scene.cloth;
  LiveSpec live{cloth.material,
                cloth.thickness,
                cloth.self_collision,
                cloth.friction,
                {},
                scene.simulation,
                {}};
  for (const ClothPart& part : cloth.parts) {
    live.cloths.push_back({part.name, part.material, part.friction, part.thickness});
  }
  for (const ColliderSpec& collider : scene.colliders) {
    live.collider_friction[collider.name] = collider.friction;
  }
  return live;
}

void validate(const LiveSpec& live) {
  validate(live.material);
  validate_contact(live.thickness, live.friction);
  inside("cloths", [&] {
    for (const LiveSpec::OfCloth& cloth : live.cloths) {
      inside(cloth.name, [&] {
        validate(cloth.material);
        validate_contact(cloth.thickness, cloth.friction);
      });
    }
  });
  inside("collider_friction", [&] {
    for (const auto& [name, friction] : live.collider_friction) {
      check_range(name, friction, friction_range);
    }
  });
  validate(live.simulation);
}

void check_orientation(const Eigen::Quaterniond& orientation) {
  const double norm = orientation.norm();
  if (!(std::abs(norm - 1) < written_rounding)) {
    throw InvalidValue({"orientation"}, "a quaternion of norm " + to_text(norm), "norm 1");
  }
}

void check_place(const Vector3& position) { check_range("position", position, place_range); }

void check_place(const Pose& pose) {
  check_place(pose.position);
  check_orientation(pose.orientation);
}

void check(const FrameTarget& target) {
  check_place(target.pose);
  if (target.start) inside("start", [&] { check_place(*target.start); });
  if (!target.twist) return;
  inside("twist", [&] {
    check_range("linear", target.twist->linear, linear_range);
    check_range("angular", target.twist->angular, angular_range);
  });
}

void check_method(const std::string& method) {
  const std::vector<std::string> names = method_names();
  if (method == "auto" || std::find(names.begin(), names.end(), method) != names.end()) return;
  std::string known = "auto";
  for (const std::string& name : names) known += ", " + name;
  throw InvalidValue({"method"}, '"' + method + '"', "one of " + known);
}

void validate(const SimulationSpec& spec) {
  check_range("gravity", spec.gravity, gravity_range);
  if (spec.wind) check_range("wind", *spec.wind, wind_range);
  check_range("gusts", spec.gusts, gusts_range);
  check_range("frames_per_second", spec.frames_per_second, frames_per_second_range);
  if (spec.substeps && (*spec.substeps < 1 || *spec.substeps > max_substeps)) {
    throw InvalidValue({"substeps"}, std::to_string(*spec.substeps),
                       "auto or a whole number from 1 to " + std::to_string(max_substeps));
  }
  check_range("threads", spec.threads, threads_range);
  check_range("strain_tolerance", spec.strain_tolerance, strain_tolerance_range);
  check_range("tolerance", spec.tolerance, tolerance_range);
  check_method(spec.method);
  inside("method_parameters", [&] { validate(spec.method_parameters, spec.method); });
}

void validate(const Scene& scene) {
  const std::string cloth = scene.cloth.parts.empty() ? "cloth" : "cloths";
  inside(cloth, [&] { validate(scene.cloth); });
  inside("colliders", [&] {
    validate(scene.colliders);
    check_parts(scene.colliders);
  });
  if (scene.cloth.parts.size() + scene.colliders.size() > max_colliders + 1) {
    throw InvalidValue({cloth}, std::to_string(scene.cloth.parts.size()) + " cloths",
                       "at most " + std::to_string(max_colliders + 1 - scene.colliders.size()) +
                           ", with the colliders of the scene");
  }
  check_attached(scene);
  inside("simulation", [&] { validate(scene.simulation); });
  inside("motions", [&] { validate_motions(scene); });
}

}  // namespace clothsim
