#pragma once

#include <yaml-cpp/yaml.h>

#include "clothsim/view/view.h"

namespace clothsim {

/// The only reader of views; docs/rendering.md lists the keys. What is left out keeps its default.
/// Throws InvalidValue for an unknown key, a wrong type, a number out of range; prepare() then
/// refuses images that cannot be read.
View read_view(const YAML::Node& root);

/// Throws InvalidValue for a number out of range.
void validate(const View&);

}  // namespace clothsim
