#include "clothsim/dynamics/integrator.h"

#include <algorithm>
#include <cassert>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

constexpr std::size_t num_methods = std::variant_size_v<Integrator>;

template <std::size_t I>
using Method = std::variant_alternative_t<I, Integrator>;

template <std::size_t I = 0>
void append_names(std::vector<std::string>& names) {
  if constexpr (I < num_methods) {
    names.emplace_back(Method<I>::name);
    append_names<I + 1>(names);
  }
}

/// Place in the list, or its length where the method does not exist.
std::size_t index_of(const std::string& name) {
  const std::vector<std::string> names = method_names();
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

template <std::size_t I = 0>
MethodParameters default_parameters_at(std::size_t index) {
  if constexpr (I < num_methods) {
    if (index == I) return typename Method<I>::Parameters();
    return default_parameters_at<I + 1>(index);
  } else {
    return {};
  }
}

template <std::size_t I = 0>
Integrator make_at(std::size_t index, const MethodParameters& parameters) {
  if constexpr (I + 1 < num_methods) {
    if (index != I) return make_at<I + 1>(index, parameters);
  }
  return Method<I>(std::get<typename Method<I>::Parameters>(parameters));
}

/// Calls visit(key, value, range) for each parameter.
template <typename Visit>
void for_each_parameter(const MethodParameters& parameters, Visit&& visit) {
  std::visit(
      [&](const auto& p) {
        using P = std::decay_t<decltype(p)>;
        if constexpr (!std::is_same_v<P, std::monostate>) P::each(p, visit);
      },
      parameters);
}

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  append_names(names);
  return names;
}

MethodParameters default_parameters(const std::string& name) {
  return default_parameters_at(index_of(name));
}

void validate(const MethodParameters& parameters, const std::string& name) {
  if (parameters.index() == 0) return;
  const std::size_t index = parameters.index() - 1;
  if (index != index_of(name)) {
    throw InvalidValue({}, "parameters of " + method_names()[index],
                       "those of method " + name + ", or none");
  }
  for_each_parameter(parameters, [](const char* key, const auto& value, const Range& range) {
    check_range(key, value, range);
  });
}

bool same(const MethodParameters& a, const MethodParameters& b) {
  if (a.index() != b.index()) return false;
  const auto values = [](const MethodParameters& parameters) {
    std::vector<double> list;
    for_each_parameter(parameters, [&](const char*, const auto& value, const Range&) {
      list.push_back(static_cast<double>(value));
    });
    return list;
  };
  return values(a) == values(b);
}

Integrator make_integrator(const std::string& name, const MethodParameters& parameters) {
  const std::size_t index = index_of(name);
  assert(index < num_methods);
  return make_at(index, parameters.index() == 0 ? default_parameters(name) : parameters);
}

}  // namespace clothsim
