#pragma once

#include <Eigen/Core>
#include <vector>

namespace clothsim {

/// A point near an edge of a mesh, laid into the plane of the edge's triangles: x along the edge,
/// which reaches from (-1/2, 0) to (1/2, 0), and y across it, both in lengths of the edge.
struct PointAtEdge {
  int point;  // of the cloth
  Eigen::Vector2d place;
};

/// A share of a point's height in a slope.
struct PointShare {
  int point;
  double share;
};

/// Coefficients of the slope d/dy in the middle of an edge for the heights of points, in lengths of
/// the edge. The first four points are the edge's ends and those across: the one with y < 0, then
/// the other one.
///
/// With those four alone the slope is a mean of both triangles', each by the height of the other
/// triangle, so that a kink is the same moment in both. It is exact for quadratic functions where
/// the triangles mirror each other. Elsewhere the smallest coefficients of all points that make it
/// so are added: no larger than the mean's own, and only where the points determine them.
std::vector<PointShare> slope_across(const std::vector<PointAtEdge>& points);

}  // namespace clothsim
