#pragma once

#include <array>
#include <vector>

#include "clothsim/geometry/panel_side.h"

namespace clothsim {

/// The triangles of a panel, anticlockwise. The outline's points come first.
struct PanelMesh {
  std::vector<PlanePoint> points;
  std::vector<std::array<int, 3>> triangles;
};

/// Fills an outline, closed and in either direction, with triangles whose edges are about `cell`
/// [m] long: a hexagonal lattice, moved to the middle of its neighbours a few times, and Delaunay's
/// triangles. No edge but the outline's joins two of its points that are `sewn`: where two panels
/// have a seam, that edge would be one of both. Throws InvalidValue, without a key, for an outline
/// that crosses itself or has sides far shorter than the cell.
PanelMesh fill_panel(std::vector<PlanePoint> outline, double cell, std::vector<bool> sewn = {});

}  // namespace clothsim
