#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "clothsim/model/cloth.h"

namespace clothsim {

/// The points, or the edges, that a cell owns: a short list in place.
template <std::size_t most>
class CellFeatures {
 public:
  void push_back(int feature) { features_[size_++] = feature; }
  std::size_t size() const { return size_; }
  int operator[](std::size_t i) const { return features_[i]; }
  const int* begin() const { return features_.data(); }
  const int* end() const { return features_.data() + size_; }

 private:
  std::array<int, most> features_{};
  std::size_t size_ = 0;
};

/// Points, edges and triangles of a cloth, and which cell of the grid has them. A cell is the
/// square between four points, counted along rows; its two triangles are 2 * cell and 2 * cell + 1.
/// Needs two columns and two rows at least.
struct SurfaceMesh {
  explicit SurfaceMesh(const Cloth&);

  int cell_columns;
  int cell_rows;
  std::vector<std::array<int, 3>> triangles;  // points
  std::vector<std::array<int, 2>> edges;      // points, ascending; each edge once

  // Each point and edge belongs to one cell and one triangle of those that have it.
  std::vector<CellFeatures<4>> cell_points;
  std::vector<CellFeatures<5>> cell_edges;
  std::vector<int> triangle_of_point;
  std::vector<std::array<int, 3>> triangle_of_edge;  // by triangle and corner opposite the edge

  int num_cells() const { return cell_columns * cell_rows; }
};

}  // namespace clothsim
