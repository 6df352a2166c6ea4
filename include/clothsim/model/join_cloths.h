#pragma once

#include <string>
#include <vector>

#include "clothsim/model/cloth_spec.h"

namespace clothsim {

struct NamedCloth {
  std::string name;
  ClothSpec spec;
};

/// Several cloths as one: their points and triangles one after the other, in the order of the list,
/// as a mesh with ClothSpec::parts. A grid becomes two triangles a cell, with its threads along the
/// grid. Pins and points on bodies go with their cloth; a cloth's pin_strength is that of its pins.
///
/// Throws InvalidValue, with keys such as {"1", "untangle"}: no cloth, a name that is empty or
/// taken, a cloth without a fabric or without an area, and a value that all cloths share and that
/// is not that of the first: self_collision, untangle.
ClothSpec join_cloths(const std::vector<NamedCloth>& cloths);

}  // namespace clothsim
