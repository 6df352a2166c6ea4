#include "robots.h"

#include <algorithm>

#include "bindings.h"
#include "clothsim/model/checks.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;
using clothsim::JointValues;

const clothsim::RobotModel& model_of(Run& run, const std::string& name) {
  const auto& models = run.robots();
  const auto model = models.find(name);
  if (model != models.end()) return model->second;
  throw InvalidValue({"robots"}, '"' + name + '"', "a robot of the scene that was loaded");
}

/// The last values, replaced by `given` ones, and checked.
JointValues with(const JointValues& given, const clothsim::RobotModel& model,
                 const JointValues& last) {
  clothsim::inside("joints", [&] { model.kinematics.check(given); });
  JointValues values = given;
  values.insert(last.begin(), last.end());
  return values;
}

/// Calls visit(frame, pose) for each link of a robot with these joint values.
template <class Visit>
void for_each_frame(const clothsim::RobotModel& model, const JointValues& values, Visit&& visit) {
  for (const auto& [link, pose] : model.kinematics.poses(values)) {
    clothsim::Pose at = model.pose * pose;
    at.orientation.normalize();
    visit(model.prefix + link, at);
  }
}

}  // namespace

py::dict Robot::joints() const {
  return simulation_->with([&](Run& run) {
    const JointValues& values = run.joints[name_];
    py::dict all;
    for (const auto& [name, limit] : model_of(run, name_).kinematics.joints()) {
      const auto value = values.find(name);
      all[py::str(name)] =
          py::dict(py::arg("position") = value == values.end() ? 0 : value->second,
                   py::arg("lower") = limit ? py::object(py::float_(limit->min)) : py::none(),
                   py::arg("upper") = limit ? py::object(py::float_(limit->max)) : py::none());
    }
    return all;
  });
}

void Robot::set_joints(const JointValues& given) const {
  simulation_->with([&](Run& run) {
    const clothsim::RobotModel& model = model_of(run, name_);
    const JointValues values = with(given, model, run.joints[name_]);
    Targets targets;
    for_each_frame(model, values, [&](const std::string& frame, const clothsim::Pose& pose) {
      targets.emplace(frame, clothsim::FrameTarget{pose, {}, pose});
    });
    run.frames.set_targets(targets, 1, run.simulator);
    run.joints[name_] = values;
  });
}

py::dict Robot::targets(const JointValues& given) const {
  return simulation_->with([&](Run& run) {
    const clothsim::RobotModel& model = model_of(run, name_);
    const JointValues values = with(given, model, run.joints[name_]);
    const std::vector<std::string> followed = clothsim::followed_frames(run.simulator);
    py::dict poses;
    for_each_frame(model, values, [&](const std::string& frame, const clothsim::Pose& pose) {
      const bool is_known = run.frames.pose(frame) != nullptr ||
                            std::find(followed.begin(), followed.end(), frame) != followed.end();
      if (is_known) poses[py::str(frame)] = to_array(pose);
    });
    run.joints[name_] = values;
    return poses;
  });
}

std::map<std::string, Robot> robots_of(const std::shared_ptr<Simulation>& simulation) {
  return simulation->with([&](Run& run) {
    std::map<std::string, Robot> robots;
    for (const auto& [name, model] : run.robots()) robots.emplace(name, Robot(simulation, name));
    return robots;
  });
}

void bind_robots(py::module_& module) {
  py::class_<Robot>(module, "Robot", "The joints of one of a scene's robots: see Simulator.robots.")
      .def_property_readonly("name", &Robot::name, "As Simulator.robots has it.")
      .def_property_readonly(
          "joints", &Robot::joints,
          "Those that can be set, by name: {'position': last told [rad or m], 'lower', 'upper': "
          "its limits, None for a continuous one}. At the scene's start all are at 0.")
      .def("set_joints", &Robot::set_joints, py::arg("positions"),
           "Puts the robot at once to these `positions` [rad or m], a dict by joint: the frames of "
           "all its links, with the colliders and points that follow them. Joints that are not "
           "named stay, those that mimic follow. Raises InvalidValue and changes nothing, also "
           "beyond limits.")
      .def("targets", &Robot::targets, py::arg("positions"),
           "Where the frames of its links are for such `positions`, to go there: "
           "step(frames, robot.targets(positions)). Each link goes straight there, so give small "
           "steps. Raises InvalidValue.");
}

}  // namespace clothsim_python
