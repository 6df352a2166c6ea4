#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

#include "clothsim/view/view.h"

namespace clothsim {

/// The only reader of views; docs/rendering.md lists the keys. Missing keys keep their defaults.
/// Throws InvalidValue for an unknown key, a wrong type, a number out of range; prepare() refuses
/// images that cannot be read.
View read_view(const YAML::Node& root);

struct NamedView {
  std::string name;
  View view;
};

/// Reads one of several cameras: `name`, and the keys of a view that place a camera. Light,
/// background and the looks of cloth and colliders are those of `looks`. Throws as read_view()
/// does.
NamedView read_camera(const YAML::Node& root, const View& looks);

/// Throws InvalidValue for a number out of range.
void validate(const View&);

}  // namespace clothsim
