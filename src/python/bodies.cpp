#include "bodies.h"

#include "bindings.h"
#include "clothsim/model/checks.h"
#include "frames.h"

namespace clothsim_python {
namespace {

using clothsim::InvalidValue;

/// The index of a body in the scene, which may not be the one that the body is from.
int index_of(const Run& run, const std::string& name) {
  if (const std::optional<int> index = run.simulator.body_named(name)) return *index;
  throw InvalidValue({"bodies"}, '"' + name + '"', "a body of the scene that was loaded");
}

}  // namespace

double Body::mass() const {
  return simulation_->with([&](Run& run) {
    const auto index = static_cast<std::size_t>(index_of(run, name_));
    return run.simulator.scene().colliders[index].body->mass;
  });
}

clothsim::BodyMotion Body::motion() const {
  return simulation_->with(
      [&](Run& run) { return run.simulator.body_motion(index_of(run, name_)); });
}

std::optional<std::string> Body::frame() const {
  return simulation_->with(
      [&](Run& run) { return run.simulator.frame_of_body(index_of(run, name_)); });
}

void Body::attach(const std::string& frame, const py::object& pose) const {
  check_frame_name(frame);
  simulation_->with([&](Run& run) {
    const int index = index_of(run, name_);
    const clothsim::Pose at =
        pose.is_none() ? pose_now(run, frame).value_or(run.simulator.collider_pose(index))
                       : to_pose(pose, "pose");
    run.simulator.attach_body(index, frame, at);
    place_frame(run, frame, at);
  });
}

void Body::detach() const {
  simulation_->with([&](Run& run) { run.simulator.detach_body(index_of(run, name_)); });
}

void Body::place(const py::object& pose, const py::object& velocity,
                 const py::object& angular_velocity) const {
  const clothsim::Pose at = to_pose(pose, "pose");
  const clothsim::Vector3 speed = to_vector(velocity, "velocity");
  const clothsim::Vector3 turning = to_vector(angular_velocity, "angular_velocity");
  clothsim::inside("pose", [&] { clothsim::check_place(at); });
  simulation_->with(
      [&](Run& run) { run.simulator.set_body(index_of(run, name_), at, speed, turning); });
}

py::dict bodies_of(const std::shared_ptr<Simulation>& simulation) {
  return simulation->with([&](Run& run) {
    py::dict bodies;
    int index = 0;
    for (const clothsim::ColliderSpec& collider : run.simulator.scene().colliders) {
      if (run.simulator.is_body(index)) {
        bodies[py::str(collider.name)] = Body(simulation, collider.name);
      }
      ++index;
    }
    return bodies;
  });
}

void bind_bodies(py::module_& module) {
  const py::tuple at_rest = py::make_tuple(0, 0, 0);
  py::class_<Body>(module, "Body",
                   "A rigid body, that is a collider with a mass: see Simulator.bodies. It shows "
                   "the present state, and keeps its simulator alive. After load() of a scene "
                   "without a body of its name it raises InvalidValue.")
      .def_property_readonly("name", &Body::name, "As the scene has it.")
      .def_property_readonly("mass", &Body::mass, "Its mass [kg], of the scene.")
      .def_property_readonly(
          "pose", [](const Body& self) { return to_array(self.motion().pose); },
          "Pose of its shape in the world, [x, y, z, qx, qy, qz, qw] [m, quaternion]. A copy, like "
          "the velocities.")
      .def_property_readonly(
          "velocity", [](const Body& self) { return to_array(self.motion().velocity); },
          "Of its centre of mass, [3] [m/s].")
      .def_property_readonly(
          "angular_velocity",
          [](const Body& self) { return to_array(self.motion().angular_velocity); },
          "[3] [rad/s], in the world.")
      .def_property_readonly("frame", &Body::frame, "The frame that holds it; None: none.")
      .def("attach", &Body::attach, py::arg("frame"), py::arg("pose") = py::none(),
           "Holds it with a frame, with its present offset in it, until detach() or reset(). "
           "`pose` is where the frame is; None: where it was left, or where the body is. Raises "
           "InvalidValue and changes nothing.")
      .def("detach", &Body::detach,
           "Lets it go, with its velocity of the last frame of simulation. Raises InvalidValue for "
           "a body that no frame holds.")
      .def("place", &Body::place, py::arg("pose"), py::arg("velocity") = at_rest,
           py::arg("angular_velocity") = at_rest,
           "Puts it at `pose` [x, y, z, qx, qy, qz, qw] or [x, y, z] [m] at once, with these "
           "velocities: of its centre of mass [m/s], and angular in the world [rad/s]. Cloth "
           "within it is pushed out gently. Raises InvalidValue and changes nothing: for numbers "
           "that are not finite, positions beyond 1e12 m, an orientation that is no unit "
           "quaternion, velocities beyond 1000 m/s or 1000 rad/s.");
}

}  // namespace clothsim_python
