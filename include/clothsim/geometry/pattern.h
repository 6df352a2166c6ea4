#pragma once

#include <map>
#include <string>
#include <vector>

#include "clothsim/geometry/cloth_surface.h"
#include "clothsim/geometry/panel.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// A flat piece of fabric: side k of its outline goes from corner k to the next.
struct Panel {
  std::string name;
  std::vector<PanelSide> sides;  // each begins where the one before it ends [m]
  PlanePoint warp{1, 0};         // direction of the warp threads
  Vector3 origin{0, 0, 0};       // of the panel's plane at the start [m]
  Eigen::Quaterniond turn{1, 0, 0, 0};
};

/// A side of a panel.
struct SideName {
  std::size_t panel;
  std::size_t side;
};

/// A sewing pattern: panels, and pairs of sides that are sewn.
struct Pattern {
  double cell = 0.02;  // [m] length of edges
  std::vector<Panel> panels;
  std::vector<std::array<SideName, 2>> seams;
};

/// Triangles of a pattern at the start, with texture coordinates by the threads of each panel [m].
struct SewnPattern {
  MeshTriangles mesh;
  std::vector<std::vector<std::vector<Vector3>>> sides;  // places of points by panel and side [m]
};

/// Fills the panels, see fill_panel(). Both sides of a seam get as many points, and each pair of
/// these starts halfway between its places on both panels; the ends that are nearer at the start
/// meet. Throws InvalidValue, with keys such as {"panels", "0"} and {"seams", "1"}: an outline that
/// cannot be filled, and a seam whose sides differ in length by more than half of the longer.
SewnPattern sew(const Pattern&);

}  // namespace clothsim
