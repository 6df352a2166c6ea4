#pragma once

#include <memory>
#include <string>

#include "simulation.h"

namespace clothsim_python {

/// clothsim.Cloth: one of several cloths in a simulator.
class Cloth {
 public:
  Cloth(std::shared_ptr<Simulation> simulation, std::string name)
      : simulation_(std::move(simulation)), name_(std::move(name)) {}

  const std::string& name() const { return name_; }

  /// As the scene has it; throws InvalidValue where a scene without this cloth has been loaded.
  clothsim::ClothPart part() const;

  /// The rows of its points in an array of the state, N x 3.
  py::object rows_of(clothsim::Points clothsim::State::*all) const;

 private:
  std::shared_ptr<Simulation> simulation_;
  std::string name_;
};

/// A dict of the scene's cloths by name, in its order; empty where it has one.
py::dict cloths_of(const std::shared_ptr<Simulation>&);

}  // namespace clothsim_python
