#pragma once

#include <vector>

#include "clothsim/scene/yaml_values.h"
#include "clothsim/shapes/collider.h"

namespace clothsim {

/// The further keys of a collider with a mass.
std::vector<Field> body_fields(BodySpec&);

/// Throws InvalidValue, with keys relative to the collider, unless it can be a rigid body.
void check_body(const ColliderSpec&);

}  // namespace clothsim
