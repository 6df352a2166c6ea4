#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace clothsim {

/// Delaunay's triangles of different points in the plane, anticlockwise; of four or more points on
/// one circle, any. From Boost's Voronoi diagram, which is exact for whole numbers: places are
/// rounded to 1e-9 of the points' extent.
std::vector<std::array<int, 3>> delaunay_triangles(const std::vector<Eigen::Vector2d>& points);

}  // namespace clothsim
