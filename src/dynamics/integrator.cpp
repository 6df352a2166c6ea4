#include "clothsim/dynamics/integrator.h"

#include <cassert>

namespace clothsim {
namespace {

template <std::size_t I = 0>
void append_names(std::vector<std::string>& names) {
  if constexpr (I < std::variant_size_v<Integrator>) {
    names.emplace_back(std::variant_alternative_t<I, Integrator>::name);
    append_names<I + 1>(names);
  }
}

template <std::size_t I = 0>
Integrator make_at(std::size_t index) {
  if constexpr (I + 1 < std::variant_size_v<Integrator>) {
    if (index != I) return make_at<I + 1>(index);
  }
  return Integrator(std::in_place_index<I>);
}

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  append_names(names);
  return names;
}

Integrator make_integrator(const std::string& name) {
  const std::vector<std::string> names = method_names();
  std::size_t index = 0;
  while (index < names.size() && names[index] != name) ++index;
  assert(index < names.size());
  return make_at(index);
}

}  // namespace clothsim
