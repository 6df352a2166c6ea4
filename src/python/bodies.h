#pragma once

#include <memory>
#include <optional>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// clothsim.Body: a rigid body in a simulator.
class Body {
 public:
  Body(std::shared_ptr<Simulation> simulation, std::string name)
      : simulation_(std::move(simulation)), name_(std::move(name)) {}

  const std::string& name() const { return name_; }
  double mass() const;  // [kg]
  clothsim::BodyMotion motion() const;

  /// Puts it at a pose at once, with a velocity of its centre of mass and an angular velocity.
  void place(const py::object& pose, const py::object& velocity,
             const py::object& angular_velocity) const;

  /// The frame that holds it.
  std::optional<std::string> frame() const;
  /// Holds it with a frame: at `pose`, or if that is None where it was left, or else at the body.
  void attach(const std::string& frame, const py::object& pose) const;
  void detach() const;

 private:
  std::shared_ptr<Simulation> simulation_;
  std::string name_;
};

/// The rigid bodies of the scene, by name, in its order.
py::dict bodies_of(const std::shared_ptr<Simulation>&);

}  // namespace clothsim_python
