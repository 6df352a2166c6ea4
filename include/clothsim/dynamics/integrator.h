#pragma once

#include <string>
#include <variant>
#include <vector>

#include "clothsim/dynamics/bdf2.h"
#include "clothsim/dynamics/implicit_euler.h"
#include "clothsim/dynamics/rk4.h"
#include "clothsim/dynamics/symplectic_euler.h"
#include "clothsim/dynamics/verlet.h"
#include "clothsim/dynamics/xpbd.h"

namespace clothsim {

/// The closed list of methods. Names, parameters, error messages and tests derive from it. Each
/// alternative has
/// - `name`, `order`, `stability_limit` (largest h omega_max, infinity where there is none);
/// - `displacement_factor(damping, h)`, the share of h by which an impulse p given in the step
///   displaces a point whose velocity at the end it changes by p / m: such that a force and the
///   impulse that undoes it leave no displacement behind, drag included;
/// - `step(const Cloth&, const Loads&, double h, State&, const Workers&)`, to the same bits with
///   any number of threads; Newton's method uses one;
/// - `unconverged()`, whether the last step stopped iterating before it met its own tolerance;
/// - `Parameters`, a struct of double, int and enumerations with defaults, whose
///   `each(parameters, visit)` calls `visit(const char* key, value, const Range&)` for each, and
///   a constructor that takes it.
using Integrator =
    std::variant<VelocityVerlet, SymplecticEuler, RungeKutta4, ImplicitEuler, Bdf2, Xpbd>;

template <typename Methods>
struct ParametersOf;
template <typename... Methods>
struct ParametersOf<std::variant<Methods...>> {
  using Type = std::variant<std::monostate, typename Methods::Parameters...>;
};

/// The parameters of one method of the list; none: its defaults.
using MethodParameters = ParametersOf<Integrator>::Type;

/// The names of all methods, in the order of the list.
std::vector<std::string> method_names();

/// The parameters of the method called `name` at their defaults; none for any other name.
MethodParameters default_parameters(const std::string& name);

/// Throws InvalidValue, with the key relative to the parameters, where a value is out of range or
/// the parameters are not those of the method called `name`.
void validate(const MethodParameters&, const std::string& name);

/// Whether both are of one method and have equal values.
bool same(const MethodParameters&, const MethodParameters&);

/// The method called `name`, which must be one of method_names(), with its valid parameters.
Integrator make_integrator(const std::string& name, const MethodParameters& parameters = {});

}  // namespace clothsim
