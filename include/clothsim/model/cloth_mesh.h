#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// The surface of a cloth of any shape: open or closed, with holes, in one piece or several.
struct ClothMesh {
  using Flat = Eigen::Vector2d;  // material coordinates: along warp, along weft [m]

  Points positions;                             // at the start [m], N x 3
  std::vector<std::array<int, 3>> triangles;    // counter-clockwise seen from the front
  std::vector<std::array<Flat, 3>> flat;        // corners of each triangle at rest
  Eigen::Matrix<double, Eigen::Dynamic, 2> uv;  // texture coordinates, N x 2
  std::vector<char> curved;  // by triangle: its curvature at rest is that at the start; empty: none

  bool is_curved(int triangle) const {
    return !curved.empty() && curved[static_cast<std::size_t>(triangle)] != 0;
  }
};

/// Points of a mesh by the names of a sewing pattern, PANEL.NUMBER.
struct PatternPoints {
  std::map<std::string, int> corners;
  std::map<std::string, std::vector<int>> sides;  // from corner to corner
};

/// An edge of a mesh.
struct MeshEdge {
  std::array<int, 2> points;     // ascending
  std::array<int, 2> triangles;  // the second is -1 at the border
};

/// The edges of a mesh by their points, ascending. Throws InvalidValue, without a key, for an edge
/// of three triangles.
std::vector<MeshEdge> mesh_edges(const std::vector<std::array<int, 3>>& triangles);

}  // namespace clothsim
