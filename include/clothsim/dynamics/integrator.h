#pragma once

#include <string>
#include <variant>
#include <vector>

#include "clothsim/dynamics/verlet.h"

namespace clothsim {

/// The closed list of methods. Names, error messages and tests derive from it. Each alternative has
/// `name`, `order`, `stability_limit` (largest h omega_max), `reach` (the share of h that a point
/// moves with an impulse given in the step) and `step(const Cloth&, const Loads&, double h,
/// State&)`.
using Integrator = std::variant<VelocityVerlet>;

/// The names of all methods, in the order of the list.
std::vector<std::string> method_names();

/// The method called `name`, which must be one of method_names().
Integrator make_integrator(const std::string& name);

}  // namespace clothsim
