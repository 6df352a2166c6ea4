#pragma once

#include <string>
#include <vector>

#include "clothsim/render/image.h"

namespace clothsim {

/// A picture with a short label; empty: no label.
struct Tile {
  Image image;
  std::string label;
};

/// Tiles of one size side by side, `columns` to a row, each label in its upper left corner.
Image contact_sheet(const std::vector<Tile>& tiles, int columns);

}  // namespace clothsim
