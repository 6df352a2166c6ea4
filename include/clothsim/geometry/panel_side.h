#pragma once

#include <Eigen/Core>
#include <string>
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

/// z of the cross product [m^2].
inline double cross(const PlanePoint& a, const PlanePoint& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A point in a message: [x, y].
std::string place_text(const PlanePoint&);

}  // namespace clothsim
