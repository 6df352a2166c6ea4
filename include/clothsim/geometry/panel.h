#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace clothsim {

using PlanePoint = Eigen::Vector2d;  // [m]

/// A side of a panel, from one corner to the next: a polyline, fine enough to be taken for a curve.
using PanelSide = std::vector<PlanePoint>;

/// A straight side; an arc of a circle through a point beside it; a smooth curve through points,
/// Catmull and Rom's. Throws InvalidValue, without a key, for an arc through a point on the line.
PanelSide straight_side(const PlanePoint& from, const PlanePoint& to);
PanelSide arc_side(const PlanePoint& from, const PlanePoint& through, const PlanePoint& to);
PanelSide curved_side(const PlanePoint& from, const std::vector<PlanePoint>& through,
                      const PlanePoint& to);

double length_of(const PanelSide&);

/// `count` + 1 points along a side, evenly by length, its ends among them.
std::vector<PlanePoint> points_along(const PanelSide&, int count);

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
