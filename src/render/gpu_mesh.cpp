#include "clothsim/render/gpu_mesh.h"

#include <cassert>
#include <utility>

namespace clothsim {
namespace {

constexpr int floats_per_point = 9;  // position, normal, tangent

void upload(GLenum target, const Buffer& buffer, const void* data, std::size_t bytes, GLenum use) {
  glBindBuffer(target, buffer.id());
  glBufferData(target, static_cast<GLsizeiptr>(bytes), data, use);
}

const void* byte_offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Sets `count` attributes of the bound vertex array from `first` on: position, normal and tangent.
void take_from(const Buffer& surface, GLuint first, GLuint count) {
  glBindBuffer(GL_ARRAY_BUFFER, surface.id());
  for (GLuint i = 0; i < count; ++i) {
    glEnableVertexAttribArray(first + i);
    glVertexAttribPointer(first + i, 3, GL_FLOAT, GL_FALSE, floats_per_point * sizeof(float),
                          byte_offset(3 * sizeof(float) * i));
  }
}

// Attributes of shaders/surface.vert: position, normal and tangent, uv, position and normal before.
constexpr GLuint now = 0, uv_location = 3, before = 4;

}  // namespace

GpuMesh::GpuMesh() {
  glBindVertexArray(array_.id());
  take_from(surface_, now, 3);
  take_from(surface_, before, 2);
  glBindBuffer(GL_ARRAY_BUFFER, uv_.id());
  glEnableVertexAttribArray(uv_location);
  glVertexAttribPointer(uv_location, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void GpuMesh::upload_topology(const Eigen::Matrix<double, Eigen::Dynamic, 2>& uv,
                              const std::vector<std::array<int, 3>>& triangles,
                              const std::vector<std::array<int, 2>>& lines) {
  const Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> flat = uv.cast<float>();
  glBindVertexArray(array_.id());
  upload(GL_ARRAY_BUFFER, uv_, flat.data(), sizeof(float) * static_cast<std::size_t>(flat.size()),
         GL_STATIC_DRAW);
  upload(GL_ELEMENT_ARRAY_BUFFER, triangles_, triangles.data(),
         triangles.size() * sizeof(triangles[0]), GL_STATIC_DRAW);
  upload(GL_ELEMENT_ARRAY_BUFFER, lines_, lines.data(), lines.size() * sizeof(lines[0]),
         GL_STATIC_DRAW);
  num_triangles_ = static_cast<int>(triangles.size());
}

void GpuMesh::keep_surface() {
  std::swap(surface_, before_);
  glBindVertexArray(array_.id());
  take_from(surface_, now, 3);
  take_from(before_, before, 2);
}

void GpuMesh::stand_still() {
  glBindVertexArray(array_.id());
  take_from(surface_, before, 2);
}

void GpuMesh::upload_surface(const Points& positions, const Points& normals,
                             const Points& tangents) {
  assert(normals.rows() == positions.rows());
  scratch_.resize(static_cast<std::size_t>(positions.rows() * floats_per_point));
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, floats_per_point, Eigen::RowMajor>;
  Eigen::Map<Rows> rows(scratch_.data(), positions.rows(), floats_per_point);
  rows.leftCols<3>() = positions.cast<float>();
  rows.middleCols<3>(3) = normals.cast<float>();
  if (tangents.rows() == positions.rows()) {
    rows.rightCols<3>() = tangents.cast<float>();
  } else {
    rows.rightCols<3>().setZero();
  }
  upload(GL_ARRAY_BUFFER, surface_, scratch_.data(), scratch_.size() * sizeof(float),
         GL_STREAM_DRAW);
}

void GpuMesh::draw_triangles() const { draw_triangles({0, num_triangles_}); }

void GpuMesh::draw_triangles(const IndexRange& range) const { draw_triangles(triangles_, range); }

void GpuMesh::draw_triangles(const Buffer& indices, const IndexRange& range) const {
  glBindVertexArray(array_.id());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.id());
  glDrawElements(GL_TRIANGLES, 3 * range.count, GL_UNSIGNED_INT,
                 byte_offset(3 * sizeof(GLuint) * static_cast<std::size_t>(range.first)));
}

void GpuMesh::draw_lines(int first, int count) const {
  glBindVertexArray(array_.id());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, lines_.id());
  glDrawElements(GL_LINES, 2 * count, GL_UNSIGNED_INT,
                 byte_offset(2 * sizeof(GLuint) * static_cast<std::size_t>(first)));
}

}  // namespace clothsim
