#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// `count` of a mesh's points or triangles, from the `first` one on.
struct IndexRange {
  int first;
  int count;
};

/// A mesh in the memory of the GPU, with separate buffers for constant attributes (texture
/// coordinates, triangles, lines) and moving ones (positions, normals, tangents). Shaders also have
/// the previous surface: the present one, unless keep_surface() was called.
class GpuMesh {
 public:
  GpuMesh();

  void upload_topology(const Eigen::Matrix<double, Eigen::Dynamic, 2>& uv,
                       const std::vector<std::array<int, 3>>& triangles,
                       const std::vector<std::array<int, 2>>& lines);

  /// Makes the present surface the previous one of the next upload_surface(), which has as many
  /// points.
  void keep_surface();

  /// Makes the present surface the previous one.
  void stand_still();

  /// Uploads N points. `tangents` may be empty.
  void upload_surface(const Points& positions, const Points& normals, const Points& tangents);

  void draw_triangles() const;

  void draw_triangles(const IndexRange&) const;

  /// Draws triangles of index buffer `indices`.
  void draw_triangles(const Buffer& indices, const IndexRange&) const;

  /// Draws `count` lines, starting at line `first`.
  void draw_lines(int first, int count) const;

 private:
  VertexArray array_;
  Buffer uv_, surface_, before_, triangles_, lines_;
  int num_triangles_ = 0;
  std::vector<float> scratch_;
};

}  // namespace clothsim
