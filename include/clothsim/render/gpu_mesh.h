#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "clothsim/model/types.h"
#include "clothsim/render/gl_handles.h"

namespace clothsim {

/// A mesh in the memory of the GPU: what stays (texture coordinates, triangles, lines) and what
/// moves (positions, normals, tangents) in buffers of their own. Shaders that ask are told where
/// the surface was before, too: where it is, unless keep_surface() says else.
class GpuMesh {
 public:
  GpuMesh();

  void upload_topology(const Eigen::Matrix<double, Eigen::Dynamic, 2>& uv,
                       const std::vector<std::array<int, 3>>& triangles,
                       const std::vector<std::array<int, 2>>& lines);

  /// The surface that is there now is the one before that of the next upload_surface(), which has
  /// as many points.
  void keep_surface();

  /// The surface before is the one that is there now.
  void stand_still();

  /// Uploads N points. `tangents` may be empty.
  void upload_surface(const Points& positions, const Points& normals, const Points& tangents);

  void draw_triangles() const;

  /// Draws `count` triangles of index buffer `indices`, from its `first` one on.
  void draw_triangles(const Buffer& indices, int first, int count) const;

  /// Draws `count` lines from the `first` one on.
  void draw_lines(int first, int count) const;

 private:
  VertexArray array_;
  Buffer uv_, surface_, before_, triangles_, lines_;
  int num_triangles_ = 0;
  std::vector<float> scratch_;
};

}  // namespace clothsim
