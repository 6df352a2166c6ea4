#pragma once

#include "clothsim/model/cloth.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Unit normals of a mesh at its points, N x 3: the mean of the triangles' normals weighted by
/// area, so that sliver triangles count little. Where they cancel, as on a sharp fold, the normal
/// of the largest triangle; where no triangle has an area, +z. Always finite.
Points vertex_normals(const Points& positions, const std::vector<std::array<int, 3>>& triangles);

/// Unit tangents along growing u, perpendicular to `normals`, N x 3; arbitrary where u has no
/// direction. Always finite.
Points vertex_tangents(const Points& positions, const Eigen::Matrix<double, Eigen::Dynamic, 2>& uv,
                       const std::vector<std::array<int, 3>>& triangles, const Points& normals);

/// Length of the longest edge [m].
double longest_edge(const Points& positions, const std::vector<std::array<int, 3>>& triangles);

}  // namespace clothsim
