#include <algorithm>

#include "bindings.h"
#include "bodies.h"
#include "clothsim/model/checks.h"
#include "clothsim/scene/points_yaml.h"
#include "clothsim/simulation/grips.h"
#include "errors.h"
#include "frames.h"
#include "robots.h"
#include "yaml_objects.h"

namespace clothsim_python {

void check_frame_name(const std::string& frame) {
  clothsim::check_frame(frame);
  if (frame.empty()) throw clothsim::InvalidValue({"frame"}, "\"\"", "the name of a frame");
}

void place_frame(Run& run, const std::string& frame, const clothsim::Pose& pose) {
  run.frames.set_targets({{frame, {pose, {}, pose}}}, 1, run.simulator);
}

std::optional<clothsim::Pose> pose_now(const Run& run, const std::string& frame) {
  if (const clothsim::Pose* driven = run.frames.pose(frame)) return *driven;
  return clothsim::followed_pose(frame, run.simulator);
}

namespace {

using clothsim::InvalidValue;

void place_at_once(Simulation& simulation, const std::string& frame, const py::object& pose) {
  check_frame_name(frame);
  const clothsim::Pose at = to_pose(pose, "pose");
  simulation.with([&](Run& run) { place_frame(run, frame, at); });
}

constexpr const char* points_form = "a list of numbers, [column, row] or places";

/// The items of an array of numpy or of something else that is no map and no text.
py::list items(const py::object& given) {
  const py::object object =
      py::hasattr(given, "tolist") ? py::object(given.attr("tolist")()) : given;
  const bool is_iterable = py::isinstance<py::iterable>(object) &&
                           !py::isinstance<py::dict>(object) && !py::isinstance<py::str>(object) &&
                           !py::isinstance<py::bytes>(object);
  if (!is_iterable) throw InvalidValue({"points"}, describe(given), points_form);
  return py::list(object);
}

/// The points of a list of numbers, or of numbers, [column, row] and places as in a scene; those of
/// the cloth of that name, if one is given.
std::vector<int> points_named(const Run& run, const py::object& points,
                              const std::optional<std::string>& cloth) {
  const py::list all = items(points);
  const bool has_places = std::any_of(all.begin(), all.end(), [](py::handle item) {
    return py::isinstance<py::dict>(item) || py::isinstance<py::list>(item) ||
           py::isinstance<py::tuple>(item) || (py::hasattr(item, "ndim") && py::len_hint(item) > 0);
  });
  if (!cloth && !has_places) return to_indices(all, "points");
  clothsim::PointReaders readers(run.simulator.scene().cloth, &run.simulator.cloth());
  clothsim::PointReader& reader = cloth ? readers.of(*cloth) : readers.all();
  std::vector<int> found;
  clothsim::inside("points", [&] { found = clothsim::read_points(to_yaml(all), reader); });
  return found;
}

/// The points to attach: the given ones, or the free ones within the radius.
std::vector<int> chosen(const Run& run, const clothsim::Pose& pose, const py::object& points,
                        std::optional<double> radius, const std::optional<std::string>& cloth) {
  if (points.is_none() == !radius) {
    throw InvalidValue({"points"}, radius ? "points and a radius" : "nothing",
                       "points or a radius, one of the two");
  }
  if (!radius) return points_named(run, points, cloth);
  if (cloth) throw InvalidValue({"cloth"}, '"' + *cloth + '"', "none without points");
  return run.simulator.free_points_near(pose.position, *radius);
}

std::vector<int> attach(Simulation& simulation, const std::string& frame, const py::object& pose,
                        const py::object& points, std::optional<double> radius,
                        std::optional<double> tear_force, std::optional<double> strength,
                        const std::optional<std::string>& cloth) {
  check_frame_name(frame);
  return simulation.with([&](Run& run) {
    if (!pose.is_none()) check_no_body(frame, run.simulator);
    const std::optional<clothsim::Pose> now = pose_now(run, frame);
    if (pose.is_none() && !now) {
      throw InvalidValue({"pose"}, "nothing", "where frame \"" + frame + "\" is");
    }
    const clothsim::Pose at = pose.is_none() ? *now : to_pose(pose, "pose");
    const std::vector<int> held = chosen(run, at, points, radius, cloth);
    run.simulator.attach(frame, at, held, {tear_force, strength});
    if (!pose.is_none()) place_frame(run, frame, at);
    return held;
  });
}

std::vector<int> held_by(const clothsim::Grip& grip) {
  std::vector<int> points;
  for (const clothsim::Grip::Held& held : grip.held) points.push_back(held.point);
  std::sort(points.begin(), points.end());
  return points;
}

void detach(Simulation& simulation, const std::optional<std::string>& frame,
            const py::object& points, const std::optional<std::string>& cloth) {
  simulation.with([&](Run& run) {
    std::vector<int> free;
    if (!points.is_none()) free = points_named(run, points, cloth);
    if (points.is_none() && cloth) {
      throw InvalidValue({"cloth"}, '"' + *cloth + '"', "none without points");
    }
    const auto& grips = run.simulator.grips();
    if (frame && (grips.count(*frame) == 0 || grips.at(*frame).held.empty())) {
      throw InvalidValue({"frame"}, '"' + *frame + '"', "a frame that points are attached to");
    }
    for (const auto& [name, grip] : grips) {
      const bool is_meant = frame ? *frame == name : points.is_none() && !grip.on_body;
      if (!is_meant) continue;
      for (const int point : held_by(grip)) free.push_back(point);
    }
    run.simulator.detach(free);
  });
}

py::dict grips(Simulation& simulation) {
  return simulation.with([](Run& run) {
    py::dict all;
    for (const auto& [frame, grip] : run.simulator.grips()) {
      const std::vector<int> points = held_by(grip);
      all[py::str(frame)] =
          py::dict(py::arg("pose") = to_array(grip.pose), py::arg("points") = points,
                   py::arg("force") = to_array(grip.wrench.force),
                   py::arg("torque") = to_array(grip.wrench.torque), py::arg("lag") = grip.lag);
    }
    return all;
  });
}

py::list holders(Simulation& simulation) {
  return simulation.with([](Run& run) {
    py::list all;
    for (const clothsim::HolderReport& holder : run.simulator.holders()) {
      all.append(py::dict(py::arg("name") = holder.name, py::arg("strength") = holder.strength,
                          py::arg("force") = holder.force, py::arg("lag") = holder.lag));
    }
    return all;
  });
}

int collider_index(const Run& run, const std::string& name) {
  std::vector<std::string> names;
  for (const clothsim::ColliderSpec& collider : run.simulator.scene().colliders) {
    if (collider.name == name) return static_cast<int>(names.size());
    names.push_back(collider.name);
  }
  throw InvalidValue({"name"}, '"' + name + '"',
                     names.empty() ? "a collider, of which the scene has none"
                                   : "one of " + clothsim::join(names));
}

void enable_collider(Simulation& simulation, const std::string& name, bool enabled) {
  simulation.with(
      [&](Run& run) { run.simulator.enable_collider(collider_index(run, name), enabled); });
}

py::dict colliders(Simulation& simulation) {
  return simulation.with([](Run& run) {
    py::dict all;
    int index = 0;
    for (const clothsim::ColliderSpec& collider : run.simulator.scene().colliders) {
      all[py::str(collider.name)] =
          py::dict(py::arg("pose") = to_array(run.simulator.collider_pose(index)),
                   py::arg("enabled") = run.simulator.collider_enabled(index),
                   py::arg("frame") = collider.frame);
      ++index;
    }
    return all;
  });
}

}  // namespace

void bind_frames(SimulationClass& simulator) {
  simulator
      .def("place_frame", &place_at_once, py::arg("frame"), py::arg("pose"),
           "Puts a frame at `pose` [x, y, z, qx, qy, qz, qw] or [x, y, z] [m] at once, with the "
           "colliders that follow it; makes a new one known. Raises InvalidValue.")
      .def(
          "attach", &attach, py::arg("frame"), py::arg("pose") = py::none(),
          py::arg("points") = py::none(), py::arg("radius") = py::none(),
          py::arg("tear_force") = py::none(), py::arg("strength") = py::none(),
          py::arg("cloth") = py::none(),
          "Fixes points of the cloth to a frame, or to the body of that name, which feels their "
          "pull: the `points` given, or all free ones within `radius` [m] of it. `points` are "
          "numbers, or as in a scene: [column, row], {'near': [x, y, z]}, {'within': r, 'of': [x, "
          "y, z]}, {'uv': [u, v]}, {'corner': name}, {'side': name}, by their places at the start; "
          "with `cloth` of the cloth of that name alone. `pose` is where "
          "the frame is; None: where it was left. Beyond "
          "`tear_force` [N] it lets go. It pulls with `strength` [N] at most: beyond, its points "
          "lag behind their places; None: ten weights of the cloth, of several those it holds, "
          "plus the force that stretches "
          "the points' springs to their limit. Returns the points. Raises InvalidValue and changes "
          "nothing.")
      .def("detach", &detach, py::arg("frame") = py::none(), py::arg("points") = py::none(),
           py::arg("cloth") = py::none(),
           "Lets go the points of a frame or body, or `points`, named as for attach(); all of "
           "frames where neither is given. Raises InvalidValue for points that are not attached.")
      .def_property_readonly(
          "grips", &grips,
          "Attached points, by frame: {'pose': [7], 'points': list, 'force': [3] [N], 'torque': "
          "[3] [N m] about the frame's origin, 'lag': [m] of the point that is farthest behind its "
          "place}, in the world: the mean load of the cloth on the frame in the last frame of "
          "simulation.")
      .def_property_readonly(
          "holders", &holders,
          "All that hold points, pins and then grips: a list of {'name': of the frame or 'pin "
          "[column, row]', 'strength': [N] that it can pull with, 'force': [N] that it pulls with, "
          "the mean of the last frame, 'lag': [m] behind its place}.")
      .def("enable_collider", &enable_collider, py::arg("name"), py::arg("enabled") = true,
           "Turns a collider on or off. Turned on within the cloth, it pushes that out gently. "
           "Raises InvalidValue.")
      .def_property_readonly(
          "colliders", &colliders,
          "By name: {'pose': [7] [m, quaternion], 'enabled': bool, 'frame': str}.")
      .def_property_readonly("bodies", &bodies_of,
                             "The Body objects of the scene's rigid bodies, that is of its "
                             "colliders with a mass, by name, in its order.")
      .def_property_readonly("robots", &robots_of,
                             "The Robot objects of the scene's `robots`, by name. Of two with one "
                             "name the second is called NAME/PREFIX.");
}

}  // namespace clothsim_python
